"""Axis map: position along a path against the turn about the tool axis, with what each turn allows and costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.path.planned_path import PlannedPath
from compensator.turn.reliance import Reliance, assumed, left_out, reliance
from compensator.turn.turn_grid import TURNS, Clearance, TurnGrid, turn_grid
from stiffness.memory.last_direction import last_direction
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


@dataclass(frozen=True, repr=False, eq=False)
class AxisMap:
    """What every turn is worth along a path.

    Attributes:
        path: with the chosen turn.
        grid, reliance: at M of its poses.
        reversing: (M, T) joints that reverse on the way to this pose, at this turn all along; 0 on rapids.
    """

    path: PlannedPath
    grid: TurnGrid
    reliance: Reliance
    reversing: npt.NDArray[np.int8]

    def __repr__(self) -> str:
        return f"AxisMap({self.path.toolpath.source!r}, {self.grid!r})"

    @property
    def position(self) -> Floats:
        """(M,) m along the path, rapids included."""
        step = np.linalg.norm(np.diff(self.path.toolpath.on_part, axis=0), axis=1)
        return np.asarray(np.append(0.0, np.cumsum(step))[self.grid.rows])

    @property
    def chosen(self) -> Floats:
        """(M,) rad, the turn of the path, in [0, 2 pi)."""
        return np.asarray(self.path.turn[self.grid.rows] % (2 * np.pi))


def axis_map(
    job: Job, path: PlannedPath, wrench: Floats, *, poses: int, turns: int = TURNS, clear: Clearance | None = None
) -> AxisMap:
    """Map a path.

    Args:
        wrench: (N, 6) of the process, base axes, about the TCP.
        poses: at most so many are looked at, evenly along the path.
        clear: as in ``turn_grid``.

    Raises:
        PathError: the arm has no closed form.
    """
    rows = np.unique(np.linspace(0, len(path) - 1, min(poses, len(path))).round().astype(np.intp))
    grid = turn_grid(job.planner.inverse, job.planner.bounds, path, rows, turns=turns, clear=clear)
    found = reliance(job.arm, path, grid, wrench)
    return AxisMap(path, grid, found, _reversing(path, grid))


def map_findings(job: Job, m: AxisMap) -> list[Finding]:
    """What the map assumes, and what it shows at once."""
    out = []
    if assumed(job.arm):
        what = "no standard deviations in the model: a tenth of every joint stiffness stands in for them"
        out.append(Finding(NOTE, job.arm.model.source, what, "Measure it: compensator plan, identify", kind="model"))
    if names := left_out(job.arm):
        what = f"standard deviations of {', '.join(names)} take no part: only those of joint laws do"
        out.append(Finding(NOTE, job.arm.model.source, what, kind="model"))
    if job.arm.taken_off is None and job.placement.touches:
        what = "deflections are those of the arm: touching off is not taken off them"
        out.append(Finding(NOTE, job.placement.source, what, kind="cell"))
    if not m.grid.free.all(axis=0).any():
        what = "no turn serves all along the path in this arm configuration"
        remedy = 'Set [solve] turn = "path", or move [workobject]'
        out.append(Finding(WARNING, m.path.toolpath.source, what, remedy, kind="path"))
    return out


def _reversing(path: PlannedPath, grid: TurnGrid) -> npt.NDArray[np.int8]:
    shape = grid.status.shape
    q = np.where(grid.free[:, :, None], grid.q, np.nan)
    move = np.diff(q, axis=0, prepend=q[:1])
    move = np.nan_to_num((move + np.pi) % (2 * np.pi) - np.pi).reshape(shape[0], -1)
    sign = last_direction(move).reshape(*shape, -1)
    before = np.concatenate([sign[:1], sign[:-1]])
    turned = ((sign * before) < 0).sum(axis=2)
    cut = path.toolpath.kind[grid.rows] == CUT
    return np.where(cut[:, None] & grid.free, turned, 0).astype(np.int8)
