"""Commands for a program that says positions alone: what a tool that stays upright leaves is taken back by position."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.errors import SolveError
from compensator.path.planner import Planner
from compensator.path.pose_names import place
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import follow
from compensator.solve.solve import refuse_unsafe
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]

ROUNDS = 5
ENOUGH = 1e-7  # m, mean


def untilted(c: Compensation) -> Compensation:
    """``c`` with the orientations of the path commanded at cuts, and positions that lead to the same place.

    Where a flank changes with every correction the position stays off by up to what the flank is worth; of all
    rounds the one with the least mean error counts.

    Raises:
        PathError, SolveError: a pose has no joint angles, or is none that a robot may be sent.
    """
    job, toolpath, rows = c.job, c.path.toolpath, np.flatnonzero(c.cutting)
    planner, some = Planner(job.cell, job.robot, job.inverse, job.tools), toolpath.take(rows)
    target, position = c.target_position[rows], c.command.position[rows]
    last = np.zeros_like(position)
    best: tuple[float, Floats, Floats] | None = None
    for _ in range(ROUNDS):
        flange = Frame(*planner.flange(some, c.path.rotation[rows], position))
        batch = job.inverse.along(flange, c.path.branch, c.command.q[rows])
        if not batch.ok.all():
            bad = int(np.argmin(batch.ok))
            raise SolveError(f"{place(some, bad)}: the pose without its tilt has no joint angles: {batch.why(bad)}")
        q = c.path.q.copy()
        q[rows] = batch.q
        error = follow(job, toolpath, q, c.wrench, c.state)[0].position[rows] - target
        turned = np.sum(error * last, axis=1) < 0.0  # a flank that changes with the correction: half of it
        last = error
        mean = float(np.linalg.norm(error, axis=1).mean())
        if best is None or mean < best[0]:
            best = mean, position, batch.q
        if mean < ENOUGH:
            break
        position = position - np.where(turned, 0.5, 1.0)[:, None] * error
    if best is None:
        return c
    where, q, rotation = c.command.position.copy(), c.command.q.copy(), c.command.rotation.copy()
    where[rows], q[rows], rotation[rows] = best[1], best[2], c.path.rotation[rows]
    upright = replace(c, command=replace(c.command, q=q, rotation=rotation, position=where))
    refuse_unsafe(planner, upright)
    return upright


def tilt(c: Compensation) -> tuple[float, int]:
    """Largest tilt of a commanded tool against the path, rad, and its pose."""
    off = np.linalg.norm(np.cross(c.command.rotation[:, :, 2], c.path.rotation[:, :, 2]), axis=1) * c.cutting
    k = int(np.argmax(off))
    return float(off[k]), k
