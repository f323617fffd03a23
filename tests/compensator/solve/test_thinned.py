"""What a result keeps of the path before poses were put in: the same values, made from the path that has them."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import compensator.solve.compensate as solving
from compensator.cell.job import Job
from compensator.path.planned_path import PlannedPath
from compensator.path.thinned_path import ThinnedPath, thinned_path
from compensator.solve.compensate import compensate, uncompensated
from compensator.solve.made_command import MadeCommand
from compensator.solve.planned import planned
from compensator.tasks.compensate import files_of, read_input
from tests.compensator.small_job import WORN, files
from tests.compensator.solve.test_blocks import wavy
from toolpaths.toolpath import Toolpath


@pytest.mark.parametrize("frame", ["path", "workobject"])
def test_the_path_without_poses_put_in_is_made_from_the_one_with_them(tmp_path: Path, frame: str) -> None:
    process = {"kind": "constant", "frame": frame, "wrench": [-160.0, 90.0, 120.0, 5.0, -4.0, 3.0]}
    job_files = files(tmp_path, {"gravity": "uncompensated", "process": process}, WORN, rows=wavy(71, rapid=True))
    given = read_input(files_of(job_files.toolpath, None), job_files.cell)
    path = planned(given.job, given.path)
    result, alone = compensate(given.job, path), uncompensated(given.job, path)
    kept = result.uncompensated
    assert result.inserted > 5 and isinstance(kept.path, ThinnedPath) and len(kept.path) == len(kept) == len(path)
    for f in fields(Toolpath):
        mine, theirs = getattr(kept.path.toolpath, f.name), getattr(path.toolpath, f.name)
        if isinstance(theirs, np.ndarray):
            np.testing.assert_array_equal(mine, theirs, err_msg=f.name)
        else:
            assert mine == theirs, f.name
    for made in (kept.path.tcp, kept.target, kept.printed):
        np.testing.assert_array_equal(made.rotation, path.tcp.rotation)
        np.testing.assert_array_equal(made.origin, path.tcp.origin)
    for name in ("q", "turn", "branch"):
        np.testing.assert_array_equal(getattr(kept.path, name), getattr(path, name))
    assert np.linalg.norm(kept.wrench, axis=1).max() > 200.0
    np.testing.assert_array_equal(kept.wrench, alone.wrench)
    np.testing.assert_array_equal(kept.command.q, path.q)
    np.testing.assert_array_equal(kept.before, alone.before)
    assert np.isnan(kept.command.torque).all() and kept.command.torque.shape == path.q.shape


def test_a_path_that_is_too_fast_with_poses_put_in_is_solved_again_without_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At lower feeds, and as the path itself with those feeds is."""
    job_files = files(tmp_path, {}, WORN, rows=wavy(71, rapid=True))
    given = read_input(files_of(job_files.toolpath, None), job_files.cell)
    path, seen = planned(given.job, given.path), list[PlannedPath]()

    def slower(job: Job, finer: PlannedPath, q: npt.NDArray[np.float64]) -> PlannedPath:
        seen.append(finer)
        return replace(finer, toolpath=at_half(finer.toolpath)) if len(seen) == 1 else finer

    def at_half(toolpath: Toolpath) -> Toolpath:
        return replace(toolpath, feed=0.5 * toolpath.feed)

    monkeypatch.setattr(solving, "with_feeds_in_limits", slower)
    result = compensate(given.job, path)
    assert len(seen) == 2 and len(seen[0]) == len(seen[1]) > len(path)
    alone = compensate(given.job, replace(path, toolpath=at_half(path.toolpath)))
    np.testing.assert_array_equal(result.path.toolpath.feed, alone.path.toolpath.feed)
    np.testing.assert_array_equal(result.command.q, alone.command.q)
    np.testing.assert_array_equal(result.uncompensated.path.tcp.rotation, path.tcp.rotation)
    np.testing.assert_array_equal(result.uncompensated.path.toolpath.feed, 0.5 * path.toolpath.feed)


def test_a_path_whose_poses_are_others_is_kept_itself(tmp_path: Path) -> None:
    given_files = files(tmp_path, {}, WORN, rows=wavy(9, rapid=False))
    given = read_input(files_of(given_files.toolpath, None), given_files.cell)
    finer = planned(given.job, given.path)
    rows = np.array([0, 2, 3, 8])
    some = finer.take(rows)
    thin = thinned_path(some, finer)
    assert thin is not None
    np.testing.assert_array_equal(thin.rows, rows)
    np.testing.assert_array_equal(thin.q, some.q)
    moved = some.toolpath.position.copy()
    moved[1, 2] = np.nextafter(moved[1, 2], 1.0)
    assert thinned_path(replace(some, toolpath=replace(some.toolpath, position=moved)), finer) is None
    turned = some.tcp.rotation.copy()
    turned[3, 0, 0] = np.nextafter(turned[3, 0, 0], 2.0)
    assert thinned_path(replace(some, tcp=replace(finer.tcp.take(rows), rotation=turned)), finer) is None
    q = some.q.copy()
    q[2, 4] += 1e-15  # angles that differ are kept beside
    own = thinned_path(replace(some, q=q), finer)
    assert own is not None
    np.testing.assert_array_equal(own.q, q)


def test_actual_angles_that_are_the_nominal_ones_are_not_kept_twice() -> None:
    nominal = np.random.default_rng(3).uniform(-1, 1, (40, 6))
    actual = nominal.copy()
    actual[[3, 17]] += 1e-4
    command = MadeCommand(
        q=nominal + 1e-3, actual=actual, torque=nominal, nominal=lambda q: None,  # type: ignore[arg-type, return-value]
        error=np.zeros(40), extra=np.empty((40, 0)), steps=1,
    )  # fmt: skip
    kept = command.sharing(nominal)
    np.testing.assert_array_equal(kept.actual, actual)
    np.testing.assert_array_equal(kept.q, nominal + 1e-3)
    assert command.sharing(actual).actual is actual and kept.actual is not nominal
