"""Rails and tables that are chosen: the written program on a plant whose rail is a joint of its own."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.tasks.compensate import Done, compensate_file
from tests.compensator.axes.rail_plant import RailPlant, Written, pose
from tests.compensator.plant_bench import robot_file
from tests.compensator.small_job import ABB, CELL, STIFFNESS, files
from tests.plant.arm import Arm, Tool

FORCE = CELL["process"]["wrench"]
WORK, WORK_TURN = CELL["workobject"]["xyz"], Rotation.from_euler("z", 20, degrees=True)
TOOL = CELL["tool"]


@dataclass(frozen=True)
class Run:
    """A job through the product, and its program on the plant."""

    done: Done
    written: Written
    part: np.ndarray  # (4, 4) of the work object in the world, where the table has it
    tcp: np.ndarray
    q: np.ndarray
    rows: np.ndarray  # (M, 8) of the toolpath

    def off(self) -> np.ndarray:
        """(N,) m from the CAM path, of poses that cut; and their tool axes are those of CAM."""
        on_part = (np.linalg.inv(self.part) @ self.tcp)[self.written.cut]
        ends = self.rows[:, :3] / 1e3
        a, b = ends[:-1][self.cuts], ends[1:][self.cuts]
        along = b - a
        share = np.einsum("nki,ki->nk", on_part[:, None, :3, 3] - a, along) / np.sum(along**2, axis=1)
        nearest = a + np.clip(share, 0, 1)[..., None] * along
        return np.linalg.norm(on_part[:, None, :3, 3] - nearest, axis=2).min(axis=1)

    @property
    def cuts(self) -> np.ndarray:
        return self.rows[1:, 6] > 0

    def corners(self) -> float:
        """m, by which the worst end of a cut is missed."""
        on_part = (np.linalg.inv(self.part) @ self.tcp)[self.written.cut][:, :3, 3]
        ends = self.rows[1:, :3][self.cuts] / 1e3
        return float(np.linalg.norm(on_part[:, None] - ends, axis=2).min(axis=0).max())


def path(*cuts: tuple[float, float, float], feed: float = 1200.0) -> list[list[Any]]:
    """Down to the first point, along the others, up."""
    first, last = cuts[0], cuts[-1]
    rows: list[list[Any]] = [[*first[:2], 60, 0, 0, 1, 0, "rapid"], [*first[:2], 5, 0, 0, 1, 0, "rapid"]]
    rows += [[*p, 0, 0, 1, feed, "cut"] for p in cuts]
    return [*rows, [*last[:2], 60, 0, 0, 1, 0, "rapid"]]


def run(folder: Path, external: dict[str, Any], rows: list[list[Any]], change: dict[str, Any] | None = None) -> Run:
    """The job, and its program on the plant; rails and tables in the order E1, E2."""
    made = files(folder, {"gravity": "uncompensated", "external": external, **(change or {})}, rows=rows)
    done = compensate_file(made.toolpath, made.cell, folder / "c.mod", json=folder / "c.json")
    written = Written.read(folder / "c.mod")
    tool = Tool(np.array(TOOL["xyz"]) / 1e3, np.radians(TOOL["rpy"]), TOOL["mass"], np.array(TOOL["com"]) / 1e3)
    mount = np.radians((change or {}).get("mount", {}).get("rpy", (0, 0, 0)))
    arm = Arm.load(robot_file(ABB), tool=tool, mount_rpy=mount)
    names = list(external)
    rails = [k for k, name in enumerate(names) if external[name]["carries"] == "robot"]
    part = pose(WORK, WORK_TURN)
    for name in names:
        if external[name]["carries"] == "part":
            part = turned(external[name], written.axes[0, int(name[1]) - 1]) @ part
    places = np.stack([written.axes[:, int(names[k][1]) - 1] / 1e3 for k in rails], axis=1) if rails else None
    places = np.zeros((len(written.target), 0)) if places is None else places
    wrench = np.concatenate([part[:3, :3] @ FORCE[:3], part[:3, :3] @ FORCE[3:]])
    wrench = np.where(written.cut[:, None], wrench, 0.0)
    plant = RailPlant(arm, [external[names[k]]["direction"] for k in rails], np.array(STIFFNESS))
    begin = (folder / "c.mod").read_text().split("MoveAbsJ [[")[1].split("]")[0]
    start = np.radians([float(v) for v in begin.split(",")])
    tcp, q = plant.run(written, places, wrench, start)
    table = np.array([[*r[:7], r[7] == "cut"] for r in rows], dtype=float)
    return Run(done, written, part, tcp, q, table)


def turned(table: dict[str, Any], angle: float) -> np.ndarray:
    """(4, 4) of a turn about the axis of a table, deg."""
    turn = Rotation.from_rotvec(np.radians(angle) * np.array(table["direction"]))
    center = np.array(table["center"])
    return pose(center - turn.apply(center), turn)


def smooth(one: Run, axis: int, limits: dict[str, Any]) -> None:
    """Within range, speed and acceleration at the programmed feeds, on the part."""
    places, on_part = one.written.axes[:, axis], one.written.target[:, :3, 3] * 1e3
    low, high = limits["range"]
    assert low <= places.min() and places.max() <= high
    cut = one.written.cut
    step = np.linalg.norm(np.diff(on_part, axis=0), axis=1)[cut[1:] & cut[:-1]]
    way, lasts = np.diff(places)[cut[1:] & cut[:-1]], step / (1200.0 / 60.0)
    whole = lasts > 0.05
    speed = way[whole] / lasts[whole]
    assert np.abs(speed).max() <= 1.02 * limits["speed"]
    bend = np.diff(speed) / ((lasts[whole][1:] + lasts[whole][:-1]) / 2)
    assert np.abs(bend).max() <= 1.1 * limits["acceleration"]
    assert np.degrees(np.abs(np.diff(one.q, axis=0)).max()) < 30.0


RAIL = {"carries": "robot", "direction": [0.0, 1.0, 0.0], "free": True, "range": [-2500.0, 3000.0], "speed": 60.0,
        "acceleration": 40.0}  # fmt: skip
LONG = path((0, 0, -2), (0, 4800, -2), (40, 4800, -2), (40, 3000, -2))
NEAR = 2e-6  # m: what printing and rounding leave


def test_a_path_that_is_longer_than_the_reach(tmp_path: Path) -> None:
    """No fixed place serves; the rail goes along and back, smoothly, and the tool lands where CAM has it."""
    one = run(tmp_path, {"E1": RAIL}, LONG)
    told = json.loads((tmp_path / "c.json").read_text())["external"]
    assert told["constant"] is None and told["axes"]["E1"]["moves"] and told["windows_failed"] == 0
    assert one.off().max() < NEAR and one.corners() < NEAR
    smooth(one, 0, RAIL)
    assert 2000.0 < told["axes"]["E1"]["travel_mm"] < 9000.0
    moved = one.written.axes[:, 0]
    assert told["axes"]["E1"]["least_mm"] <= moved.min() and moved.max() <= told["axes"]["E1"]["greatest_mm"]
    turns = np.diff(np.sign(np.diff(moved)[np.abs(np.diff(moved)) > 1e-3]))
    assert np.count_nonzero(turns) <= 4  # there and back, no seeking
    assert any("no fixed place serves" in str(f) for f in one.done.findings)


def test_a_rail_that_moves_where_a_fixed_one_reaches(tmp_path: Path) -> None:
    """At the end of its reach the arm is soft: going along costs less, and by how much is told."""
    one = run(tmp_path, {"E1": RAIL}, path((0, 0, -2), (0, 3400, -2)))
    told = one.done.report["external"]
    assert told["axes"]["E1"]["moves"] and told["chosen"]["cost_um2"]["sum"] < 0.9 * told["constant"]["cost_um2"]["sum"]
    assert one.off().max() < NEAR
    smooth(one, 0, RAIL)
    assert any("all along would be" in str(f) for f in one.done.findings)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_random_rails(tmp_path: Path, seed: int) -> None:
    """Rails of any direction, robots that stand, hang and lean: gravity stays that of the world."""
    rng = np.random.default_rng(seed)
    way = np.array([*rng.normal(size=2), 0.3 * rng.normal()])
    rail = {**RAIL, "direction": (way / np.linalg.norm(way)).tolist(), "range": [-400.0, 1100.0]}
    mount = {"mount": {"rpy": [float(v) for v in ((0, 0, 0), (180, 0, 0), (0, 30, 0))[seed - 1]]}}
    corners = [tuple(v) for v in np.column_stack([rng.uniform(-150, 150, (4, 2)), [-2, -3, -2, -4]]).tolist()]
    one = run(tmp_path, {"E1": rail}, path(*corners), mount)
    assert one.off().max() < NEAR and one.corners() < NEAR
    smooth(one, 0, rail)


def test_a_table_is_set_where_it_costs_least(tmp_path: Path) -> None:
    """The work object of the program is where the table holds it; force and path turn with it."""
    table = {"carries": "part", "direction": [0.0, 0.6, 0.8], "center": [1450.0, 0.0, 700.0], "free": True,
             "range": [-120.0, 150.0]}  # fmt: skip
    one = run(tmp_path, {"E2": table}, path((0, 0, -2), (120, 20, -2), (60, 90, -6)))
    angle = one.written.axes[:, 1]
    assert np.ptp(angle) == 0.0 and abs(angle[0]) > 1.0
    np.testing.assert_allclose(one.written.work, one.part, atol=2e-7)
    assert one.off().max() < NEAR and one.corners() < NEAR
    told = one.done.report["external"]
    assert told["constant"]["places"]["E2"] == pytest.approx(angle[0]) and told["axes"]["E2"]["travel_deg"] == 0.0


def test_a_rail_and_a_table(tmp_path: Path) -> None:
    table = {"carries": "part", "direction": [0.0, 0.0, 1.0], "center": [1500.0, 0.0, 700.0], "free": True,
             "range": [-90.0, 90.0]}  # fmt: skip
    rail = {**RAIL, "direction": [1.0, 0.0, 0.0], "range": [-300.0, 700.0]}
    one = run(tmp_path, {"E1": rail, "E2": table}, path((0, 0, -2), (150, 0, -2), (150, 100, -2)))
    assert one.off().max() < NEAR and one.corners() < NEAR
    smooth(one, 0, rail)
    assert np.ptp(one.written.axes[:, 1]) == 0.0 and np.isfinite(one.written.axes[:, :2]).all()


def test_two_rails(tmp_path: Path) -> None:
    """A gantry, along a diagonal that no fixed place reaches."""
    rails = {
        "E1": {**RAIL, "range": [-500.0, 2500.0]},
        "E2": {**RAIL, "direction": [1.0, 0.0, 0.0], "range": [-500.0, 2500.0]},
    }
    one = run(tmp_path, rails, path((0, 0, -2), (2200, 2200, -2)))
    assert one.off().max() < NEAR and one.corners() < NEAR
    for k, name in enumerate(rails):
        smooth(one, k, rails[name])


def test_a_rail_at_the_end_of_its_range(tmp_path: Path) -> None:
    """The part is barely reached from the end: the axis stands there, not beyond, and the finding says so."""
    rail = {**RAIL, "direction": [-1.0, 0.0, 0.0], "range": [0.0, 1200.0]}
    far = {"workobject": {"xyz": [2350.0, -150.0, 800.0]}}
    made = files(tmp_path, {"external": {"E1": rail}, **far}, rows=path((0, 0, -2), (60, 0, -2)))
    done = compensate_file(made.toolpath, made.cell, tmp_path / "c.mod")
    written = Written.read(tmp_path / "c.mod")
    places = written.axes[:, 0]
    assert (places == 0.0).all()
    assert any("stands at the end of its range, 0 mm" in str(f) for f in done.findings)
