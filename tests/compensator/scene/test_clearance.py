"""Clearance of many postures at the poses of a path."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from compensator.cell.cell_file import load_cell
from compensator.program.robot_program import job_for
from compensator.scene.clearance import clearance
from compensator.solve.planned import planned
from tests.compensator import small_job
from tests.compensator.scene.test_collisions_of_a_path import STRAIGHT, WALL
from toolpaths.files import read_toolpath


def test_the_wall_is_in_the_way_at_its_poses_only(tmp_path: Path) -> None:
    files = small_job.files(tmp_path, cell={"tool": STRAIGHT, "scene": [WALL]})
    job, path = job_for(load_cell(files.cell), read_toolpath(files.toolpath))
    plan = planned(job, path)
    q = np.stack([plan.q, plan.q + np.eye(6)[0] * np.radians(20.0)], axis=1)  # and turned away
    free = clearance(job, plan.toolpath)(np.arange(len(plan)), q)
    x, y, z = plan.toolpath.position.T * 1e3
    inside = (np.abs(x - 50.0) < 7.0 + 1e-6) & (np.abs(y) < 20.0) & (z < 30.0)  # the wall and the radius of the line
    assert inside.any() and not inside.all()
    assert free[:, 0].tolist() == (~inside).tolist()
    assert free[:, 1].all()
