"""Lean of the tool axis: the cone, the contact of a ball, what it is worth, where nothing changes, what is refused."""

from __future__ import annotations

import csv
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.cell.job import load_job
from compensator.errors import CellError, PathError
from compensator.path.free_turn import about_z, reference_rotation
from compensator.path.lean import CutterShape, LeanRoom, leaned
from compensator.solve.planned import planned
from compensator.tasks.compensate import Done, compensate_file
from compensator.turn.lean_choice import lean_choice, upright
from compensator.turn.lean_refinement import refined_lean
from tests.compensator.plant_bench import Bench
from tests.compensator.small_job import AXIS, MODEL, Files, files
from tests.compensator.turn.test_path_turn import BENT, PROCESS, START, STIFFNESS, zigzag
from toolpaths.files import read_toolpath
from toolpaths.toolpath import CUT, Toolpath

BALL = {"shape": "ball", "diameter": 12.0}
STRAIGHT = {"xyz": [0.0, 0.0, 200.0], "rpy": [0.0, 0.0, 0.0], "mass": 20.0, "com": [0.0, 0.0, 80.0]}
CONE = 4.0


def bent(folder: Path, rows: list[list[Any]], cutter: dict[str, Any] | None = None, **solve: Any) -> Files:
    process = PROCESS if cutter is None else {**PROCESS, "cutter": cutter}
    change = {"tool": BENT, "process": process, "start": {"joints": START}, "solve": solve}
    change["workobject"] = {"xyz": [1500.0, -60.0, 800.0], "rpy": [0.0, 0.0, 0.0]}
    return files(folder, change, MODEL, rows)


def fan(poses: int = 161) -> list[list[Any]]:
    """A tool axis that passes axis 4 in line: the wrist is stretched on the way."""
    angle = np.radians(np.linspace(-40.0, 40.0, poses))
    y = 0.5 * (np.arange(poses) - poses / 2)
    return [
        [0.0, float(b), 0.0, float(-np.cos(a)), 0.0, float(np.sin(a)), 1200, "cut"]
        for a, b in zip(angle, y, strict=True)
    ]  # fmt: skip


@pytest.fixture(scope="module")
def ball() -> tuple[Done, Done]:
    """A turn along the path, and the same with a ball that may lean."""
    out = []
    for solve in ({"turn": "path"}, {"lean": CONE}):
        job = bent(Path(tempfile.mkdtemp()), zigzag(2, 17), BALL, **solve)
        out.append(compensate_file(job.toolpath, job.cell, job.out / "a.csv"))
    return out[0], out[1]


def test_a_ball_keeps_its_centre_and_the_axis_its_cone(ball: tuple[Done, Done]) -> None:
    straight, leaning = (done.result.path.toolpath for done in ball)
    job = ball[1].result.job
    source = read_toolpath(Path(straight.source))
    at = leaning.row == np.round(leaning.row)
    rows = leaning.row[at].astype(int)
    centre, wanted = (p.position + 6e-3 * p.axis for p in (leaning.take(np.flatnonzero(at)), source.take(rows)))
    np.testing.assert_allclose(centre, wanted, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(leaning.axis, axis=1), 1.0, atol=1e-12)
    away = np.degrees(np.arccos(np.clip(leaning.axis @ [0.0, 0.0, 1.0], -1, 1)))
    assert 0.2 < away.max() <= CONE + 1e-6
    tcp = ball[1].result.path.tcp
    np.testing.assert_allclose(-tcp.rotation[:, :, 2], leaning.axis @ job.placement.workobject.rotation.T, atol=1e-9)
    lean = ball[1].report["turn"]["lean"]
    cut = leaning.kind == CUT
    assert lean["max_deg"] == pytest.approx(away[cut].max(), abs=0.05) and lean["allowed_deg"] == CONE


def test_what_leaning_is_worth(ball: tuple[Done, Done]) -> None:
    straight, leaning = (done.report["turn"] for done in ball)
    before, after = leaning["lean"]["upright"], leaning["chosen"]
    assert before["cost_um2"]["sum"] == pytest.approx(straight["chosen"]["cost_um2"]["sum"], rel=0.02)
    assert after["cost_um2"]["sum"] < 0.96 * before["cost_um2"]["sum"]
    assert after["reversals_in_cut"] < 0.8 * before["reversals_in_cut"]
    assert after["cost_um2"]["variance"] <= 1.02 * before["cost_um2"]["variance"]
    parts = sum(value for name, value in after["cost_um2"].items() if name != "sum")
    assert parts == pytest.approx(after["cost_um2"]["sum"]) and after["cost_um2"]["lean"] > 0
    told = [f.what for f in ball[1].findings if "leans by up to" in f.what]
    assert len(told) == 1 and "joint reversals in the cut" in told[0] and "allowed are 4" in told[0]
    assert any("balls lean about their centres" in f.what for f in ball[1].findings)
    assert "lean" not in straight and "lean" not in straight["chosen"]["cost_um2"]
    assert np.linalg.norm(ball[1].result.command.error) < 1e-6


def test_a_leaning_ball_on_the_independent_plant(tmp_path: Path) -> None:
    """The plant walks the program: the centre of its ball is where the toolpath has it, under load."""
    bench = Bench(
        tmp_path, "abb-irb6600-175-255", {"joint-stiffness": STIFFNESS}, {"xyz": [1500.0, -60.0, 800.0]},
        {**PROCESS, "cutter": BALL}, start=START, tool=BENT, gravity="calibrated-out",
        extra={"solve": {"lean": CONE}},
    )  # fmt: skip
    with open(tmp_path / "path.csv", "w", newline="") as stream:
        csv.writer(stream).writerows([AXIS, *zigzag(2, 13)])
    done, table = bench.compensate(tmp_path / "path.csv")
    walk = bench.walk(bench.plant(), table)
    at, source = walk.tcp[walk.knot], read_toolpath(tmp_path / "path.csv")
    centre = at[:, :3, 3] - 6e-3 * at[:, :3, 2] - [1.5, -0.06, 0.8]
    row, wanted = done.result.path.toolpath.row, source.position + 6e-3 * source.axis
    where = np.stack([np.interp(row, np.arange(len(source)), column) for column in wanted.T], axis=1)
    assert np.linalg.norm(centre - where, axis=1).max() < 1e-7
    assert np.degrees(np.arccos(-at[:, 2, 2])).max() > 0.5


def test_no_lean_is_no_change(tmp_path: Path) -> None:
    written = []
    for solve in ({"turn": "path"}, {"turn": "path", "lean": 0.0}):
        job = bent(tmp_path, zigzag(1, 5), **solve)
        compensate_file(job.toolpath, job.cell, job.out / "a.csv")
        lines = (job.out / "a.csv").read_bytes().splitlines()
        written.append([line for line in lines if not line.startswith(b"#")])
    assert written[0] == written[1]


def test_a_wrist_that_would_be_stretched_is_led_around(tmp_path: Path) -> None:
    change = {"tool": STRAIGHT, "process": PROCESS, "sampling": {"spacing": 500.0}}
    change["workobject"] = {"xyz": [1500.0, 0.0, 1400.0], "rpy": [0.0, 0.0, 0.0]}
    made = files(tmp_path, {**change, "solve": {"turn": "path"}}, MODEL, fan())
    with pytest.raises(PathError, match="too near the wrist singularity"):
        planned(load_job(made.cell), read_toolpath(made.toolpath))
    made = files(tmp_path, {**change, "solve": {"lean": 6.0}}, MODEL, fan())
    job, source = load_job(made.cell), read_toolpath(made.toolpath)
    path = planned(job, source)
    assert np.abs(path.q[:, 4]).min() > np.radians(2.0)
    assert np.abs(np.diff(path.q, axis=0)).max() < np.radians(30.0)
    np.testing.assert_array_equal(path.toolpath.position, source.position)  # no ball: the TCP stays
    away = np.degrees(np.arccos(np.clip(np.sum(path.toolpath.axis * source.axis, axis=1), -1, 1)))
    assert 2.0 < away.max() <= 6.0 + 1e-6
    assert path.chosen is not None and path.chosen.lean is not None and path.chosen.lean.upright is None
    assert any("no upright tool can be taken" in f.what for f in path.chosen.findings)
    assert any("does not tell the shape" in f.what for f in path.chosen.findings)


def test_refinement_and_derivatives(tmp_path: Path) -> None:
    """Derivatives against differences; a refinement costs less, and a failed one keeps its start."""
    made = bent(tmp_path, zigzag(1, 15), BALL, turn="path")
    job = load_job(made.cell)
    path = planned(job, read_toolpath(made.toolpath))
    room = LeanRoom.of(np.radians(CONE), path.toolpath, job.placement.cutters, "cell.toml")
    wrench = np.tile([-150.0, 60.0, -50.0, 0.0, 0.0, 0.0], (len(path), 1))
    choice = lean_choice(job, upright(path, room), wrench, clear=None, commands=lambda one: one.q)
    cost, state = choice.cost, choice.begun.state[choice.rows]
    q, slope, _ = cost.kinematics.angles(state)
    np.testing.assert_allclose(cost.arm.within(q), cost.arm.within(path.q[choice.rows]), atol=1e-9)
    for k in range(3):
        ahead, _, _ = cost.kinematics.angles(state + 1e-6 * np.eye(3)[k])
        np.testing.assert_allclose(slope[:, :, k], (ahead - q) / 1e-6, atol=1e-4)
    allowed = np.full((len(state) - 1, 6), 0.05)
    better = refined_lean(cost, state, allowed)
    assert (better.windows, better.failed) == (1, 0)
    assert cost.value(better.values).cost < cost.value(state).cost
    assert np.linalg.norm(better.values[:, 1:], axis=1).max() <= np.radians(CONE) + 1e-9
    assert cost.free(better.values).all()


def test_around_what_stands_in_the_way(tmp_path: Path) -> None:
    """The upright postures of five poses are taken: the path leaves them, whatever it costs."""
    made = bent(tmp_path, zigzag(1, 9), lean=CONE, turn="path")
    job = load_job(made.cell)
    path = job.planner.plan(read_toolpath(made.toolpath))
    room = LeanRoom.of(np.radians(CONE), path.toolpath, {}, "cell.toml")
    taken = np.arange(3, 8)

    def clear(rows: np.ndarray, q: np.ndarray) -> np.ndarray:
        apart = np.abs(q - path.q[rows][:, None]).max(axis=2)
        return (apart > np.radians(1.0)) | ~np.isin(rows, taken)[:, None]

    wrench = np.tile([-150.0, 60.0, -50.0, 0.0, 0.0, 0.0], (len(path), 1))
    choice = lean_choice(job, upright(path, room), wrench, clear=clear, commands=lambda one: one.q)
    assert not choice.own_is_free and choice.found
    found = choice.taken()
    assert np.abs(found.q - path.q)[taken].max(axis=1).min() > np.radians(1.0)


def toolpath_of(axis: np.ndarray) -> Toolpath:
    n = len(axis)
    position = np.column_stack([np.linspace(0, 0.1, n), np.zeros((n, 2))])
    nothing = np.zeros(n)
    return Toolpath(
        "a.csv", "csv", position, axis, None, nothing + 0.02, np.full(n, CUT), np.zeros(n, dtype=np.int32), nothing,
        np.zeros(n, dtype=np.int8), np.arange(n, dtype=np.int32), np.arange(n, dtype=float),
    )  # fmt: skip


def test_leaned_geometry_against_scipy() -> None:
    rng = np.random.default_rng(4)
    axis = np.array([0.1, -0.2, 1.0]) + 0.1 * rng.normal(size=(30, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    path, radius = toolpath_of(axis), np.full(30, 5e-3)
    state = rng.normal(size=(30, 3)) * [0.3, 0.05, 0.05]
    state[7, 1:] = 0.0
    out, turn = leaned(path, radius, state)
    flat = np.column_stack([state[:, 1:], np.zeros(30)])
    wanted = reference_rotation(path) @ Rotation.from_rotvec(flat).as_matrix() @ about_z(state[:, 0])
    np.testing.assert_allclose(reference_rotation(out) @ about_z(turn), wanted, atol=1e-12)
    np.testing.assert_allclose(out.position + 5e-3 * out.axis, path.position + 5e-3 * axis, atol=1e-15)
    np.testing.assert_array_equal(out.axis[7], path.axis[7])
    assert leaned(path, radius, state * [1, 0, 0])[0] is path


def test_where_tools_may_lean() -> None:
    path = toolpath_of(np.tile([0.0, 0.0, 1.0], (4, 1)))
    path = replace(path, tool=np.array([1, 1, 2, 3], dtype=np.int32))
    shapes = {1: CutterShape("ball", 0.01), 2: CutterShape("flat", 0.01), 3: CutterShape(None, None)}
    room = LeanRoom.of(0.1, path, shapes, "c.toml")
    assert room.open.tolist() == [True, True, False, True] and room.declared
    assert room.radius.tolist() == [0.005, 0.005, 0.0, 0.0]


REFUSED = [
    ({"shape": "flat", "diameter": 10.0}, {"lean": 5.0}, "solve.lean: a flat cutter that leans cuts another surface"),
    ({"shape": "ball"}, {"lean": 5.0}, "a ball leans about its centre, and this one has no diameter"),
    (None, {"lean": 5.0, "turn": "constant"}, "solve.*lean is chosen along the path together with the turn"),
    (None, {"lean": 5.0, "free_tool_axis": False}, "solve.lean = 5: no turn about the tool axis is open"),
    (None, {"lean": -1.0}, "solve.lean = -1"),
    (None, {"lean": 31.0}, "solve.lean = 31"),
]


@pytest.mark.parametrize(("cutter", "solve", "words"), REFUSED)
def test_what_is_refused(tmp_path: Path, cutter: dict[str, Any] | None, solve: dict[str, Any], words: str) -> None:
    made = bent(tmp_path, zigzag(1, 3), cutter, **solve)
    with pytest.raises(CellError, match=words):
        compensate_file(made.toolpath, made.cell, made.out / "a.csv")
    assert made.left() == []


def test_a_program_that_is_filtered_in_place_keeps_its_axes(tmp_path: Path) -> None:
    made = bent(tmp_path, zigzag(1, 3), lean=5.0)
    nc = tmp_path / "a.nc"
    nc.write_text("G90 G21\nG0 X0 Y0 Z10\nG1 Z0 F600\nX50\n")
    with pytest.raises(CellError, match=r"solve.lean = 5: a program that is filtered in place keeps"):
        compensate_file(nc, made.cell, made.out / "a.nc")
