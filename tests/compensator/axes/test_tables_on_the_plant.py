"""A table that turns in the cut: the written program on a plant whose table is a joint of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.tasks.compensate import Done, compensate_file
from tests.compensator.axes.rail_plant import RailPlant, Written, pose
from tests.compensator.axes.table_plant import Coordinated
from tests.compensator.plant_bench import robot_file
from tests.compensator.small_job import ABB, CELL, STIFFNESS, files
from tests.plant.arm import Arm, Tool

CENTER = [1650.0, 60.0, 850.0]
TABLE: dict[str, Any] = {
    "carries": "part", "direction": [0.0, 0.0, 1.0], "center": [1650.0, 60.0, 0.0], "free": True,
    "range": [-350.0, 350.0], "speed": 9.0, "acceleration": 9.0,
    "unit": "STN1", "unit_xyz": [1650.0, 60.0, 500.0], "unit_rpy": [0.0, 0.0, 30.0],
}  # fmt: skip
WORK = {"xyz": [1690.0, 40.0, 850.0], "rpy": [0.0, 0.0, 15.0]}  # beside the middle of the table
NEAR = 2e-6  # m: what printing and rounding leave
CHORD = 0.05  # mm of [sampling]
FEED = 1200.0


def ring(begin: float, end: float, radius: float = 280.0, tilt: float = 0.0, step: float = 5.0) -> list[list[Any]]:
    """An arc about the work object's z, by points, the tool from outside; ``tilt``: deg up."""
    angle = np.radians(np.arange(begin, end + 1e-9, step))
    c, s, up = np.cos(angle), np.sin(angle), np.radians(tilt)
    axis = np.column_stack([c * np.cos(up), s * np.cos(up), np.full(len(c), np.sin(up))])
    at = np.column_stack([radius * c, radius * s, 0.1 * radius * s])
    out = at + 40.0 * axis
    rows = [[*p, *a, FEED, "cut"] for p, a in zip(at.tolist(), axis.tolist(), strict=True)]
    first, last = ([*out[k].tolist(), *axis[k].tolist(), 0, "rapid"] for k in (0, -1))
    return [first, *rows, last]


@dataclass(frozen=True)
class Run:
    """A job through the product, and its program on the plant."""

    done: Done
    program: Coordinated
    on_part: np.ndarray  # (N, 3) m, where the tool lands on the part
    between: np.ndarray  # (N - 1, 3) the same half way between two targets
    q: np.ndarray
    rows: np.ndarray

    def off(self, on_part: np.ndarray, cut: np.ndarray) -> np.ndarray:
        """(M,) m from the CAM path, of poses that cut."""
        cuts = self.rows[1:, 6] > 0
        ends = self.rows[:, :3] / 1e3
        a, along = ends[:-1][cuts], np.diff(ends, axis=0)[cuts]
        share = np.einsum("nki,ki->nk", on_part[cut][:, None] - a, along) / np.sum(along**2, axis=1)
        nearest = a + np.clip(share, 0, 1)[..., None] * along
        return np.linalg.norm(on_part[cut][:, None] - nearest, axis=2).min(axis=1)


def plant(tool_of: dict[str, Any], rails: list[list[float]]) -> RailPlant:
    xyz, com = np.array(tool_of["xyz"]) / 1e3, np.array(tool_of["com"]) / 1e3
    tool = Tool(xyz, np.radians(tool_of["rpy"]), tool_of["mass"], com)
    return RailPlant(Arm.load(robot_file(ABB), tool=tool, mount_rpy=np.zeros(3)), rails, np.array(STIFFNESS))


def run(folder: Path, rows: list[list[Any]], table: dict[str, Any] | None = None, **change: Any) -> Run:
    """The job, and its RAPID program on the plant; ``external``: more axes."""
    table = TABLE if table is None else table
    external = {**change.pop("external", {}), "E2": table}
    rails = [external["E1"]["direction"]] if "E1" in external else []
    tables = {"external": external, "workobject": WORK, "gravity": "uncompensated",
              "sampling": {"spacing": 30.0, "chord": CHORD}, **change}  # fmt: skip
    made = files(folder, tables, rows=rows)
    done = compensate_file(made.toolpath, made.cell, folder / "c.mod", json=folder / "c.json")
    program = Coordinated.read(folder / "c.mod")
    unit = pose(table["unit_xyz"], Rotation.from_euler("xyz", table["unit_rpy"], degrees=True))
    text = (folder / "c.mod").read_text()
    start = np.radians([float(v) for v in text.split("MoveAbsJ [[")[1].split("]")[0].split(",")])
    on_part, q = _landed(program.on_table(unit), table, rails, start)
    between, _ = _landed(program.between(0.5).on_table(unit), table, rails, q[0])
    plain = np.array([[*r[:7], r[7] == "cut"] for r in rows], dtype=float)
    return Run(done, program, on_part, between, q, plain)


def _landed(
    written: Written, table: dict[str, Any], rails: list[list[float]], start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) m on the part, and (N, n) rad commanded; the part turns about the axis that the cell gives the table."""
    still = pose(WORK["xyz"], Rotation.from_euler("xyz", WORK["rpy"], degrees=True))
    turn = Rotation.from_rotvec(np.radians(written.axes[:, 1, None]) * np.array(table["direction"]))
    center = np.array(table["center"])
    part = np.array([pose(center - t.apply(center), t) for t in turn]) @ still
    force = CELL["process"]["wrench"]
    wrench = np.concatenate([part[:, :3, :3] @ force[:3], part[:, :3, :3] @ force[3:]], axis=1)
    wrench = np.where(written.cut[:, None], wrench, 0.0)
    tcp, q = plant(CELL["tool"], rails).run(written, written.axes[:, : len(rails)] / 1e3, wrench, start)
    return (np.linalg.inv(part) @ tcp)[:, :3, 3], q


def smooth(one: Run, table: dict[str, Any]) -> None:
    """Within range, speed and acceleration at the programmed feed."""
    program, (low, high) = one.program, table["range"]
    assert low <= program.angle.min() and program.angle.max() <= high
    whole = program.cut[1:] & program.cut[:-1]
    step = np.linalg.norm(np.diff(program.target[:, :3, 3], axis=0), axis=1)[whole]
    way, lasts = np.diff(program.angle)[whole], step / (FEED / 60e3)
    long = lasts > 0.02
    speed = way[long] / lasts[long]
    assert np.abs(speed).max() <= 1.02 * table["speed"]
    bend = np.diff(speed) / ((lasts[long][1:] + lasts[long][:-1]) / 2)
    assert np.abs(bend).max() <= 1.1 * table["acceleration"]
    assert np.degrees(np.abs(np.diff(one.q, axis=0)).max()) < 30.0


@pytest.mark.parametrize(("speed", "acceleration"), [(9.0, 9.0), (4.5, 1.0)])
def test_a_ring_that_no_fixed_place_serves(tmp_path: Path, speed: float, acceleration: float) -> None:
    """The table turns the side that is cut to the arm; the tool lands where CAM has it, on the poses and between."""
    table = {**TABLE, "speed": speed, "acceleration": acceleration}
    one = run(tmp_path, ring(0.0, 290.0), table)
    told = one.done.report["external"]
    assert told["constant"] is None and told["axes"]["E2"]["moves"] and told["windows_failed"] == 0
    assert one.program.unit == "STN1" and np.ptp(one.program.angle) > 150.0
    assert told["axes"]["E2"]["travel_deg"] < 400.0 and told["axes"]["E2"]["fastest_deg_per_s"] <= speed * 1.001
    assert one.off(one.on_part, one.program.cut).max() < NEAR
    between = one.off(one.between, one.program.between(0.5).cut)
    assert between.max() < CHORD * 1e-3
    smooth(one, table)
    assert any("no fixed place serves" in str(f) for f in one.done.findings)


def test_where_a_fixed_place_costs_more(tmp_path: Path) -> None:
    """A quarter of a ring on a table that leans: turning costs clearly less, and by how much is told."""
    lean = Rotation.from_euler("y", -20, degrees=True)
    table = {**TABLE, "direction": lean.apply([0.0, 0.0, 1.0]).tolist(), "center": [1650.0, 60.0, 700.0],
             "unit_xyz": [1650.0, 60.0, 700.0], "unit_rpy": [0.0, -20.0, 0.0]}  # fmt: skip
    one = run(tmp_path, ring(100.0, 190.0, tilt=30.0), table)
    told = one.done.report["external"]
    assert told["axes"]["E2"]["moves"] and told["chosen"]["cost_um2"]["sum"] < 0.9 * told["constant"]["cost_um2"]["sum"]
    assert one.off(one.on_part, one.program.cut).max() < NEAR
    assert one.off(one.between, one.program.between(0.5).cut).max() < CHORD * 1e-3
    smooth(one, table)
    assert any("all along would be" in str(f) for f in one.done.findings)


def test_a_rail_moves_beside(tmp_path: Path) -> None:
    """Both go along: the base past a long part, the part round."""
    rail = {"carries": "robot", "direction": [0.0, 0.6, 0.8], "free": True, "range": [-200.0, 200.0], "speed": 40.0,
            "acceleration": 30.0}  # fmt: skip
    one = run(tmp_path, ring(0.0, 240.0, tilt=20.0), external={"E1": rail})
    told = one.done.report["external"]["axes"]
    assert told["E2"]["moves"] and told["E2"]["travel_deg"] > 30.0
    assert one.off(one.on_part, one.program.cut).max() < NEAR
    assert one.off(one.between, one.program.between(0.5).cut).max() < CHORD * 1e-3
    smooth(one, TABLE)
    assert np.abs(one.program.rail).max() > 1.0
