"""What a robot must not be sent: a correction above its bound, a command beyond limits, a load on an unknown joint."""

from __future__ import annotations

import numpy as np

from compensator.errors import SolveError
from compensator.path.pose_text import mm, place
from compensator.solve.compensation import Compensation
from toolpaths.finding import WARNING, Finding

FELT = 1.0  # N*m: less of a process is no load


def refuse_unsafe(c: Compensation) -> None:
    """Refuse a command beyond a limit, through a singularity, with a jump, or a correction above its bound."""
    toolpath = c.path.toolpath
    _check_identified(c)
    size = np.linalg.norm(c.correction, axis=1) * 1e3
    bound = c.job.placement.solve.max_correction
    if not np.all(size <= bound):
        k = int(np.argmax(np.where(np.isfinite(size), size, np.inf)))
        raise SolveError(
            f"{place(toolpath, k)}: correction {size[k]:.3f} mm is above solve.max_correction = {bound:g} mm "
            f"({int(np.sum(~(size <= bound)))} poses; TCP {mm(toolpath.position[k])} mm in the work object). Check the "
            "wrench, the stiffness and their units; gravity = 'uncompensated' adds the whole sag of the arm"
        )
    c.job.planner.check(toolpath, c.command.q, "commanded")
    inverse = c.job.planner.inverse
    if inverse.labelled:
        branch = inverse.inverse.configuration(c.command.q)
        other = branch != c.path.branch
        if other.any():
            k = int(np.argmax(other))
            raise SolveError(
                f"{place(toolpath, k)}: the corrected command lies in another arm configuration (ABB cfx {branch[k]}, "
                f"path {c.path.branch[k]}): too near the border between two; move [workobject] or choose another "
                "[start]"
            )


def _check_identified(c: Compensation) -> None:
    """Refuse a path that loads a joint whose stiffness the data did not determine."""
    for found in unidentified_loads(c):
        raise SolveError(f"{found.place}: {found.what}; {found.remedy}")


def unidentified_loads(c: Compensation) -> list[Finding]:
    """A warning for each joint that the process loads and whose stiffness the data did not determine."""
    out = []
    for effect, flags in c.job.arm.model.identified.items():
        if flags.all():
            continue
        unloaded = c.job.arm.forward(c.path.toolpath, c.command.q, np.zeros_like(c.wrench), c.state.middle)
        process = np.abs(c.command.torque - unloaded.torque)
        for j in np.flatnonzero(~flags):
            if process[:, j].max() > FELT:
                k = int(np.argmax(process[:, j]))
                what = (
                    f"the process loads joint {j + 1} with {process[k, j]:.0f} N*m, but {effect} of joint {j + 1} "
                    f"is not identified in {c.job.arm.model.source}"
                )
                out.append(Finding(WARNING, place(c.path.toolpath, k), what, "measure it first"))
    return out
