"""Force and deflection together: a tool that is pushed off cuts less, or more, until both agree at every pose.

The walk through the stock gives the wrench at a deflection, the arm the deflection under a wrench. At every pose the
difference of the two is brought to zero by Broyden's method (Mathematics of Computation 19 (1965) 577), which learns
the local stiffness of the cut, 3 x 3, from the steps it makes; its first step is the plain fixed point.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import place
from compensator.process.process import ProcessLoad
from compensator.solve.compensate import as_it_is, uncompensated
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibrium_columns
from compensator.solve.load_along import load_along
from compensator.solve.touching_off import touched_off
from toolpaths.finding import WARNING, Finding, merged
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

ROUNDS, FEWEST, ENOUGH = 10, 2, 6
FEW = 0.02  # of the poses: as where a cutter enters, and the force jumps with the place
SLOW = 0.8  # of a residual, or of the poses that are open: less progress is none
CLOSE = 1e-6  # m between the deflection that was cut with and the one under the force of that cut
SHARE = 0.02  # of the deflection: or that
MOSTLY = 0.8  # of the open poses: then it is the places, and not the cut
CORNER = np.cos(np.radians(15.0))
LEVEL = 1e-3  # share of a feed along the tool
LONGEST = 2.0  # times the first deflection: a longer step is cut short


def previewed(job: Job, path: PlannedPath) -> Compensation:
    """The nominal path commanded; where the process follows the deflection, both are solved together.

    ``uncoupled`` of the result is the prediction with the force of the nominal path, where that differs.
    """
    if not job.placement.process.yields:
        return uncompensated(job, path)
    first, rotation = _predicted(job, path, load_along(job, path))
    return _coupled(job, path, first, rotation) if np.any(first.wrench) else first


def _predicted(job: Job, path: PlannedPath, load: ProcessLoad) -> tuple[Compensation, Floats]:
    """The path under this load, and the rotation (N, 3, 3) of the deflected TCP in the base."""
    job, names = touched_off(job, path), ("position", "torque", "rotation")
    start = job.placement.start
    columns, state = equilibrium_columns(job.arm, start, path.toolpath, q=path.q, wrench=load.wrench, names=names)
    return as_it_is(job, path, load, columns=columns, state=state), columns["rotation"]


def _coupled(job: Job, path: PlannedPath, first: Compensation, rotation: Floats) -> Compensation:
    """Deflections that the force of the cut with them causes; ``rotation``: of the TCP under the first."""
    cut = path.toolpath.kind == CUT
    still = path.tcp.origin
    at, now = np.zeros_like(still), first
    gain = np.tile(np.eye(3), (len(still), 1, 1))  # step per residual
    residual = first.error_before - at
    most = np.maximum(LONGEST * np.linalg.norm(residual, axis=1), CLOSE)[:, None]
    open_ = cut
    best = (first, residual, cut)
    for k in range(ROUNDS):
        step = np.einsum("nij,nj->ni", gain, residual)
        size = np.linalg.norm(step, axis=1, keepdims=True)
        step *= np.minimum(1.0, most / np.maximum(size, 1e-300))
        at = at + step
        deflected = Frame(rotation, still + at)
        now, rotation = _predicted(job, path, load_along(job, path, deflected=deflected))
        after = now.error_before - at
        gain = _learned(gain, step, after - residual)
        gain[np.linalg.norm(after, axis=1) > SLOW * np.linalg.norm(residual, axis=1)] *= 0.5
        before, residual = np.sum(open_), after
        open_ = cut & (np.linalg.norm(residual, axis=1) > CLOSE + SHARE * np.linalg.norm(now.error_before, axis=1))
        if k == 0 or open_.sum() <= best[2].sum():
            best = (now, residual, open_)
        few = open_.sum() < FEW * cut.sum()
        if not open_.any() or (k + 1 >= FEWEST and few) or (k + 1 >= ENOUGH and open_.sum() > SLOW * before):
            break
    now, residual, open_ = best
    # of the programmed path: a tool that springs back after a cut touches what it has left, which is no collision
    found = (*first.load.findings, *_not_settled(path, residual, open_))
    return replace(now, load=replace(now.load, findings=merged(found)), uncoupled=first)


def _learned(gain: Floats, step: Floats, change: Floats) -> Floats:
    """Broyden's update of the inverse Jacobian (N, 3, 3) after a step (N, 3) changed the residual by ``change``.

    Where the change tells nothing, as in the air or where an update would turn the step round, the gain stays.
    """
    moved = -np.einsum("nij,nj->ni", gain, change)  # the step that the gain would have made of the change
    along = np.einsum("ni,nij->nj", step, gain)
    size = -np.sum(along * change, axis=1)
    worth = size > 0.1 * np.sum(step * step, axis=1)
    worth &= np.linalg.norm(step, axis=1) > 1e-9
    update = (step - moved)[:, :, None] * along[:, None, :] / np.where(worth, size, 1.0)[:, None, None]
    return np.where(worth[:, None, None], gain + update, gain)


def _not_settled(path: PlannedPath, residual: Floats, open_: Bools) -> list[Finding]:
    if not open_.any():
        return []
    rows = np.flatnonzero(open_)
    worst = int(rows[np.argmax(np.linalg.norm(residual[rows], axis=1))])
    what = (
        f"force and deflection do not settle at {len(rows):,} poses: they differ by up to "
        f"{np.linalg.norm(residual[worst]) * 1e3:.3f} mm at {place(path.toolpath, worst)}"
    )
    jumps = int(np.sum(open_ & _where_the_force_jumps(path)))
    remedy = "The cut may be unstable: take less depth, or a stiffer posture"
    if jumps > MOSTLY * len(rows):
        what += f"; {jumps:,} of them where the force jumps with the place (corners, entries, ramps)"
        remedy = "There no steady force exists: take the poses beside them, or the uncoupled prediction"
    return [Finding(WARNING, place(path.toolpath, int(rows[0])), what, remedy, count=len(rows))]


def _where_the_force_jumps(path: PlannedPath) -> Bools:
    """(N,) poses next to a corner of the feed or an entry, and those of moves along the tool: it rides on a floor."""
    toolpath = path.toolpath
    way = np.diff(toolpath.on_part, axis=0, prepend=toolpath.on_part[:1])
    unit = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)
    bent = np.sum(unit[1:] * unit[:-1], axis=1) < CORNER  # true of moves without length, too
    begins = np.concatenate([[True], bent | (toolpath.kind[1:] != toolpath.kind[:-1])])
    ends = np.concatenate([begins[1:], [True]])
    second = np.concatenate([[False], begins[:-1]])
    sinking = np.abs(np.sum(unit * toolpath.axis_on_part, axis=1)) > LEVEL
    return np.asarray(begins | ends | second | sinking)
