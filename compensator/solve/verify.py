"""The finished program, read back from the disk and run through the model again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as File

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import carried
from compensator.errors import SolveError
from compensator.path.pose_names import place
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import follow
from toolpaths.files import read_back
from toolpaths.rotation import aligned

Floats = npt.NDArray[np.float64]

PRINTED = 2e-6  # m and rad: what a controller language may lose by printing


@dataclass(frozen=True, repr=False)
class Verified:
    """What the written program does in the model.

    Attributes:
        error: (N,) m, deflected TCP of the printed command to its target.
        printed: m, largest distance between a printed pose and the solve.
    """

    error: Floats
    printed: float

    def __repr__(self) -> str:
        return f"Verified(max {self.error.max() * 1e6:.3f} um, printing {self.printed * 1e6:.3f} um)"


def verify(c: Compensation, path: File, language: str) -> Verified:
    """Invert every printed pose as the controller will, and let the model deflect it.

    Raises:
        SolveError: the file does not say what was solved.
    """
    text = read_back(path, language)
    toolpath = c.path.toolpath
    if len(text.position) != len(c):
        raise SolveError(f"{path}: {len(text.position)} poses stand in the program, {len(c)} were solved")
    base = c.job.cell.workobject.matrix()
    where, turns = text.position, text.rotation
    if on_axes := carried(c.job.cell, toolpath):
        where, turns = on_axes.forth(where, turns)
    if not text.turn_known:  # it is that of the solve
        turns = aligned(base[:3, :3].T @ c.command.rotation, -turns[:, :, 2])
    rotation = base[:3, :3] @ turns
    position = where @ base[:3, :3].T + base[:3, 3]
    off = np.linalg.norm(position - c.command.position, axis=1)
    turned = np.abs(rotation - c.command.rotation).max(axis=(1, 2))
    if not np.all(np.maximum(off, turned) <= PRINTED):
        k = int(np.argmax(np.where(np.isfinite(off), np.maximum(off, turned), np.inf)))
        size = f"{off[k] * 1e6:.1f} um and {turned[k] * 1e6:.1f} urad"
        raise SolveError(f"{place(toolpath, k)}: {path} prints a pose that is {size} from the solved one")
    batch = c.job.inverse.along(*_flange(c, rotation, position), c.path.branch, c.command.q)
    if not batch.ok.all():
        k = int(np.argmin(batch.ok))
        raise SolveError(f"{place(toolpath, k)}: the printed pose has no joint angles: {batch.why(k)}")
    prediction, _ = follow(c.job, toolpath, batch.q, c.wrench, c.state)
    return Verified(np.linalg.norm(prediction.position - c.target_position, axis=1), float(off.max()))


def _flange(c: Compensation, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
    from compensator.path.planner import Planner

    return Planner(c.job.cell, c.job.robot, c.job.inverse, c.job.tools).flange(c.path.toolpath, rotation, position)
