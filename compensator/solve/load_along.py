"""What the process does along a planned path."""

from __future__ import annotations

from dataclasses import replace

from compensator.cell.external_axes import workobject_along
from compensator.cell.job import Job
from compensator.path.planned_path import PlannedPath
from compensator.process.process import ProcessLoad, ToolMotion
from compensator.solve.cutter_offset import moves_cutter
from toolpaths.finding import merged
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath


def load_along(
    job: Job, path: PlannedPath, coarse: tuple[Toolpath, ProcessLoad] | None = None, deflected: Frame | None = None
) -> ProcessLoad:
    """What the process does along ``path``, its findings merged.

    Args:
        coarse: ``path`` is this one with poses put in, and what the process does along it.
        deflected: (N) where the TCP really is; None: on the path.
    """
    work = workobject_along(job.placement, path.toolpath)
    process, motion = job.placement.process, ToolMotion(path.toolpath, work, path.tcp, deflected)
    load = process.load(motion) if coarse is None else process.load_between(motion, *coarse)
    wall = load.wall if moves_cutter(job.arm) else None  # nobody else asks
    return replace(load, findings=merged(load.findings), wall=wall)
