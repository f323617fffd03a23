"""Real CAM files to RAPID and KRL on every built-in robot, read back by readers that know nothing of our writers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from scipy.spatial.transform import Rotation

from compensator.program.export import program_of
from compensator.solve.compensation import Compensation
from compensator.tasks.compensate import compensate_file
from stiffness.model.model import builtin_model
from stiffness.robot.load import builtin_robots, load_robot
from tests.compensator.posture_toolpaths import frame
from tests.compensator.small_job import write_csv
from tests.oracles import krl_reader, rapid_reader
from toolpaths.files import write_program

FUSION, NX, OWN = "gcode_fusion/1110_wall_265bit.nc", "clsf_nx/ust_a.cls", "own.csv"
TOOL_NUMBER = {FUSION: 1, NX: 2, OWN: 1}
LARGE = {"xyz": [20.0, -10.0, 250.0], "rpy": [0.0, 30.0, 0.0], "mass": 30.0, "com": [0.0, 0.0, 110.0]}
SMALL = {"xyz": [0.0, 0.0, 100.0], "mass": 2.0, "com": [0.0, 0.0, 40.0]}
SOFT = [3e4, 3e4, 2e4, 6e3, 5e3, 5e3]  # N*m/rad, of the order of a UR10's
WRENCH = (-200.0, 120.0, -90.0, 3.0, 2.0, 1.0)
DOWN, TURNED = [0.0, 0.0, 0.0], [180.0, 0.0, 0.0]  # ust_a cuts with the tool along -z of its MCS


@dataclass(frozen=True)
class Place:
    """Where a robot has the part: mm, deg, and the start that an arm without closed form needs to be quick."""

    xyz: list[float]
    start: list[float] | None = None


PLACES: dict[tuple[str, str], Place] = {
    ("abb-irb6600-175-255", FUSION): Place([1500.0, 0.0, 700.0]),
    ("abb-irb6600-175-255", NX): Place([1500.0, 0.0, 700.0]),
    ("kuka-kr210-r2700", FUSION): Place([1700.0, 0.0, 900.0]),
    ("kuka-kr210-r2700", NX): Place([1700.0, 0.0, 900.0]),
    ("kuka-kr240-class", FUSION): Place([1700.0, 0.0, 900.0]),
    ("kuka-kr240-class", NX): Place([1700.0, 0.0, 900.0]),
    ("kuka-kr500", FUSION): Place([1800.0, 0.0, 900.0]),
    ("kuka-kr500", NX): Place([1800.0, 0.0, 900.0]),
    ("ur10", FUSION): Place([600.0, -200.0, 200.0], [-3.0, -93.0, -123.0, -54.0, 90.0, -93.0]),
    ("ur10", NX): Place([258.0, 118.7, 215.5], [14.0, -41.0, -133.0, -96.0, 90.0, -76.0]),
}  # fmt: skip


def test_every_built_in_robot_has_its_places() -> None:
    """A robot that is added is added here."""
    assert {robot for robot, _ in PLACES} == set(builtin_robots())


def own_path(folder: Path) -> Path:
    """A 5-axis path: a wave with the tool normal to it, the tool lifted at both ends."""
    x = np.linspace(0, 200, 101)
    z, slope = 6 * np.sin(x / 25), 6 / 25 * np.cos(x / 25)
    axis = np.column_stack([-slope, 0.15 * np.sin(x / 40), np.ones_like(x)])
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    rows = [[a, 10 * np.sin(a / 60), b, *n, 900, "cut"] for a, b, n in zip(x, z, axis.tolist(), strict=True)]
    rapid = [[*(np.array(r[:3]) + 30 * np.array(r[3:6])), *r[3:6], 0, "rapid"] for r in (rows[0], rows[-1])]
    header = ("x_mm", "y_mm", "z_mm", "i", "j", "k", "feed_mm_min", "kind")
    return write_csv(folder / OWN, header, [rapid[0], *rows, rapid[1]])


def cell(folder: Path, robot: str, source: str, place: Place) -> tuple[Path, dict[str, Any]]:
    """A cell with the robot's published stiffness, or a soft one where none is published."""
    known = builtin_model(robot)
    made = tomli_w.dumps({"schema": "model/1", "robot": robot, "effects": {"joint-stiffness": {"k_nm_per_rad": SOFT}}})
    (folder / "m.toml").write_text(known.read_text() if known else made)
    scale = 1.0 if known else 0.1
    table: dict[str, Any] = {
        "schema": "cell/1", "robot": robot, "model": "m.toml", "gravity": "calibrated-out",
        "tools": {str(TOOL_NUMBER[source]): LARGE if known else SMALL},
        "workobject": {"xyz": place.xyz, "rpy": TURNED if source == NX else DOWN},
        "process": {"kind": "constant", "frame": "path", "wrench": [w * scale for w in WRENCH]},
    }  # fmt: skip
    if source == OWN:
        table["tool"] = table.pop("tools")["1"]
    if place.start:
        table |= {"start": {"joints": place.start}, "solve": {"free_tool_axis": False}}
    (folder / "c.toml").write_text(tomli_w.dumps(table))
    return folder / "c.toml", table


def commands(result: Compensation, table: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) mm and (N, 3, 3) of the commands in the work object, from the commanded angles by Pinocchio."""
    tool = table.get("tool") or next(iter(table["tools"].values()))
    arm, back, hand = load_robot(table["robot"]), np.linalg.inv(frame(table["workobject"])), frame(tool)
    poses = np.array([back @ arm.pose(q) @ hand for q in result.command.q])
    return poses[:, :3, 3] * 1e3, poses[:, :3, :3]


def check_rapid(path: Path, result: Compensation, table: dict[str, Any]) -> None:
    """Robtargets, frames and the first joint move, as a controller would read them."""
    moves, _ = rapid_reader.read(path)
    lines = [m for m in moves if m.word == "MoveL"]
    assert len(lines) == len(result) and moves[0].word == "MoveAbsJ"
    position, rotation = commands(result, table)
    assert np.abs(np.array([m.target[0] for m in lines]) - position).max() < 0.51e-4
    got = Rotation.from_quat(np.array([m.target[1] for m in lines])[:, [1, 2, 3, 0]])
    assert (got * Rotation.from_matrix(rotation).inv()).magnitude().max() < 2e-7
    first = table.get("start", {}).get("joints") or np.degrees(result.command.q[0])
    assert np.abs(np.array(moves[0].target[0]) - first).max() < 1e-4
    feed = np.array([m.speed[0] for m in lines])
    cut = result.cutting
    assert np.allclose(feed[cut], result.path.toolpath.feed[cut] * 1e3, rtol=1e-4)
    for m in (lines[0], lines[-1]):
        uframe = np.array(m.wobj[3][0] if len(m.wobj) > 3 else m.wobj[2][0])
        assert np.allclose(uframe, table["workobject"]["xyz"], atol=1e-4)
        tool = table.get("tool") or next(iter(table["tools"].values()))
        assert np.allclose(m.tool[1][0], tool["xyz"], atol=1e-4) and m.tool[2][0] == pytest.approx(tool["mass"])


def check_krl(path: Path, result: Compensation, table: dict[str, Any]) -> None:
    """LIN targets with Status and Turn, $BASE and $TOOL."""
    state = krl_reader.read(path)
    lines = [m for m in state.moves if m.word == "LIN"]
    assert len(lines) == len(result) and state.moves[0].word == "PTP"
    position, rotation = commands(result, table)
    assert np.abs(np.array([[m.target[k] for k in "XYZ"] for m in lines]) - position).max() < 0.51e-4
    angles = np.array([[m.target[k] for k in "ABC"] for m in lines])
    got = Rotation.from_euler("ZYX", angles, degrees=True)
    assert (got * Rotation.from_matrix(rotation).inv()).magnitude().max() < 1e-6
    spherical = program_of(result).configuration is not None
    assert all(("T" in m.target) == ("S" in m.target) == spherical for m in lines)
    turn = np.array([int(m.target["T"]) for m in lines]) if spherical else np.zeros(0, dtype=int)
    for axis in range(6 if spherical else 0):
        q = np.degrees(result.command.q[:, axis])
        clear = np.abs(q) > 1e-5
        assert np.array_equal((turn >> axis & 1)[clear] == 1, q[clear] < 0)
    base = state.values["$BASE"]
    assert np.allclose([base[k] for k in "XYZ"], table["workobject"]["xyz"], atol=1e-4)
    tool = table.get("tool") or next(iter(table["tools"].values()))
    assert np.allclose([state.values["$TOOL"][k] for k in "XYZ"], tool["xyz"], atol=1e-4)


def check(folder: Path, source: Path, robot: str, place: Place) -> None:
    """Through compensate to RAPID, and the same solve to KRL; both read back."""
    path, table = cell(
        folder, robot, source.name if source.name == OWN else f"{source.parent.name}/{source.name}", place
    )
    done = compensate_file(source, path, folder / "part.mod")
    error = done.report["predicted_error_mm"]
    assert error["before"]["max"] > 0.1
    assert error["after"]["p95"] < 1e-3 and error["after"]["mean"] < 1e-3 and error["after"]["max"] < 0.02
    check_rapid(folder / "part.mod", done.result, table)
    write_program(program_of(done.result), folder / "part.src")
    check_krl(folder / "part.src", done.result, table)


@pytest.mark.parametrize("robot", builtin_robots())
def test_five_axis_nx(tmp_path: Path, shared: Path, robot: str) -> None:
    """clsf_nx/ust_a.cls, tool 2."""
    check(tmp_path, shared / "data" / "cam" / NX, robot, PLACES[robot, NX])


@pytest.mark.parametrize("robot", builtin_robots())
def test_three_axis_fusion(tmp_path: Path, shared: Path, robot: str) -> None:
    """gcode_fusion/1110_wall_265bit.nc, tool 1: 5,000 moves, 20,000 poses."""
    check(tmp_path, shared / "data" / "cam" / FUSION, robot, PLACES[robot, FUSION])


@pytest.mark.parametrize("robot", builtin_robots())
def test_own_csv(tmp_path: Path, robot: str) -> None:
    """A wave of this test's own, through compensate for both languages."""
    place = PLACES[robot, FUSION]
    source = own_path(tmp_path)
    check(tmp_path, source, robot, place)
    path, table = cell(tmp_path, robot, OWN, place)
    (tmp_path / "part.src").unlink()
    done = compensate_file(source, path, tmp_path / "part.src")
    check_krl(tmp_path / "part.src", done.result, table)
