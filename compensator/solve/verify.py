"""The finished program, read back from the disk and run through the model again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as File

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import moved_workobject
from compensator.errors import SolveError
from compensator.path.pose_text import place
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibrium_along
from toolpaths.files import read_back
from toolpaths.frame import Frame
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


@dataclass(frozen=True, repr=False)
class SimulatedProgram:
    """What a program that stands on the disk does in the model, whether or not it is the one that was solved.

    Attributes:
        error: (N,) m, deflected TCP of the printed command to its target.
        off, turned: (N,) m and 1: printed pose to the solved one; largest entry of the rotation's difference.
    """

    error: Floats
    off: Floats
    turned: Floats

    def __repr__(self) -> str:
        return f"SimulatedProgram(max {self.error.max() * 1e6:.3f} um)"

    @property
    def others(self) -> npt.NDArray[np.bool_]:
        """(N,) poses that are not the solved ones, beyond what printing loses."""
        return ~(np.maximum(self.off, self.turned) <= PRINTED)


def verify(c: Compensation, path: File, language: str) -> Verified:
    """Invert every printed pose as the controller will, and let the model deflect it.

    Raises:
        SolveError: the file does not hold what was solved.
    """
    tcp, off, turned = _printed(c, path, language)
    if not np.all(np.maximum(off, turned) <= PRINTED):
        k = int(np.argmax(np.where(np.isfinite(off), np.maximum(off, turned), np.inf)))
        size = f"{off[k] * 1e6:.1f} um and {turned[k] * 1e6:.1f} urad"
        raise SolveError(f"{place(c.path.toolpath, k)}: {path} prints a pose that is {size} from the solved one")
    return Verified(_error(c, tcp), float(off.max()))


def simulated(c: Compensation, path: File, language: str) -> SimulatedProgram:
    """The same for a program that may have been changed since.

    Raises:
        SolveError: it has another number of poses, or one that the arm cannot reach.
    """
    tcp, off, turned = _printed(c, path, language)
    return SimulatedProgram(_error(c, tcp), off, turned)


def _printed(c: Compensation, path: File, language: str) -> tuple[Frame, Floats, Floats]:
    """(N) TCP in the base as printed, and how far it is from the solved one: (N,) m and entries of the rotation."""
    text = read_back(path, language)
    toolpath = c.path.toolpath
    if len(text.position) != len(c):
        raise SolveError(f"{path}: {len(text.position)} poses stand in the program, {len(c)} were solved")
    work, printed = c.job.placement.workobject, Frame(text.rotation, text.position)
    if on_axes := moved_workobject(c.job.placement, toolpath):
        printed = on_axes.then(printed)
    if not text.turn_known:  # it is that of the solve
        turns = aligned(work.rotation.T @ c.command.rotation, -printed.rotation[:, :, 2])
        printed = Frame(turns, printed.origin)
    tcp = work.then(printed)
    off = np.linalg.norm(tcp.origin - c.command.position, axis=1)
    return tcp, off, np.abs(tcp.rotation - c.command.rotation).max(axis=(1, 2))


def _error(c: Compensation, tcp: Frame) -> Floats:
    """(N,) m: where commands for these poses lead, to the target."""
    toolpath = c.path.toolpath
    batch = c.job.planner.inverse.along(toolpath, tcp, c.path.branch, c.command.q)
    if not batch.ok.all():
        k = int(np.argmin(batch.ok))
        raise SolveError(f"{place(toolpath, k)}: the printed pose has no joint angles: {batch.why(k)}")
    prediction, _ = equilibrium_along(
        c.job.arm, c.job.placement.start, toolpath, q=batch.q, wrench=c.wrench, guess=c.state
    )
    return np.asarray(np.linalg.norm(prediction.position - c.target.origin, axis=1))
