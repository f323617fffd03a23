"""The scene of an arm that stands still: no toolpath, one posture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.report.scene.arm_bodies import arm_length
from compensator.report.scene.flanks import lamps
from compensator.report.scene.packing import packed
from compensator.report.scene.scene import Scene, first_factor, job_bodies, limits, rows34, with_tcp
from stiffness.memory.preload import PreloadState
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]


def posture_scene(job: Job) -> Scene:
    """The arm where the path starts, or with its joints at zero, bent by its weight."""
    robot, arm = job.arm.robot, job.arm
    q = np.clip(np.zeros(robot.n), robot.lower, robot.upper) if job.placement.start is None else job.placement.start
    first = arm.unknown_state
    state = PreloadState(first.low[None], first.high[None], first.middle[None])
    still = _still(next(iter(arm.tools.by_number)))
    rigid, bent = with_tcp(arm.tools, still, *arm.links(still, q[None], np.zeros((1, 6)), state.middle))
    moved = rows34(bent) - rows34(rigid)
    tip = moved[:, -1, :, 3]
    return {
        "schema": "scene/1",
        "robot": robot.name,
        "source": job.placement.source,
        "links": robot.n + 2,
        "reach": arm_length(robot),
        "factor": first_factor(float(np.linalg.norm(tip)), arm_length(robot)),
        "worst": 0,
        "bodies": [body.as_dict() for body in job_bodies(job)],
        "stations": {
            "count": 1,
            "title": [f"{robot.name}: no toolpath"],
            "tool": still.tool.tolist(),
            "nominal": packed(rows34(rigid)),
            "before": packed(moved),
            "deflection": packed(tip),
            "work": packed(rows34(job.placement.workobject)),
            "moves": False,
        },
        "joints": {"limits": limits(robot), "q": packed(np.degrees(q)), "lamps": packed(lamps(arm, state), np.int8)},
        "findings": [],
    }


def _still(tool: int) -> Toolpath:
    """One pose, which nothing but the number of its tool is asked of."""
    none, one = np.zeros(1), np.ones(1, dtype=np.int32)
    return Toolpath(
        source="", language="csv", position=np.zeros((1, 3)), axis=np.array([[0.0, 0.0, 1.0]]), quaternion=None,
        feed=none, kind=np.zeros(1, dtype=np.uint8), tool=tool * one, spindle=none, sense=np.zeros(1, dtype=np.int8),
        line=one, row=none,
    )  # fmt: skip
