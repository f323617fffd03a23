"""Studies of arms whose wrist axes do not meet in a point, against a published closed form, Pinocchio and previews."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import load_cell
from compensator.errors import CompensatorError
from compensator.place import study as study_module
from compensator.place.candidates import box
from compensator.place.judge import Judge
from compensator.place.parts import Parts
from compensator.place.postures import PlacedPostures, placed_postures
from compensator.place.study import study_of
from compensator.solve.planned import planned, sampled
from compensator.tasks.compensate import compensate_file, files_of, preview_file, read_input
from compensator.tasks.place import place_file
from tests.compensator import small_job
from tests.compensator.place import placement_job
from tests.oracles.ur10_postures import closed_form
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_rpy

CRX = "data/robots/fanuc_official_crx10ia_l.urdf"
TURNS = 4


def judge_of(files: small_job.Files, within: str) -> Judge:
    cell = load_cell(files.cell)
    given = read_input(files_of([files.toolpath], None), files.cell)
    path = sampled(given.job.placement, given.path)
    places = box(within, cell.workobject)
    return Judge(study_of(load_arm(cell), given.job, path, places, turns=TURNS, poses=20, inputs={}))


def found_at(judge: Judge, k: int) -> PlacedPostures:
    planner = judge.job.planner
    return placed_postures(judge.study, planner.inverse, planner.bounds, judge.study.candidates.frame(k))


def flanges(judge: Judge, k: int) -> list[np.ndarray]:
    """(P, 4, 4) of every turn, by the frames of the cell alone: the tool of placement_job is not turned."""
    study, tool = judge.study, np.array(placement_job.OFFSET["tool"]["xyz"]) / 1e3
    at = study.candidates.frame(k).then(study.tcp)
    out = []
    for turn in study.turns:
        rotation = at.rotation @ matrix_from_rpy(np.array([0.0, 0.0, turn]))
        out.append(Frame(rotation, at.origin - rotation @ tool).matrix)
    return out


def study(files: small_job.Files, name: str = "s.parquet", within: str = placement_job.OFFSET_BOX, **options):
    options = {"workers": 1, "turns": TURNS, "poses": 20, **options}
    return place_file(files.toolpath, files.cell, files.out / name, within=within, **options)


def test_reach_and_configurations_of_a_ur10_are_those_of_its_closed_form(tmp_path: Path) -> None:
    """Hawkins' closed form counts postures at every pose; the tip is beside the flange axis: turns differ."""
    judge = judge_of(placement_job.offset_wrist(tmp_path, scene=[]), "x=750:1550:9,y=0")
    seen = set()
    for k in range(9):
        found, row, angles = found_at(judge, k), judge.row(k), range(TURNS)
        counts = np.array([[len(list(closed_form(pose))) for pose in path] for path in flanges(judge, k)])
        whole = [int(np.sum((found.reached == 1.0) & (found.turn == judge.study.turns[t]))) for t in angles]
        assert whole == counts.min(axis=1).tolist()
        out = not counts.min(axis=1).any()
        assert (row.status == "out-of-reach") == out
        follows = np.cumprod(counts > 0, axis=1).mean(axis=1).max()  # from the first pose on
        assert row.reached == pytest.approx(follows)
        seen.add("edge" if 0 < follows < 1 else row.status)
    assert seen == {"good", "edge", "out-of-reach"}


def test_a_fanuc_stands_where_pinocchio_has_it(tmp_path: Path, shared: Path) -> None:
    pin = pytest.importorskip("pinocchio", reason="pin is not installed")
    files = placement_job.offset_wrist(tmp_path, str(shared / CRX), scene=[])
    judge = judge_of(files, "x=800,y=-300,yaw=40")
    found, model = found_at(judge, 0), pin.buildModelFromUrdf(str(shared / CRX))
    data, tip = model.createData(), model.getFrameId("J6_link")
    assert len(found.usable) > 8
    offset = np.array(placement_job.OFFSET["tool"]["xyz"]) / 1e3
    c, s = np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    position = judge.study.path.position
    wanted = position @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [0.8, -0.3, 0.1]
    for choice in found.usable.tolist():
        for q, point in zip(found.q[choice], wanted, strict=True):
            pin.framesForwardKinematics(model, data, q)
            at = data.oMf[tip]
            np.testing.assert_allclose(at.translation + at.rotation @ offset, point, atol=1e-8)
            np.testing.assert_allclose(at.rotation[:, 2], [0.0, 0.0, -1.0], atol=1e-8)


@pytest.mark.parametrize("robot", ["ur10", CRX])
def test_the_best_cell_is_previewed_and_compensated_as_it_was_judged(
    tmp_path: Path, robot: str, request: pytest.FixtureRequest
) -> None:
    where = robot if robot == "ur10" else str(request.getfixturevalue("shared") / robot)
    files = placement_job.offset_wrist(tmp_path, where)
    made = study(files, within="x=500:1700:3,y=-300:300:2", best=files.out / "best.toml")
    assert made.report["status"]["good"] >= 1 and made.report["status"]["out-of-reach"] >= 2
    (row,) = [k for k, p in enumerate(made.report["whole_path"]) if p["holds"]]
    best = made.report["ranked"][row]
    there = preview_file(files.toolpath, files.out / "best.toml").report["predicted_error_mm"]["before"]
    assert best["deflection_mean_mm"] == pytest.approx(there["mean"], rel=0.04)  # 20 poses against all of them
    assert best["deflection_p95_mm"] == pytest.approx(there["p95"], rel=0.05)
    assert 0.01 < best["sd_mm"] / best["deflection_mean_mm"] < 0.1
    given = read_input(files_of([files.toolpath], None), files.out / "best.toml")
    start = [made.columns[f"start_q{k + 1}_deg"][made.report["whole_path"][row]["index"]] for k in range(6)]
    np.testing.assert_allclose(np.degrees(planned(given.job, given.path).q[0]), start, atol=1e-5)
    done = compensate_file(files.toolpath, files.out / "best.toml", files.out / "c.script").report
    assert done["predicted_error_mm"]["after"]["max"] < 0.02 * done["predicted_error_mm"]["before"]["max"]


def test_a_placement_collides_only_if_all_choices_do(tmp_path: Path) -> None:
    """A wall that most of the choices run into, those first on which a compensation relies least."""
    seen = set()
    for y in (-150.0, 60.0):
        wall = {"name": "wall", "box": [[0.0, y, 250.0], [2500.0, y + 20.0, 1500.0]]}
        judge = judge_of(placement_job.offset_wrist(tmp_path, scene=[wall]), "x=600,y=0")
        found, row = found_at(judge, 0), judge.row(0)
        touching = [bool(judge._touching(found.q[c], judge.study.candidates.frame(0))) for c in found.usable]
        assert (row.status == "collides") == all(touching)
        seen.add(row.status)
    assert seen == {"good", "collides"}


def test_a_singularity_is_not_the_reach(tmp_path: Path) -> None:
    files = placement_job.offset_wrist(tmp_path, solve={"min_singular_value": 0.9})
    made = study(files, within="x=800:1700:2")
    assert made.columns["status"].tolist() == ["beyond-limits", "out-of-reach"]
    assert made.columns["reached"].tolist() == [1.0, 0.0]


def test_another_tool_is_reached_by_a_joint_move(tmp_path: Path) -> None:
    """Tool 2 is 250 mm longer and turned to the other side: nothing leads there along the path."""
    judge = judge_of(placement_job.offset_wrist(tmp_path, scene=[]), "x=800,y=-300")
    study, first = judge.study, placement_job.OFFSET["tool"]
    files = placement_job.offset_wrist(
        tmp_path, scene=[], tool=None,
        tools={"0": first, "2": {**first, "xyz": [0.0, 30.0, 400.0], "rpy": [0.0, 0.0, 180.0]}},
    )  # fmt: skip
    both = judge_of(files, "x=800,y=-300")
    late = np.arange(len(study.path)) >= len(study.path) // 2
    path = replace(both.study.path, tool=np.where(late, 2, 0))
    both.study = replace(both.study, path=path)
    one, two = found_at(judge, 0), found_at(both, 0)
    assert (two.reached == 1.0).sum() >= 8
    np.testing.assert_array_equal(two.q[0, 0], one.q[0, 0])
    inverse = both.job.planner.inverse
    for q in two.q[two.reached == 1.0]:
        flange = Frame.of(inverse.robot.pose(q[-1]))
        np.testing.assert_allclose(flange.at(np.array([0.0, 0.03, 0.4])), two.origin[-1], atol=1e-8)


def test_processes_and_a_cluster_make_the_same_bytes_and_a_stopped_study_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    monkeypatch.setattr(study_module, "POSTURES", 1)  # a task for each placement
    files, within = placement_job.offset_wrist(tmp_path), "x=600:1400:3,y=-300:300:2"
    study(files, "one.parquet", within)
    expected, written = (files.out / "one.parquet").read_bytes(), Parts.write

    def stops(after: int) -> Callable[..., None]:
        def write(self: Parts, batch: range, rows) -> None:
            if len(self.all()) == after:
                raise KeyboardInterrupt
            written(self, batch, rows)

        return write

    monkeypatch.setattr(Parts, "write", stops(2))
    with pytest.raises(KeyboardInterrupt):
        study(files, "two.parquet", within)
    monkeypatch.setattr(Parts, "write", written)
    made = study(files, "two.parquet", within, workers=2)
    assert made.report["n_tasks_resumed"] == 2 and made.report["n_tasks"] == 6
    assert (files.out / "two.parquet").read_bytes() == expected
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        study(files, "cluster.parquet", within, scheduler=cluster.scheduler_address)
    assert (files.out / "cluster.parquet").read_bytes() == expected


def test_a_turn_along_the_path_is_refused_before_anything_is_judged(tmp_path: Path) -> None:
    files = placement_job.offset_wrist(tmp_path, solve={"turn": "path"})
    with pytest.raises(CompensatorError, match=r'spherical wrist.*keep \[solve\] turn = "constant"'):
        study(files)
    assert files.left() == []
