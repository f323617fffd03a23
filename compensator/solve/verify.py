"""The finished program, read back from the disk and run through the model again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as File

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import axes_in_program, moved_workobject, printed_axes
from compensator.errors import SolveError
from compensator.path.pose_text import place
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibria
from toolpaths.columns import Column, MadeColumn, blocks
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
    printed, off, turned = _printed(c, path, language)
    if not np.all(np.maximum(off, turned) <= PRINTED):
        k = int(np.argmax(np.where(np.isfinite(off), np.maximum(off, turned), np.inf)))
        size = f"{off[k] * 1e6:.1f} um and {turned[k] * 1e6:.1f} urad"
        raise SolveError(f"{place(c.path.toolpath, k)}: {path} prints a pose that is {size} from the solved one")
    return Verified(_error(c, printed), float(off.max()))


def simulated(c: Compensation, path: File, language: str) -> SimulatedProgram:
    """The same for a program that may have been changed since.

    Raises:
        SolveError: it has another number of poses, or one that the arm cannot reach.
    """
    printed, off, turned = _printed(c, path, language)
    return SimulatedProgram(_error(c, printed), off, turned)


@dataclass(frozen=True, repr=False, eq=False)
class _Printed:
    """(N) TCP in the work object as printed; ``target`` (N, 3) m, base, where it has to be to meet the part."""

    tcp: Frame
    target: Column


def _printed(c: Compensation, path: File, language: str) -> tuple[_Printed, Floats, Floats]:
    """What is printed, and how far it is from the solved one: (N,) m, entries of the rotation."""
    text = read_back(path, language)
    if len(text) != len(c):
        raise SolveError(f"{path}: {len(text)} poses stand in the program, {len(c)} were solved")
    work, printed, commanded = c.job.placement.workobject, text.poses, c.printed
    on_axes, target, astray = _axes(c, text.external, path)
    if on_axes is not None:
        printed = moved_on_axes(on_axes, printed)
    if not text.turn_known:  # it is that of the solve
        printed = printed.mapped(lambda some, rows: _turned_as(some, work.rotation.T @ commanded.take(rows).rotation))
    off, turned = np.empty(len(c)), np.empty(len(c))
    for b in blocks(len(c)):
        tcp, solved = work.then(printed.take(b)), commanded.take(b)
        off[b] = np.linalg.norm(tcp.origin - solved.origin, axis=1)
        turned[b] = np.abs(tcp.rotation - solved.rotation).max(axis=(1, 2))
    return _Printed(printed, target), np.maximum(off, astray), turned


def moved_on_axes(on_axes: Frame, printed: Frame) -> Frame:
    """Printed poses (N) in the work object with all axes at 0; ``on_axes``: (N), or one of all."""
    one = on_axes.origin.ndim == 1
    return printed.mapped(lambda some, rows: (on_axes if one else on_axes.take(rows)).then(some))


def _turned_as(printed: Frame, rotation: Floats) -> Frame:
    return Frame(aligned(rotation, -printed.z), printed.origin)


def _axes(c: Compensation, external: Floats | None, path: File) -> tuple[Frame | None, Column, Floats]:
    """The work object as the poses of the program have it, the target (N, 3) m where its axes bring the part, and how
    far these are from where they were chosen, (N,)."""
    placement, toolpath, target = c.job.placement, c.path.toolpath, c.target
    names, chosen = [a.name for a in axes_in_program(placement, toolpath)], moved_workobject(placement, toolpath)
    if not names or chosen is None:
        return chosen, MadeColumn(len(c), lambda rows: target.take(rows).origin), np.broadcast_to(0.0, len(c))
    if external is None or external.shape != (len(toolpath), len(names)):
        raise SolveError(f"{path}: the program does not have {', '.join(names)} at every pose")
    poses, part, astray = printed_axes(placement, toolpath, external)
    work = placement.workobject
    on_part = work.then(chosen).inward(c.target.origin)
    return poses, work.then(part).at(on_part), astray


def _error(c: Compensation, printed: _Printed) -> Floats:
    """(N,) m: where commands for printed poses lead, to the target."""
    error, start, q = np.empty(len(c)), c.job.placement.start, _joint_angles(c, printed.tcp)
    for rows, found, _ in equilibria(c.job.arm, start, c.path.toolpath, q=q, wrench=c.wrench, guess=c.state):
        error[rows] = np.linalg.norm(found.position - printed.target[rows], axis=1)
    return error


def _joint_angles(c: Compensation, printed: Frame) -> Floats:
    """(N, n) rad of poses (N) in the work object, as the controller finds them; in blocks where it has a formula."""
    toolpath, inverse, out = c.path.toolpath, c.job.planner.inverse, np.empty_like(c.command.q)
    for b in blocks(len(c), None if inverse.labelled else len(c)):
        rows = np.arange(b.start, b.stop)
        tcp = c.job.placement.workobject.then(printed.take(rows))
        batch = inverse.along(toolpath.take(rows), tcp, c.path.branch[rows], c.command.q[rows])
        if not batch.ok.all():
            k = int(np.argmin(batch.ok))
            raise SolveError(f"{place(toolpath, b.start + k)}: the printed pose has no joint angles: {batch.why(k)}")
        out[rows] = batch.q
    return out
