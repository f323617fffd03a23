"""Compensated programs on a robot that the product knows nothing of: the MuJoCo plant in tests/plant.

The plant reads the robot file with its own reader, has its own statics, its own joint laws and its own memory
of flanks. Given the figures of the model file it must end up where the CAM file wants the tool.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.compensator import curved_path
from tests.compensator.plant_bench import MM, Bench, Table, write_poses
from tests.compensator.worn_robots import EXTRAS, FORCE, NEVER, WALL, bench, undecided
from tests.oracles import rapid_reader
from tests.plant import Walk
from tests.plant.geometry import Array, between, placement, turn

MICROMETRE = 1e-6


def check_nominal(job: Bench, table: Table, source: list[list[object]]) -> None:
    """Where the program says the tool has to be lies on the rows of the CAM file, in order, axis included."""
    points = MM * np.array([row[:3] for row in source], dtype=float)
    axes = np.array([row[3:6] for row in source], dtype=float)
    row = table.line - 2
    assert np.all(np.diff(row) >= 0) and row[0] == 0 and row[-1] == len(source) - 1
    assert [source[r][7] for r in row] == table.kind
    for k, r in enumerate(row):
        p, z = table.nominal[k, :3, 3], -table.nominal[k, :3, 2]
        if r == 0:
            share = 1.0
        else:
            step = points[r] - points[r - 1]
            share = float((p - points[r - 1]) @ step / (step @ step))
            assert -1e-6 < share < 1 + 1e-6
        at = share * points[r] + (1 - share) * points[max(r - 1, 0)]
        assert np.linalg.norm(p - at) < 2e-9  # printed to 1e-6 mm
        lean = axes[max(r - 1, 0)], axes[r]
        angle = np.arccos(np.clip(lean[0] @ lean[1], -1, 1))
        normal = np.cross(*lean)
        size = np.linalg.norm(normal)
        axis = turn(normal / size * angle * share) @ lean[0] if size > 1e-9 else lean[1]
        assert np.linalg.norm(z - axis) < 2e-8
    np.testing.assert_allclose(table.wrench[table.cut], np.tile(FORCE, (table.cut.sum(), 1)), atol=1e-9)
    np.testing.assert_array_equal(table.wrench[~table.cut], 0)


CASES = {
    "abb": ("abb-irb6600-175-255", {}),
    "abb-lag-calibrated": ("abb-irb6600-175-255", {"side": -1.0, "gravity": "calibrated-out"}),
    "abb-wall": ("abb-irb6600-175-255", {"mount": WALL}),
    "kr210-lag": ("kuka-kr210-r2700", {"side": -1.0}),
    "kr210-calibrated": ("kuka-kr210-r2700", {"gravity": "calibrated-out"}),
    "kr500-lag-wall": ("kuka-kr500", {"side": -1.0, "mount": WALL}),
    "kr500-calibrated-wall": ("kuka-kr500", {"gravity": "calibrated-out", "mount": WALL}),
    "kr240": ("kuka-kr240-class", {}),
    "abb-extras": ("abb-irb6600-175-255", {"more": EXTRAS}),
    "kr210-extras-calibrated-lag": (
        "kuka-kr210-r2700",
        {"more": EXTRAS, "gravity": "calibrated-out", "side": -1.0},
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_five_axis_path_comes_back_to_nominal(case: str, tmp_path: Path) -> None:
    robot, given = CASES[case]
    job = bench(tmp_path, robot, **given)
    source = curved_path.rows()
    path = write_poses(tmp_path / "sheet.csv", source)
    _, table = job.compensate(path)
    check_nominal(job, table, source)
    walk = job.walk(job.plant(), table)
    error, angle = walk.errors(job.in_base(table.nominal))
    clear = ~undecided(walk, job.effects["backlash"]["breakaway_nm"])
    cut = table.cut
    assert cut.sum() > 200
    # from millimetres ...
    _, raw = job.preview(path)
    before = job.walk(job.plant(), raw, nominal=True)
    assert before.errors(job.in_base(raw.nominal))[0][raw.cut].max() > 1e-3
    # ... which the preview knew ...
    known = ~undecided(before, job.effects["backlash"]["breakaway_nm"])
    assert known.mean() > 0.95
    assert np.abs(before.deflection - raw.deflection)[known].max() < 10e-9
    # ... to nanometres
    assert np.mean(clear[cut]) > 0.9
    assert error[cut & clear].max() < 10e-9
    # where the controller takes the sag off, plant and product turn it off in different axes: second order
    assert angle[cut & clear].max() < (1e-7 if job.gravity == "uncompensated" else 2e-5)
    # where the model has two answers the product has one of them: off by a gap, never more
    assert error[cut].max() < 0.25e-3
    check_both_kinds_of_flank(walk, cut, job)


def check_both_kinds_of_flank(walk: Walk, cut: Array, job: Bench) -> None:
    """The path has flanks that the motion chose, flanks that the load chose, and changes of either."""
    backlash = job.effects["backlash"]
    side, half = backlash["side"][0], np.array(backlash["gap_rad"]) / 2
    flank = np.sign(np.where(np.abs(walk.play) > 0.99 * half, walk.play, 0))
    held = np.abs(walk.torque) > backlash["breakaway_nm"]
    against = held & (flank == -side * walk.direction)  # the motion alone would have it elsewhere
    assert np.sum(against[cut]) > 10 and np.sum(~held[cut]) > 100
    changes = (flank[1:] * flank[:-1] < 0) & cut[1:, None]
    assert np.sum(changes & ~held[1:]) > 10
    softer = walk.torque * walk.direction < 0
    assert 0.1 < np.mean(softer[cut]) < 0.9


def test_rapid_program_comes_back_to_nominal(tmp_path: Path) -> None:
    """The printed digits of RAPID, read by the tests' own reader, tool and work object included."""
    job = bench(tmp_path, "abb-irb6600-175-255", breakaway=[100.0, 10.0, 10.0, NEVER, NEVER, NEVER])
    path = write_poses(tmp_path / "sheet.csv", curved_path.rows())
    _, table = job.compensate(path, "sheet.mod")
    moves, _ = rapid_reader.read(tmp_path / "sheet.mod")
    plant = job.plant()
    tool, work = moves[-1].tool, moves[-1].wobj
    np.testing.assert_allclose(frame(tool[1]), plant.arm.tool.pose, atol=1e-7)
    np.testing.assert_allclose(frame(work[3]) @ frame(work[4]), job.base_work, atol=1e-7)
    q: list[Array] = []
    for move in moves:
        if move.word == "MoveAbsJ":
            q.append(np.radians(move.target[0]))
        else:
            q.append(plant.inverse(job.base_work @ frame(move.target[:2]), q[-1]))
    before = len(q) - len(table.q)
    assert [move.word for move in moves[: before + 1]] == ["MoveAbsJ"] * before + ["MoveL"]
    np.testing.assert_allclose(q[0], job.q_start, atol=1e-9)
    wrench = np.vstack([np.zeros((before, 6)), table.wrench])
    walk = plant.walk(q, wrench, start=job.q_start)
    error, angle = walk.errors(job.in_base(np.concatenate([table.nominal[:1]] * before + [table.nominal])))
    error, angle = error[before:], angle[before:]
    clear = ~undecided(walk, job.effects["backlash"]["breakaway_nm"])[before:]
    assert np.mean(clear) > 0.95
    assert error[table.cut & clear].max() < 0.3 * MICROMETRE and angle[table.cut & clear].max() < 1e-6
    assert error[table.cut & clear].max() > 1e-9  # it was the printed text


def frame(value: list[list[float]]) -> Array:
    """(4,4) of [[x, y, z], [q1, q2, q3, q4]], mm."""
    out = placement()
    w, v = value[1][0], np.array(value[1][1:])
    for k, e in enumerate(np.eye(3)):
        cross = np.cross(v, e)
        out[:3, k] = e + 2 * w * cross + 2 * np.cross(v, cross)
    out[:3, 3] = MM * np.array(value[0])
    return out


# ---- short paths that are hard on the memory


def to_and_fro() -> list[Array]:
    """All joints reverse at once, three times."""
    x = np.linspace(0, 60, 7)
    return [np.array([v, v / 2, 0]) for v in (*x, *x[::-1], *x)]


def dwelling() -> list[Array]:
    """Poses twice and three times."""
    corners = [(0, 0), (20, 0), (20, 0), (20, 0), (20, 30), (20, 30), (-20, 30)]
    return [np.array([*c, 0.0]) for c in corners]


def zigzag() -> list[Array]:
    """Every move shorter than what the gaps are worth."""
    return [np.array([0.5 * i, (-1) ** i * 0.4, 0]) for i in range(50)]


def trembling() -> list[Array]:
    """Moves of 0.3 mm in all directions."""
    return list(np.cumsum(np.random.default_rng(3).normal(scale=0.3, size=(60, 3)), axis=0))


def single() -> list[Array]:
    return [np.zeros(3)]


SHORT = [to_and_fro, dwelling, zigzag, trembling, single]
DECIDES = {"load": [0.0] * 6, "motion": [NEVER] * 6}


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("decides", DECIDES)
@pytest.mark.parametrize("points", SHORT, ids=lambda f: f.__name__)
def test_short_paths_start_on_the_cut(points: Any, decides: str, side: float, tmp_path: Path) -> None:
    """No rapid, no approach but the way from [start]; gaps too large for the motion to take up."""
    job = bench(
        tmp_path, "kuka-kr210-r2700", side=side, breakaway=DECIDES[decides], without=("preload-softening",)
    )
    wide = {**job.effects["backlash"], "gap_rad": [4e-3, 3e-3, 3e-3, 4e-3, 4e-3, 4e-3]}
    job = replace(job, effects={**job.effects, "backlash": wide})
    path = write_poses(tmp_path / "short.csv", [[*p, 0, 0, 1, 900, "cut"] for p in points()])
    _, table = job.compensate(path)
    assert table.cut.all()
    walk = job.walk(job.plant(), table)
    error, angle = walk.errors(job.in_base(table.nominal))
    assert error.max() < MICROMETRE and angle.max() < 2e-6
    gap = np.array(wide["gap_rad"])
    if decides == "motion" and len(table.q) > 1 and side > 0:
        assert np.any(np.abs(walk.play) < 0.4 * gap)  # links in the middle of their gaps


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_moment_that_changes_sign_at_every_pose(side: float, tmp_path: Path) -> None:
    """A wrench table that turns the load of joints 1, 4 and 6 round from row to row: flanks at every pose."""
    count = 13
    wrench = np.zeros((count, 6))
    wrench[:, 1] = 900.0 * (-1.0) ** np.arange(count)
    wrench[:, 5] = 120.0 * (-1.0) ** (np.arange(count) // 2)
    lines = ["index,fx,fy,fz,mx,my,mz"]
    lines += [f"{k}," + ",".join(f"{v:.1f}" for v in row) for k, row in enumerate(wrench)]
    (tmp_path / "wrench.csv").write_text("\n".join(lines) + "\n")
    process = {"kind": "table", "frame": "base", "file": "wrench.csv"}
    job = bench(tmp_path, "abb-irb6600-175-255", side=side, breakaway=[0.0] * 6, process=process)
    points = [[12.0 * k, 20 * np.sin(k), 3 * np.cos(k)] for k in range(count)]
    path = write_poses(tmp_path / "in.csv", [[*p, 0.1, 0, 0.995, 900, "cut"] for p in points])
    _, table = job.compensate(path)
    walk = job.walk(job.plant(), table)
    distance = np.linalg.norm(table.nominal[:, None, :3, 3] - MM * np.array(points), axis=2)
    rows = np.argmin(distance, axis=0)
    np.testing.assert_allclose(table.wrench[rows], wrench, atol=1e-6)
    assert np.sum(np.diff(np.sign(walk.torque[rows, 0])) != 0) == count - 1
    error, _ = walk.errors(job.in_base(table.nominal))
    assert error[rows].max() < 10e-9
    clear = ~undecided(walk, [0.0] * 6)
    assert error[clear].max() < 10e-9
    assert error.max() < 0.4e-3


# ---- between the poses


def test_straight_lines_between_the_poses(tmp_path: Path) -> None:
    """A controller goes from pose to pose in straight lines; the plant is looked at in 8 places of each."""
    job = bench(tmp_path, "kuka-kr210-r2700", breakaway=[NEVER] * 6, without=("preload-softening",))
    path = write_poses(tmp_path / "sheet.csv", curved_path.rows())
    _, table = job.compensate(path)
    steps = 8
    walk = job.walk(job.plant(), table, interpolate=steps)
    wanted = job.in_base(table.nominal)
    fine = [wanted[0]]
    for a, b in pairwise(wanted):
        fine += [between(a, b, (i + 1) / steps) for i in range(steps)]
    error = walk.errors(np.array(fine))[0][1:].reshape(-1, steps).max(axis=1)
    cut = table.cut[1:] & table.cut[:-1]
    length = np.linalg.norm(np.diff(wanted[:, :3, 3], axis=0), axis=1)
    error, length = error[cut], length[cut]
    turning = np.any(np.diff(walk.play[walk.knot], axis=0) != 0, axis=1)[cut]
    assert length[turning].sum() < 0.4 * length.sum()
    assert error[~turning].max() < 2 * MICROMETRE
    assert length[error > 10 * MICROMETRE].sum() < 0.05 * length.sum()


# ---- without [start]


def test_unknown_start_is_forgotten(tmp_path: Path) -> None:
    """Without [start] the first flanks are unknown; every joint that has turned by its gap is known."""
    job = bench(tmp_path, "kuka-kr210-r2700", breakaway=[NEVER] * 6, start=None)
    points = to_and_fro()
    path = write_poses(tmp_path / "in.csv", [[*p, 0, 0, 1, 900, "cut"] for p in points])
    _, table = job.compensate(path)
    plant = job.plant()
    q = plant.follow(job.in_base(table.command), table.q[0])
    for offset in (-0.01, 0.01):  # the robot came from either side
        walk = plant.walk(q, table.wrench, start=q[0] + offset)
        error, _ = walk.errors(job.in_base(table.nominal))
        assert error[0] > 50e-6
        assert error[2:].max() < 10e-9
