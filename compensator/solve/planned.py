"""The path of a run: checked against the tools, sampled, and followed by the arm."""

from __future__ import annotations

import numpy as np

from compensator.cell.job import Job
from compensator.cell.placement import Placement
from compensator.errors import CellError
from compensator.path.added_poses import with_poses_before_corners
from compensator.path.planned_path import PlannedPath
from toolpaths.resample import resample
from toolpaths.toolpath import CUT, Toolpath


def planned(job: Job, toolpath: Toolpath) -> PlannedPath:
    """A toolpath as the arm of a job follows it.

    Raises:
        CellError, PathError, ToolpathError: a tool is missing, nothing cuts, or the arm cannot follow; names the pose.
    """
    return job.planner.plan(sampled(job.placement, toolpath))


def sampled(placement: Placement, toolpath: Toolpath) -> Toolpath:
    """The toolpath with points as [sampling] asks for, checked against the tools.

    Raises:
        CellError, ToolpathError: a tool is missing, nothing cuts, or there are too many poses.
    """
    _refuse_missing_tools(placement, toolpath)
    _refuse_without_cuts(toolpath)
    s = placement.sampling
    dense = resample(toolpath, spacing=s.spacing / 1e3, angle=np.radians(s.angle))
    return with_poses_before_corners(dense) if placement.process.axes == "path" else dense


def _refuse_missing_tools(placement: Placement, toolpath: Toolpath) -> None:
    """Refuse a tool call without a [tools.N]."""
    tools = placement.tools
    missing = ~np.isin(toolpath.tool, list(tools.by_number))
    if missing.any() and not tools.any_number:
        k = int(np.argmax(missing))
        number = int(toolpath.tool[k])
        what = f"tool {number} is called" if number else "moves before any tool call"
        raise CellError(
            f"{toolpath.source}:{toolpath.line[k]}: {what}, but {placement.source} has [tools.N] for "
            f"{', '.join(map(str, sorted(tools.by_number)))} only"
        )


def _refuse_without_cuts(toolpath: Toolpath) -> None:
    if not np.any(toolpath.kind == CUT):
        raise CellError(f"{toolpath.source}: no cutting move (feed) in it: nothing to compensate")
