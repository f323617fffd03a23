"""The turn along a path: what it is worth on the independent plant, and what keeps it safe."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.cell.job import load_job
from compensator.errors import CellError, PathError
from compensator.solve.planned import planned
from compensator.tasks.compensate import Done, compensate_file
from compensator.turn import refinement
from compensator.turn.refinement import corridor
from compensator.turn.turn_choice import turn_choice
from compensator.turn.turn_grid import TurnGrid
from compensator.turn.turn_kinematics import TurnKinematics
from tests.compensator.plant_bench import Bench, Table
from tests.compensator.small_job import AXIS, MODEL, files
from toolpaths.files import read_toolpath

BENT = {"xyz": [180.0, 0.0, 200.0], "rpy": [0.0, 45.0, 0.0], "mass": 35.0, "com": [60.0, 0.0, 100.0]}
PROCESS = {"kind": "constant", "frame": "path", "wrench": [-150.0, 60.0, -50.0, 0.0, 0.0, 0.0]}
START = [0.0, 10.0, 20.0, 0.0, 60.0, 0.0]
STIFFNESS = {"k_nm_per_rad": [2.0e6, 1.7e6, 1.3e6, 2.8e5, 0.96e5, 0.37e5]}
GAP = [3e-5, 3e-5, 3e-5, 4e-4, 3e-5, 3e-5]  # joint 4 is worn


def zigzag(rows: int = 4, points: int = 33) -> list[list[Any]]:
    out: list[list[Any]] = []
    for k in range(rows):
        x = np.linspace(0, 160, points)[:: 1 if k % 2 == 0 else -1]
        out += [[float(v), 20.0 * k, float(8 * np.sin(v / 25)), 0, 0, 1, 1800, "cut"] for v in x]
    return out


def bench(folder: Path, turn: str) -> tuple[Bench, Path]:
    """A model that has the wrong side for joint 4."""
    side = [1.0, 1.0, 1.0, -1.0, 1.0, 1.0]
    gap = {"gap_rad": GAP, "breakaway_nm": [1e4] * 6, "side": side}
    made = Bench(
        folder, "abb-irb6600-175-255", {"joint-stiffness": STIFFNESS, "backlash": gap},
        {"xyz": [1500.0, -60.0, 800.0]}, PROCESS, start=START, tool=BENT, gravity="calibrated-out",
        extra={"solve": {"turn": turn}},
    )  # fmt: skip
    with open(folder / "path.csv", "w", newline="") as stream:
        csv.writer(stream).writerows([AXIS, *zigzag()])
    return made, folder / "path.csv"


def left(made: Bench, table: Table) -> np.ndarray:
    """(N,) m that the plant, whose joint 4 rests on the other side than the model has it, leaves of the path."""
    true = {**made.effects, "backlash": {**made.effects["backlash"], "side": [1.0] * 6}}
    walk = made.walk(replace(made, effects=true).plant(), table)
    return np.linalg.norm(walk.tcp[walk.knot][:, :3, 3] - made.in_base(table.nominal)[:, :3, 3], axis=1)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Done, np.ndarray]]:
    out = {}
    for turn in ("constant", "path"):
        made, path = bench(tmp_path_factory.mktemp(turn), turn)
        done, table = made.compensate(path)
        out[turn] = (done, left(made, table))
    return out


def test_a_wrong_side_of_one_joint_costs_less(runs: dict[str, tuple[Done, np.ndarray]]) -> None:
    constant, path = (runs[turn][1] for turn in ("constant", "path"))
    assert constant.mean() > 120e-6  # the gap of joint 4 at its lever
    assert path.mean() < 0.7 * constant.mean() and path.max() < 0.8 * constant.max()


def test_what_the_choice_was_worth(runs: dict[str, tuple[Done, np.ndarray]]) -> None:
    done = runs["path"][0]
    turn = done.report["turn"]
    before, after = turn["constant"], turn["chosen"]
    assert after["cost_um2"]["sum"] < 0.6 * before["cost_um2"]["sum"]
    assert after["deflection_sd_um"] < 0.8 * before["deflection_sd_um"]
    parts = sum(value for name, value in after["cost_um2"].items() if name != "sum")
    assert parts == pytest.approx(after["cost_um2"]["sum"])
    assert "turn" not in runs["constant"][0].report
    path, straight = done.result.path, runs["constant"][0].result.path
    assert set(path.branch) == set(straight.branch) and np.ptp(straight.turn) == 0.0
    assert np.abs(np.diff(path.q, axis=0)).max() < np.radians(5.0)
    motion = done.report["motion"]["acceleration_deg_per_s2"]
    assert np.all(np.array(motion["max"]) < np.array(motion["limit"]))
    assert [f.level for f in done.findings if "chosen along the path" in f.what] == ["note"]


def bent(folder: Path, rows: list[list[Any]], **solve: Any) -> Any:
    change = {"tool": BENT, "process": PROCESS, "start": {"joints": START}, "solve": solve}
    change["workobject"] = {"xyz": [1500.0, -60.0, 800.0], "rpy": [0.0, 0.0, 0.0]}
    return files(folder, change, MODEL, rows)


def test_a_failed_window_keeps_its_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No program is solved: what is left are constant turns, and the path says so where one is taken from a window."""
    made = bent(tmp_path, zigzag(2, 9))
    job = load_job(made.cell)
    path = planned(job, read_toolpath(made.toolpath))
    wrench = np.tile([-150.0, 60.0, -50.0, 0.0, 0.0, 0.0], (len(path), 1))
    monkeypatch.setattr(refinement, "_program", lambda *args, **more: None)
    choice = turn_choice(job, path, wrench)
    failed = [one for one in choice.found if one.windows[0]]
    assert all(one.windows == (1, 1) for one in failed) and choice.found
    start = np.full(len(choice.rows), 0.3)
    allowed = np.full((len(start) - 1, 6), 1.0)
    kept = refinement.refined(choice.cost, start, allowed)
    np.testing.assert_array_equal(kept.values, start)
    assert (kept.windows, kept.failed) == (1, 1)


def test_a_refinement_costs_less_and_stays_in_its_corridor(tmp_path: Path) -> None:
    made = bent(tmp_path, zigzag(2, 15))
    job = load_job(made.cell)
    path = planned(job, read_toolpath(made.toolpath))
    wrench = np.tile([-150.0, 60.0, -50.0, 0.0, 0.0, 0.0], (len(path), 1))
    choice = turn_choice(job, path, wrench)
    cost, own = choice.cost, path.turn[choice.rows]
    allowed = np.full((len(own) - 1, 6), 0.02)
    made_of = refinement.refined(cost, own, allowed)
    assert made_of.failed == 0 and np.ptp(made_of.values) > 1e-3
    low, high = corridor(cost.grid, own)
    assert np.all(made_of.values >= low - 1e-12) and np.all(made_of.values <= high + 1e-12)
    assert cost.value(made_of.values).variance + cost.value(made_of.values).crossings < cost.value(own).cost
    kinematics = TurnKinematics.of(job.planner.inverse, path, choice.rows)
    q, slope = kinematics.angles(own)
    np.testing.assert_allclose(q, (path.q[choice.rows] + np.pi) % (2 * np.pi) - np.pi, atol=1e-9)
    ahead, _ = kinematics.angles(own + 1e-6)
    np.testing.assert_allclose(slope, (ahead - q) / 1e-6, atol=1e-4)
    sd, by_turn = cost.deviation(own)
    np.testing.assert_allclose(by_turn, (cost.deviation(own + 1e-6)[0] - sd) / 1e-6, atol=1e-3 * np.abs(by_turn).max())


def test_a_corridor_ends_where_the_grid_does() -> None:
    """By hand: 12 columns of 30 deg, column 4 and 9 forbidden; from 7 a half the way goes from 5 to 8."""
    status = np.zeros((2, 12), dtype=np.uint8)
    status[:, [4, 9]] = 1
    turns = 2 * np.pi * np.arange(12) / 12
    grid = TurnGrid(np.arange(2), turns, np.zeros((2, 12, 6)), status, np.ones((2, 12)))
    low, high = corridor(grid, np.radians([225.0, 225.0 + 360.0]))
    np.testing.assert_allclose(np.degrees(low), [150.0, 510.0])
    np.testing.assert_allclose(np.degrees(high), [240.0, 600.0])
    inside = corridor(grid, np.radians([125.0, 225.0]))
    assert inside[0][0] == inside[1][0] == pytest.approx(np.radians(125.0))  # not free: it stays


def test_what_is_refused(tmp_path: Path) -> None:
    made = bent(tmp_path, zigzag(1, 3), turn="path", free_tool_axis=False)
    with pytest.raises(CellError, match=r'solve.turn = "path": no turn about the tool axis is open: solve.free'):
        compensate_file(made.toolpath, made.cell, made.out / "a.csv")
    assert made.left() == []


def test_a_constant_turn_that_serves_nowhere_names_the_remedy(tmp_path: Path) -> None:
    """A ring about axis 1, the tool tilted: a turn that changes follows it, no constant one does."""
    turn = np.linspace(0, 2 * np.pi, 90)
    rows = [[float(900 * np.cos(a)), float(900 * np.sin(a)), 0, 0, 0, 1, 1200, "cut"] for a in turn * 0.9]
    change = {"tool": {"xyz": [300.0, 0.0, 100.0], "rpy": [0.0, 90.0, 0.0]}, "process": PROCESS}
    change |= {"workobject": {"xyz": [0.0, 0.0, 700.0], "rpy": [0.0, 0.0, -160.0]}, "sampling": {"spacing": 200.0}}
    free = files(tmp_path, change, MODEL, rows)
    assert np.ptp(planned(load_job(free.cell), read_toolpath(free.toolpath)).turn) > 1.0
    one = files(tmp_path, {**change, "solve": {"turn": "constant"}}, MODEL, rows)
    with pytest.raises(PathError, match=r'solve.turn = "constant": no turn .* whole path, .*set turn = "path"'):
        planned(load_job(one.cell), read_toolpath(one.toolpath))
