"""The base on a rail: what stands on the floor is in its way, at every place of the rail."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensator.cell.external_axes import on_ways
from compensator.cell.job import Job, load_job
from compensator.path.planned_path import PlannedPath
from compensator.scene.clearance import clearance
from compensator.scene.path_collisions import collisions_along
from compensator.solve.planned import sampled
from tests.compensator import small_job
from toolpaths.files import read_toolpath
from toolpaths.toolpath import Toolpath

# on the way of the base, lower than the arm reaches in the posture below
BLOCK = {"name": "block", "box": [[-150.0, 950.0, 0.0], [150.0, 1050.0, 300.0]]}
RAIL = {"carries": "robot", "direction": [0.0, 1.0, 0.0]}
UPRIGHT = np.radians([0.0, 0.0, 0.0, 0.0, 30.0, 0.0])


def on_rail(folder: Path, places: tuple[float, float], **cell: object) -> tuple[Job, Toolpath, PlannedPath]:
    """A path while the rail goes between two places, mm, the arm at rest."""
    files = small_job.files(folder, {"external": {"E1": RAIL}, **cell})
    job = load_job(files.cell)
    path = sampled(job.placement, read_toolpath(files.toolpath))
    stands = np.linspace(*places, len(path))
    moved = on_ways(job.placement, path, {"E1": stands})
    none = np.zeros(len(path))
    q = np.tile(UPRIGHT, (len(path), 1))
    return job, moved, PlannedPath(moved, job.planner.reference(moved), q, none, none.astype(np.int64))


def contacts(job: Job, path: PlannedPath) -> set[tuple[str, str]]:
    found = collisions_along(job, path.toolpath, path.q)
    return {found.names(a) for a in found.contacts if found.refuses(a)}


def test_the_base_drives_into_a_block(tmp_path: Path) -> None:
    job, toolpath, path = on_rail(tmp_path, (0.0, 2000.0), scene=[BLOCK])
    assert ("base", "block") in contacts(job, path)
    free = clearance(job, toolpath)(np.arange(len(path)), path.q[:, None])[:, 0]
    stands = np.linspace(0.0, 2000.0, len(path))
    assert not free[np.abs(stands - 1000.0) < 100.0].any() and free[np.abs(stands - 1000.0) > 900.0].all()


@pytest.mark.parametrize(("place", "hit"), [(1000.0, True), (0.0, False), (2000.0, False)])
def test_a_rail_that_stands(tmp_path: Path, place: float, hit: bool) -> None:
    job, _, path = on_rail(tmp_path, (place, place), scene=[BLOCK])
    assert (("base", "block") in contacts(job, path)) == hit


def test_what_rides_with_the_base(tmp_path: Path) -> None:
    cabinet = {"name": "cabinet", "box": [[-900.0, -100.0, 0.0], [-700.0, 100.0, 900.0]], "frame": "robot"}
    beside = {**BLOCK, "xyz": [-800.0, 0.0, 0.0]}
    job, _, path = on_rail(tmp_path, (0.0, 2000.0), scene=[beside, cabinet])
    assert contacts(job, path) == {("cabinet", "block")}


def test_neighbours_and_a_base_that_no_rail_moves(tmp_path: Path) -> None:
    """What the base stands on is declared; without a rail nothing moves between base and floor."""
    (tmp_path / "declared").mkdir()
    track = {"name": "track", "box": [[-300.0, -1000.0, -200.0], [300.0, 3000.0, 10.0]]}
    bare, _, path = on_rail(tmp_path, (0.0, 500.0), scene=[track])
    assert contacts(bare, path) == {("base", "track")}
    declared, _, path = on_rail(
        tmp_path / "declared", (0.0, 500.0), scene=[track], collisions={"neighbours": [["base", "track"]]}
    )
    assert contacts(declared, path) == set()
    still = replace(path, toolpath=replace(path.toolpath, ways=None))
    assert contacts(bare, still) == set()
