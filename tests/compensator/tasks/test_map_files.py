"""stiffness-map: from a model file to a table and a picture, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import tomli_w

from compensator.cell.placement_tables import ToolTable
from compensator.errors import CompensatorError
from compensator.report.figures.stiffness_map import draw, panels
from compensator.tasks.joint_grid import grid_of
from compensator.tasks.stiffness_map import Mapped, map_file, tool_of
from stiffness.errors import StiffnessError
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from tests.compensator.small_job import ABB, MODEL, STIFFNESS
from tests.oracles.elastic_arm import ElasticArm, Push
from tests.stiffness.model.test_datasheet import robot_text

Floats = npt.NDArray[np.float64]
HALF = [True, True, True, False, False, True]
COARSE = "-60:60:40,-150:60:30"


def model(folder: Path, **changes: Any) -> Path:
    path = folder / "model.toml"
    path.write_text(tomli_w.dumps({**MODEL, **changes}))
    return path


def mapped(folder: Path, *, spans: str = COARSE, **options: Any) -> Mapped:
    return map_file(model(folder), spans=spans, **options)


# ---------------------------------------------------------------------------------------------- the grid


def test_grid_by_hand() -> None:
    grid = grid_of(load_robot(ABB), "3,5", "-20:25:10,30:31:0.5", "1=10, 2=-5.5,4=7")
    assert (
        grid.joints == (2, 4)
        and grid.first.tolist() == [-20, -10, 0, 10, 20]
        and grid.second.tolist() == [30, 30.5, 31]
    )
    q = np.degrees(grid.q)
    assert q.shape == (15, 6)
    np.testing.assert_allclose(q[4], [10, -5.5, -10, 7, 30.5, 45])
    np.testing.assert_allclose(grid.over(np.arange(15))[1], [3, 4, 5])


def test_grid_without_words_goes_from_limit_to_limit() -> None:
    """Joint 2 from -65 to 80, joint 3 from -180 to 60; joints 1 at 0 and 4 to 6 at 45; one turn at most."""
    grid = grid_of(load_robot(ABB), "2,3", None, None)
    assert (grid.first[0], grid.first[-1], grid.second[0], grid.second[-1]) == (-65, 80, -180, 60)
    assert np.diff(grid.first).tolist() == [5.0] * 29 and grid.fixed[[0, 3, 4, 5]].tolist() == [0, 45, 45, 45]
    turn = grid_of(load_robot("ur10"), "1,6", None, None)
    assert (turn.first[0], turn.first[-1]) == (-180, 180)


@pytest.mark.parametrize(
    ("joints", "spans", "fixed", "message"),
    [
        ("2", None, None, "--robot-joints '2': expected two joints out of 1 ... 6"),
        ("2,2", None, None, "--robot-joints '2,2'"),
        ("0,3", None, None, "--robot-joints '0,3'"),
        ("2,7", None, None, "--robot-joints '2,7'"),
        ("2,x", None, None, "--robot-joints '2,x'"),
        ("2,3", "-65:75:5", None, "--grid '-65:75:5': expected two ranges"),
        ("2,3", "-65:75,0:5:1", None, "--grid '-65:75' for joint 2: expected LOW:HIGH:STEP"),
        ("2,3", "75:-65:5,0:5:1", None, "--grid '75:-65:5' for joint 2"),
        ("2,3", "0:5:1,-65:75:0", None, "--grid '-65:75:0' for joint 3"),
        ("2,3", "0:5:1,0:5:9", None, "--grid '0:5:9' for joint 3: .* fits in between"),
        ("2,3", "0:5:1,0:nan:1", None, "--grid: 'nan' is not a number"),
        ("2,3", "0:5:1,0:5:1e-300", None, "more than 250000 steps"),
        ("2,3", "0:50:0.1,0:50:0.1", None, "251001 postures are more than 250000"),
        ("2,3", None, "4", "--fixed '4': expected JOINT=ANGLE"),
        ("2,3", None, "7=1", "--fixed '7=1': expected JOINT=ANGLE"),
        ("2,3", None, "4=1_0", "--fixed: '1_0' is not a number"),
        ("2,3", None, "2=1", "joint 2 varies over the grid"),
        ("2,3", None, "4=1,4=1", "joint 4 stands there twice"),
        ("2,3", None, "5=130", "joint 5 at 130 deg is outside its limits -120 ... 120 deg"),
    ],
)
def test_wrong_words_are_refused(joints: str, spans: str | None, fixed: str | None, message: str) -> None:
    with pytest.raises(CompensatorError, match=message):
        grid_of(load_robot(ABB), joints, spans, fixed)


# ---------------------------------------------------------------------------------------------- the outputs


def torque(arm: Robot, q: Floats, point: Floats, wrench: Floats) -> Floats:
    """(6,) N*m that a wrench about a point of the flange frame does to the joints."""
    force, lever = wrench[:3], arm.pose(q)[:3, :3] @ point
    return arm.jacobian(q).T @ np.r_[force, wrench[3:] + np.cross(lever, force)]


def between(loaded: Floats, free: Floats, point: Floats) -> Floats:
    """(3,) m that a point of a frame has moved."""
    return ((loaded - free) @ np.r_[point, 1.0])[:3]


def test_table_against_virtual_work(tmp_path: Path) -> None:
    """Deflection, K_c and nu of a row, by an engine of its own; blank where the arm is singular."""
    tool = ToolTable(xyz=(30.0, -20.0, 240.0), mass=30.0, com=(10.0, 0.0, 110.0))
    wrench = (300.0, -200.0, -2500.0, 20.0, 10.0, -30.0)
    done = mapped(
        tmp_path, spans="-60:60:40,-158:62:20", wrench=wrench, tool=tool, csv=tmp_path / "m.csv", fixed="1=30"
    )
    with open(tmp_path / "m.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 4 * 12 == done.report["n_postures"]
    blank = [r for r in rows if r["status"] != "ok"]
    assert {r["status"] for r in blank} == {"limit", "singular"} and all(
        r["nu_p"] == r["softest_x"] == "" for r in blank
    )
    arm, held = load_robot(ABB), tool.tool()
    for row in (rows[2], rows[30]):
        assert row["status"] == "ok"
        q = np.radians([float(row[f"q{k}_deg"]) for k in range(1, 7)])
        assert row["q1_deg"] == "30" and row["q5_deg"] == "45"
        law = ElasticArm(arm, lambda tau, a: tau / np.array(STIFFNESS), masses=((6, held.mass, held.com),))
        pushes = [Push(6, held.position, np.array(wrench))]
        moved = {"exact": between(*(law.links(q, law.solve(q, p)[0])[6] for p in (pushes, [])), held.position)}
        weight = torque(arm, q, held.com, np.array([0, 0, -9.80665 * held.mass, 0, 0, 0])) + arm.gravity_torque(q)
        load = torque(arm, q, held.position, np.array(wrench))  # at the posture without any load
        rigid = (arm.pose(q + t / STIFFNESS) for t in (weight + load, weight))
        moved["rigid"] = between(*rigid, held.position)
        got = np.array([float(row[f"d{a}_mm"]) for a in "xyz"]) / 1e3
        np.testing.assert_allclose(got, moved["exact"], atol=2e-10)
        shift = np.linalg.norm(moved["exact"] - moved["rigid"])
        sizes = [np.linalg.norm(m) for m in moved.values()]
        np.testing.assert_allclose(float(row["kc_shift_um"]) * 1e-6, shift, rtol=1e-5)
        np.testing.assert_allclose(float(row["nu_p"]), shift / max(sizes), rtol=1e-5)
        np.testing.assert_allclose(float(row["deflection_mm"]) / 1e3, sizes[0], rtol=1e-6)
        pose = arm.pose(q)
        place = pose[:3, :3] @ held.position + pose[:3, 3]
        np.testing.assert_allclose([float(row[f"{a}_mm"]) for a in "xyz"], place * 1e3, atol=1e-4)


def test_json_says_where_the_extremes_are(tmp_path: Path) -> None:
    done = mapped(tmp_path, json=tmp_path / "m.json", weight=False)
    report = json.loads((tmp_path / "m.json").read_text())
    assert report == done.report
    result = done.result
    k = int(np.nanargmax(result.deflection))
    np.testing.assert_allclose(report["deflection_max"]["mm"], result.deflection[k] * 1e3)
    np.testing.assert_allclose(report["deflection_max"]["q_deg"], np.degrees(result.q[k]), atol=1e-6)
    np.testing.assert_allclose(report["stiffness_min"]["n_per_um"], np.nanmin(result.softest[0]) * 1e-6)
    counts = [report[f"n_{s}"] for s in ("ok", "limit", "singular", "no_equilibrium")]
    assert sum(counts) == report["n_postures"] == 32 and report["n_ok"] > 20
    assert "without weight: gravity takes no part" in report["notes"]


def test_picture_is_readable_and_the_same_twice(tmp_path: Path) -> None:
    """A PNG with much colour, drawn over what was there; not a byte depends on the run."""
    for name in ("a.png", "b.png"):
        (tmp_path / name).write_text("old")
        mapped(tmp_path, png=tmp_path / name, weight=False)
    first = (tmp_path / "a.png").read_bytes()
    assert first[:8] == b"\x89PNG\r\n\x1a\n" and first == (tmp_path / "b.png").read_bytes()
    from matplotlib.image import imread

    image = imread(tmp_path / "a.png")
    assert image.shape[0] > 800 and image.shape[1] > 1400
    colours = np.unique((image[::4, ::4, :3] * 255).astype(int).reshape(-1, 3), axis=0)
    assert len(colours) > 60
    grey = np.all(np.abs(image[..., :3] - 0.82) < 0.01, axis=-1)
    assert 0.001 < grey.mean() < 0.3  # singular rows are left blank


def test_panels_carry_their_unit(tmp_path: Path) -> None:
    done = mapped(tmp_path, weight=False)
    shown = {p.title.split(",")[0]: p.values for p in panels(done.grid, done.result)}
    assert len(shown) == 6 and all(v.shape == (4, 8) for v in shown.values())
    np.testing.assert_allclose(shown["deflection under the wrench"], done.grid.over(done.result.deflection * 1e3))
    np.testing.assert_allclose(shown["moved by K_c"], done.grid.over(done.result.shift * 1e6))


def test_a_field_without_contrast_is_drawn(tmp_path: Path) -> None:
    """Turning joints 1 and 6 under a vertical force changes nothing."""
    done = mapped(tmp_path, joints="1,6", spans="-90:90:45,-90:90:45", wrench=(0.0, 0, -900, 0, 0, 0), weight=False)
    assert np.ptp(done.result.deflection) < 1e-9
    draw(done.grid, done.result, "flat", tmp_path / "flat.png")
    assert (tmp_path / "flat.png").stat().st_size > 10_000


def test_unknown_flanks_and_assumptions_are_said(tmp_path: Path) -> None:
    effects = {**MODEL["effects"], "backlash": {"gap_rad": [1e-4] * 6}}
    done = map_file(
        model(tmp_path, effects=effects, provenance={"kind": "assumption", "source": "a guess"}), spans=COARSE
    )
    notes = "\n".join(done.report["notes"])
    assert (
        "backlash: no path, no flank" in notes
        and "an assumption: a guess" in notes
        and "the tool weighs nothing" in notes
    )
    np.testing.assert_allclose(done.result.displacement, mapped(tmp_path).result.displacement, equal_nan=True)


def test_an_effect_of_another_tool_is_not_applied(tmp_path: Path) -> None:
    soft = {"tool": "spindle-a", "linear_m_per_n": [1e-6] * 3, "angular_rad_per_nm": [0.0] * 3}
    path = model(tmp_path, effects={**MODEL["effects"], "tool-compliance": soft})
    other = map_file(path, spans=COARSE, tool=ToolTable(xyz=(0.0, 0.0, 250.0)))
    assert other.report["not_applied"] == ["tool-compliance"]
    same = map_file(path, spans=COARSE, tool=ToolTable(xyz=(0.0, 0.0, 250.0), name="spindle-a"))
    assert same.report["not_applied"] == []
    softer = 1 / same.result.softest[0] - 1 / other.result.softest[0]
    np.testing.assert_allclose(softer[np.isfinite(softer)], 1e-6, rtol=0.01)


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({}, {"wrench": (0.0,) * 6}, "--wrench .*: expected six finite numbers, not all zero"),
        ({}, {"wrench": (np.nan, *(0.0,) * 5)}, "--wrench .*: expected six finite numbers"),
        ({}, {"fixed": "5=0"}, "nothing to map: 32 postures, 32 singular; give other --grid or --fixed angles"),
        ({"robot": "kuka-kr"}, {}, "'kuka-kr' is no robot"),
        ({"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS, "identified": HALF}}}, {},
         r"model.toml: joint-stiffness of joint 4, 5 is not identified; a map would show an invented number"),
        ({"effects": {"joint-stiffness": {"k_nm_per_rad": [1e3] * 6}}}, {}, "32 postures, .* without equilibrium"),
    ],
)  # fmt: skip
def test_refused_and_nothing_left(
    tmp_path: Path, changes: dict[str, Any], options: dict[str, Any], message: str
) -> None:
    path = model(tmp_path, **changes)
    with pytest.raises((CompensatorError, StiffnessError), match=message):
        map_file(path, spans=COARSE, csv=tmp_path / "m.csv", png=tmp_path / "m.png", **options)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["model.toml"]


def test_hardening_without_masses_needs_no_weight(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text(robot_text())
    hard = {"windup_rad": [1e-4] * 6, "knee_nm": [100.0] * 6}
    path = model(tmp_path, robot="arm.toml", effects={**MODEL["effects"], "joint-hardening": hard})
    with pytest.raises(StiffnessError, match=r"joint-hardening depends on the gravity torque .* map with --no-weight"):
        map_file(path, spans="-120:-60:20,30:90:20")
    assert map_file(path, spans="-120:-60:20,30:90:20", weight=False).report["n_ok"] > 5


def test_tool_of_the_command_line() -> None:
    tool = tool_of((0.0, 0.0, 250.0), (0.0, 90.0, 0.0), "spindle-a", 30.0, (0.0, 0.0, 100.0)).tool()
    assert tool.name == "spindle-a" and tool.mass == 30 and tool.position.tolist() == [0, 0, 0.25]
    np.testing.assert_allclose(tool.rotation[:, 2], [1, 0, 0], atol=1e-15)
    with pytest.raises(CompensatorError, match="--tool: mass is given without com"):
        tool_of((0.0, 0.0, 250.0), (0.0, 0.0, 0.0), "tool", 30.0, None)
    with pytest.raises(CompensatorError, match=r"--tool: tool.xyz is 0.25 mm long: expected mm"):
        tool_of((0.0, 0.0, 0.25), (0.0, 0.0, 0.0), "tool", None, None)
    with pytest.raises(CompensatorError, match="--tool-mass: "):
        tool_of((0.0, 0.0, 250.0), (0.0, 0.0, 0.0), "tool", -1.0, (0.0, 0.0, 100.0))


def test_outputs_do_not_clash(tmp_path: Path) -> None:
    path = model(tmp_path)
    with pytest.raises(CompensatorError, match="is an input of this run"):
        map_file(path, spans=COARSE, csv=path)
    with pytest.raises(CompensatorError, match="is asked for twice"):
        map_file(path, spans=COARSE, csv=tmp_path / "a", png=tmp_path / "a")
