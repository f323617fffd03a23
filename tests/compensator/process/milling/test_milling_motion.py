"""Which way a cutter goes on the part: with a deflection in it, and where a table carries the part."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from compensator.process.milling.milling import MillingProcess
from compensator.process.milling.path import arriving_axes
from compensator.process.process import ToolMotion
from compensator.tasks.compensate import preview_file
from tests.compensator.process.milling.milling_jobs import path
from tests.compensator.small_job import files, milling
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_rpy


def test_a_deflection_does_not_turn_the_path_axes() -> None:
    """At a corner it moves the tool a millimetre to the side while the feed goes on by 50 micrometres."""
    straight = path([[0, 0, 0], [10, 0, 0], [10.05, 0, 0], [20, 0, 0]])
    aside = straight.position + np.array([[0, 0, 0], [0, 0.3, 0], [0, 1.3, 0], [0, 0.3, 0]]) * 1e-3
    bent = replace(straight, position=aside, programmed=straight.way)
    np.testing.assert_allclose(arriving_axes(bent), arriving_axes(straight), atol=1e-15)
    turned = arriving_axes(replace(bent, programmed=None))
    assert turned[2, 1, 0] > 0.99  # without it the axes of that pose look along the deflection


def test_a_part_on_a_table_is_cut_as_if_it_stood_still(tmp_path: Path) -> None:
    """Tool and part move together, another way at every pose: on the part nothing changes."""
    job = files(tmp_path, {"process": milling(tmp_path)})
    c = preview_file(job.toolpath, job.cell).result
    process, work, tcp = c.job.placement.process, c.job.placement.workobject, c.path.tcp
    assert isinstance(process, MillingProcess)
    n = len(tcp.origin)
    rng = np.random.default_rng(4)
    turn = np.array([matrix_from_rpy(rng.uniform(-0.5, 0.5, 3)) for _ in range(n)])
    moved = Frame(turn, rng.uniform(-0.2, 0.2, (n, 3)))
    still, _ = process.milling_path(ToolMotion(c.path.toolpath, work, tcp))
    found, _ = process.milling_path(ToolMotion(c.path.toolpath, moved.then(work), moved.then(tcp)))
    np.testing.assert_allclose(found.position, still.position, atol=1e-12)
    np.testing.assert_allclose(found.axis, still.axis, atol=1e-12)
    assert np.ptp(still.position, axis=0).max() > 0.05


def test_the_wrench_of_some_poses_alone(tmp_path: Path) -> None:
    """As of the whole path on the same grid, in axes of a base that the work object is turned in; none without a
    spindle that turns."""
    job = files(tmp_path, {"process": milling(tmp_path)})
    c = preview_file(job.toolpath, job.cell).result
    process, path_ = c.job.placement.process, c.path
    assert isinstance(process, MillingProcess)
    turned = Frame(matrix_from_rpy(np.array([0.4, -0.3, 1.1])), np.array([0.1, 0.2, -0.1]))
    toolpath = path_.toolpath
    motion = ToolMotion(toolpath, turned.then(c.job.placement.workobject), turned.then(path_.tcp))
    load = process.load(motion)
    rows = np.flatnonzero(np.linalg.norm(load.wrench, axis=1) > 1.0)[::3]
    assert len(rows) > 3
    np.testing.assert_allclose(process.wrench_at(motion, rows, load.cell), load.wrench[rows], rtol=1e-12, atol=1e-12)
    still = replace(toolpath, spindle=np.where(np.arange(len(toolpath)) == rows[1], 0.0, toolpath.spindle))
    stopped = process.wrench_at(replace(motion, toolpath=still), rows, load.cell)
    assert not stopped[1].any() and np.linalg.norm(stopped[2]) > 1.0
