"""Clearance: whether an arm touches nothing, at many postures for each of many poses of a path."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import rail_shift, workobject_along
from compensator.cell.job import Job
from compensator.scene.carrier_frames import STILL
from compensator.scene.collider import Collider
from compensator.scene.path_collisions import collider_of
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]


def clearance(
    job: Job, toolpath: Toolpath, margin: float = 0.0, collider: Collider | None = None
) -> Callable[[Rows, Floats], Bools]:
    """A function: poses (M,) of the path, joint angles (M, T, n) rad -> (M, T) whether nothing touches there.

    Args:
        margin: m, as near as this counts as touching.
        collider: of the job, where it is made.

    Raises:
        CellError: a mesh is refused, or a body that is declared as neighbour is not there.
    """
    if not job.placement.surroundings.settings.check:
        return lambda rows, q: np.ones(q.shape[:2], dtype=np.bool_)
    work, shift = workobject_along(job.placement, toolpath), rail_shift(job.placement, toolpath)
    turning = work.rotation.ndim > 2 and bool(np.ptp(work.rotation, axis=0).any())
    collider = collider or collider_of(job, on_rail=shift is not None, on_table=turning)
    tools = job.arm.tools

    def free(rows: Rows, q: Floats) -> Bools:
        count, turns = q.shape[:2]
        pose = np.repeat(rows, turns)
        out = np.ones(len(pose), dtype=np.bool_)
        tool, cutting = toolpath.tool[pose], toolpath.kind[pose] == CUT
        for number, cuts in {*zip(tool.tolist(), cutting.tolist(), strict=True)}:
            mine = np.flatnonzero((tool == number) & (cutting == cuts))
            hit = collider.collides(
                q.reshape(-1, q.shape[2])[mine],
                workobject=work.take(pose[mine]) if work.origin.ndim == 2 else work,
                world=STILL if shift is None else Frame(np.tile(np.eye(3), (len(mine), 1, 1)), shift[pose[mine]]),
                tool=None if tools.any_number else number, cutting=cuts, margin=margin,
            )  # fmt: skip
            out[mine] = ~hit
        return out.reshape(count, turns)

    return free
