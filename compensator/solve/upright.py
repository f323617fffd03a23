"""Commands for a program without orientations: the tool keeps its own, and positions make up for the tilt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.errors import SolveError
from compensator.path.pose_text import place
from compensator.solve.command_bounds import refuse_unsafe
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibrium_along
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]

ROUNDS = 5
ENOUGH = 1e-7  # m, mean


def without_tilt(c: Compensation) -> Compensation:
    """``c`` with the orientations of the path commanded at cuts, and positions that lead to the same place.

    Where a flank changes with every correction the position stays off by up to what the flank is worth; of all
    rounds the one with the least mean error counts.

    Raises:
        PathError, SolveError: a pose has no joint angles, or is none that a robot may be sent.
    """
    job, toolpath, rows = c.job, c.path.toolpath, np.flatnonzero(c.cutting)
    some, rotation = toolpath.take(rows), c.path.tcp.take(rows).rotation
    target, position = c.target.take(rows).origin, c.command.position[rows]
    last = np.zeros_like(position)
    best: tuple[float, Floats, Floats] | None = None
    for _ in range(ROUNDS):
        batch = job.planner.inverse.along(some, Frame(rotation, position), c.path.branch[rows], c.command.q[rows])
        if not batch.ok.all():
            bad = int(np.argmin(batch.ok))
            raise SolveError(f"{place(some, bad)}: the pose without its tilt has no joint angles: {batch.why(bad)}")
        q = c.path.q.copy()
        q[rows] = batch.q
        prediction, _ = equilibrium_along(job.arm, job.placement.start, toolpath, q=q, wrench=c.wrench, guess=c.state)
        error = prediction.position[rows] - target
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
    printed, q = c.printed, c.command.q.copy()
    where, orientation = printed.origin.copy(), printed.rotation.copy()
    where[rows], q[rows], orientation[rows] = best[1], best[2], rotation
    upright = replace(c, command=replace(c.command, q=q, nominal=lambda _: Frame(orientation, where)))
    refuse_unsafe(upright)
    return upright


def largest_tilt(c: Compensation) -> tuple[float, int]:
    """Largest tilt of a commanded tool against the path, rad, and its pose."""
    off = np.linalg.norm(np.cross(c.command.rotation[:, :, 2], c.path.tcp.z), axis=1) * c.cutting
    k = int(np.argmax(off))
    return float(off[k]), k
