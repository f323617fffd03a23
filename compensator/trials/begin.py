"""Where a trial begins: the arm configuration that it was chosen in, where the cell has no [start]."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.path.planner import Planner

Floats = npt.NDArray[np.float64]


def beginning_at(own: Planner, posture: Floats) -> Planner:
    """A planner whose arm comes from its own start, else from a ``posture`` (n,) rad."""
    start = posture if own.start is None else own.start
    return Planner(
        own.inverse,
        own.bounds,
        workobject=own.workobject,
        start=np.clip(start, own.robot.lower, own.robot.upper),
        free_tool_axis=own.free_tool_axis,
        source=own.source,
    )
