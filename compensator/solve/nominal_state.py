"""The joint states of a path whose nominal poses are commanded: walked again where a picture asks for them."""

from __future__ import annotations

from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibrium_columns
from stiffness.memory.preload import PreloadState


def nominal_state(c: Compensation) -> PreloadState:
    """The state of every pose of ``c`` under its nominal commands, that is where it is not corrected."""
    if not c.is_corrected:
        return c.state
    if not c.inserted:
        return c.uncompensated.state
    arm, start = c.job.arm, c.job.placement.start
    _, state = equilibrium_columns(arm, start, c.path.toolpath, q=c.path.q, wrench=c.wrench, names=())
    return state
