"""A compensation as a robot program."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import carried
from compensator.cell.job import ONE_TOOL, Job
from compensator.path.pose_names import place
from compensator.solve.compensation import Compensation
from stiffness.kinematics.solvers import SphericalInverse
from toolpaths.frame import Frame
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.program import WARNING, Finding, Program

MM_MIN = 1.0 / 60000.0  # m/s


def program_of(c: Compensation, *, corrected: bool = True) -> Program:
    """The commands of a path in the work object, with everything a controller has to know.

    Args:
        corrected: False writes the nominal poses, as ``preview`` shows them.
    """
    job, path = c.job, c.path
    toolpath = path.toolpath
    to_work = np.linalg.inv(job.cell.workobject.matrix())
    rotation = c.command.rotation if corrected else path.rotation
    position = c.command.position if corrected else path.position
    joints = c.command.q if corrected else path.q
    deflection = c.target_position - position if corrected else c.error_before
    turn, origin = to_work[:3, :3], to_work[:3, 3]
    position, rotation = position @ turn.T + origin, turn @ rotation
    nominal_position, nominal_rotation = path.position @ turn.T + origin, turn @ path.rotation
    if on_axes := carried(job.cell, toolpath):
        position, rotation = on_axes.back(position, rotation)
        nominal_position, nominal_rotation = on_axes.back(nominal_position, nominal_rotation)
    feed, findings = _feed(job, toolpath)
    spherical = isinstance(job.inverse, SphericalInverse)
    return Program(
        name=job.cell.program.name,
        position=position,
        rotation=rotation,
        joints=joints,
        feed=feed,
        findings=findings,
        kind=toolpath.kind,
        tool=toolpath.tool if job.cell.tool is None else np.full_like(toolpath.tool, ONE_TOOL),
        line=toolpath.line,
        tools={
            k: ToolFrame(t.name, Frame(t.rotation, t.position), t.mass or None, t.com if t.mass else None)
            for k, t in job.tools.items()
        },
        workobject=Frame.of(job.cell.workobject.matrix()),
        rapid_speed=job.cell.program.rapid_feed * MM_MIN,
        configuration=job.inverse.configuration(joints).astype(np.int32) if spherical else None,
        start_joints=None if job.cell.start is None else np.radians(job.cell.start.joints),
        comments=tuple((e.pose, e.word) for e in toolpath.events if e.pose < len(toolpath)),
        robot=job.robot.name,
        source=toolpath.source,
        nominal_position=nominal_position,
        nominal_rotation=nominal_rotation,
        nominal_joints=path.q,
        wrench=c.wrench,
        deflection=deflection,
    )


def _feed(job: Job, toolpath: Toolpath) -> tuple[npt.NDArray[np.float64], tuple[Finding, ...]]:
    feed = np.where(toolpath.kind == CUT, toolpath.feed, np.nan)
    missing = (toolpath.kind == CUT) & ~(feed > 0)
    if not missing.any():
        return feed, ()
    default = job.cell.program.default_feed
    feed[missing] = default * MM_MIN
    what = f"no feed in the toolpath at {int(missing.sum())} cutting poses: {default:g} mm/min taken"
    remedy = "Give feeds in the toolpath, or program.default_feed in the cell"
    return feed, (Finding(WARNING, place(toolpath, int(np.argmax(missing))), what, remedy),)
