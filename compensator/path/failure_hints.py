"""Why an arm cannot follow a path where the joint at its limit is not the cause: [start], a part upside down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.path.first_postures import PROBES, FirstPostures
from compensator.path.free_turn import about_tool_axis, reference_rotation
from compensator.path.planner import Planner
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
UPWARDS = 0.5  # of the tool axis in the mean: 60 deg from straight up


def failure_hints(planner: Planner, toolpath: Toolpath, gravity: tuple[float, ...]) -> str:
    """What else may be wrong where a planner refuses a path, to go behind its message; empty where nothing is.

    Args:
        gravity: (3,) m/s2 in the base.
    """
    first = toolpath.take(np.arange((*planner.inverse.tools.changes(toolpath), len(toolpath))[0]))
    reference = planner.workobject.then(Frame(reference_rotation(first), first.position))
    hints = []
    other = _another_start(planner, first, reference)
    if other is not None:
        angles = ", ".join(f"{a:.0f}" for a in np.degrees(other))
        hints.append(
            f"[start] joints ask for an arm configuration that does not reach the path; another one does, such as "
            f"joints = [{angles}], or leave [start] out"
        )
    up = -np.asarray(gravity) / max(float(np.linalg.norm(gravity)), 1e-12)
    if float(np.mean(reference.rotation[:, :, 2] @ up)) > UPWARDS:
        hints.append("The tool looks upwards, the part is cut from below: is [workobject] rpy upside down?")
    return "".join(f". {hint}" for hint in hints)


def _another_start(planner: Planner, toolpath: Toolpath, reference: Frame) -> Floats | None:
    """(n,) rad from which the path can be followed, as far as some of its poses tell, where it cannot from start.

    Not for arms without a closed form: there the search takes minutes where there is no way.
    """
    start, robot = planner.start, planner.robot
    if start is None or len(start) != robot.n or not planner.inverse.labelled:
        return None
    turn_is_open = toolpath.quaternion is None and planner.free_tool_axis
    given = FirstPostures(planner.inverse, planner.bounds, start, turn_is_open)
    if _begin(given, toolpath, reference) is not None:
        return None
    return _begin(replace(given, start=None), toolpath, reference)


def _begin(choice: FirstPostures, toolpath: Toolpath, reference: Frame) -> Floats | None:
    """(n,) rad of the first pose, in a configuration that reaches some poses of the path within the joint limits."""
    probe = np.unique(np.linspace(0, len(toolpath) - 1, PROBES).astype(int))
    some, at = toolpath.take(probe), reference.take(probe)
    robot = choice.inverse.robot
    for begin in choice.for_path(toolpath, reference):
        batch = choice.inverse.along(some, about_tool_axis(at, begin.turn), begin.branch, begin.seed)
        q = choice.turns_in_limits(batch.q, batch.ok)
        if batch.ok.all() and np.all((q >= robot.lower) & (q <= robot.upper)):
            return np.asarray(q[0])
    return None
