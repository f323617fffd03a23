"""Axis lattice: a path against the places of its axes and the turn about the tool axis, and the cheapest way through.

Everything is looked at in one arm configuration. The turn has one column where the path gives the whole orientation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.axes.free_axes import DIGITS, FreeAxes
from compensator.cell.external_axes import workobject_along
from compensator.cell.job import Job
from compensator.path.planned_path import PlannedPath
from compensator.scene.clearance import clearance
from compensator.scene.collider import Collider
from compensator.turn.coarse_turn import BACK
from compensator.turn.reliance import ToolReliance, reliance
from compensator.turn.turn_cost import LASTS, WINDUP, KeyMotion
from compensator.turn.turn_grid import TurnGrid, turn_grid
from toolpaths.frame import Frame
from toolpaths.rotation import aligned
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]
Ints = npt.NDArray[np.int64]

TURNS = 24  # 15 deg apart: as many constant turns as a planner tries


@dataclass(frozen=True, repr=False, eq=False)
class PathStages:
    """S poses of a path that is decided at.

    Attributes:
        toolpath: the whole path, axes at 0. rows: (S,) of it. some: those poses. wrench: (S, 6) at ``turned_at``.
        motion: between the stages. allowed: (S - 1, n) rad that joints may go between them.
        time: (S,) s.
        collider: for contacts; None: nothing stands around.
        turned_at: (A,) places that the wrench was taken at. tools: reliance of each, by its number.
    """

    job: Job
    free: FreeAxes
    toolpath: Toolpath
    rows: Rows
    some: Toolpath
    wrench: Floats
    motion: KeyMotion
    allowed: Floats
    time: Floats
    collider: Collider | None
    turned_at: Floats
    tools: Mapping[int, ToolReliance]

    @property
    def turns(self) -> int:
        """Columns of the turn."""
        return TURNS if self.toolpath.quaternion is None and self.job.planner.free_tool_axis else 1

    def path(self, places: Floats, reference: Frame, branch: int) -> PlannedPath:
        """The stages with axes at places (A,), no joint angles yet."""
        some, count = self.free.on(self.some, places), len(self.rows)
        q, branches = np.zeros((count, self.job.arm.robot.n)), np.full(count, branch, dtype=np.int64)
        return PlannedPath(toolpath=some, tcp=reference, q=q, turn=np.zeros(count), branch=branches)

    def references(self, places: Floats) -> list[Frame]:
        """(S) TCP in the base before it is turned, at each of P places (P, A); rails move the origins alone."""
        planner, free, found = self.job.planner, self.free, dict[tuple[float, ...], Frame]()
        out = []
        for one in places:
            at = np.where(free.rail, 0.0, one)
            key = tuple(at.tolist())
            if key not in found:
                found[key] = planner.reference(free.on(self.toolpath, at)).take(self.rows)
            frame = found[key]
            out.append(Frame(frame.rotation, frame.origin - np.round(one, DIGITS) @ free.ways))
        return out

    def grids(self, places: Floats, references: list[Frame], branch: int) -> list[TurnGrid]:
        """Postures at each of P places (P, A)."""
        job, out = self.job, []
        for one, reference in zip(places, references, strict=True):
            path = self.path(one, reference, branch)
            clear = None if self.collider is None else clearance(job, path.toolpath, collider=self.collider)
            rows = np.arange(len(path))
            out.append(turn_grid(job.planner.inverse, job.planner.bounds, path, rows, turns=self.turns, clear=clear))
        return out

    def wrench_at(self, places: Floats, wrench: Floats) -> Floats:
        """A wrench (M, 6) with tables at places (A,): the part takes it along, unless it is given in base axes."""
        tables = np.where(self.free.rail, 0.0, places), np.where(self.free.rail, 0.0, self.turned_at)
        if self.free.rail.all() or self.job.placement.process.axes == "base":
            return wrench
        now, then = (turned_work(self.free, self.some, at) for at in tables)
        turn = now @ np.swapaxes(then, -1, -2)
        return (wrench.reshape(-1, 2, 3) @ np.swapaxes(turn, -1, -2)).reshape(-1, 6)

    def wrench_along(self, places: Floats, wrench: Floats) -> Floats:
        """The wrench (N, 6) of the whole path with axes at places (N, A)."""
        tables = places[:, ~self.free.rail]
        if not np.ptp(tables, axis=0).any() or self.job.placement.process.axes == "base":
            return self.wrench_at(places[0], wrench)
        now = workobject_along(self.job.placement, self.free.on(self.toolpath, places)).rotation
        turn = now @ turned_work(self.free, self.some, np.where(self.free.rail, 0.0, self.turned_at)).T
        return np.asarray(wrench.reshape(-1, 2, 3) @ np.swapaxes(turn, -1, -2)).reshape(-1, 6)

    def held_on(self, path: Toolpath, way: Floats) -> Floats:
        """(S,) rad that the lattice's turns are from those of a path whose table turns: where the reference of its tool
        lies against those of the lattice's places nearest to the way (S, A)."""
        if path.ways is None or path.ways.table is None:
            return np.zeros(len(self.rows))
        there = self.job.planner.reference(path).take(self.rows)
        each, index = np.unique(way, axis=0, return_inverse=True)
        lattice = np.empty((len(self.rows), 3, 3))
        for k, one in enumerate(self.references(each)):
            mine = np.flatnonzero(index.ravel() == k)
            lattice[mine] = one.rotation[mine]
        x = np.swapaxes(aligned(lattice, -there.z), 1, 2) @ there.rotation[:, :, :1]
        return np.asarray(np.unwrap(np.arctan2(x[:, 1, 0], x[:, 0, 0])))


def turned_work(free: FreeAxes, toolpath: Toolpath, places: Floats) -> Floats:
    """(3, 3) of the work object in the base with tables at places (A,)."""
    rotation = workobject_along(free.placement, free.on(toolpath.take([0]), places)).rotation
    return rotation[0] if rotation.ndim > 2 else rotation


@dataclass(frozen=True, repr=False, eq=False)
class AxisLattice:
    """S stages, P places, T turns in one arm configuration.

    Attributes:
        places: (P, A). branch: the arm configuration.
        q: (S, P, T, n) rad. price: (S, P, T) m3 of being there, infinite where forbidden.
        worth: (S, P, T, n) m3 for each rad that joints travel on the way there.
    """

    stages: PathStages
    places: Floats
    branch: int
    q: Floats
    price: Floats
    worth: Floats

    @classmethod
    def of(
        cls, stages: PathStages, places: Floats, grids: list[TurnGrid], *, references: list[Frame], branch: int
    ) -> AxisLattice:
        """With what is relied on in every cell that is free."""
        weight, price, worth = stages.motion.weight[:, None], list[Floats](), list[Floats]()
        cut = np.append(False, stages.motion.cut)[:, None, None]
        for one, grid, reference in zip(places, grids, references, strict=True):
            path = stages.path(one, reference, branch)
            found = reliance(stages.job.arm, path, grid, stages.wrench_at(one, stages.wrench), tools=stages.tools)
            price.append(np.where(grid.free, weight * np.nan_to_num(found.sd) ** 2, np.inf))
            edge = found.crossing**2 + (WINDUP * found.lever) ** 2
            worth.append(np.where(cut, np.nan_to_num(edge) * LASTS / BACK, 0.0))
        q = np.stack([grid.q for grid in grids], axis=1)
        return cls(stages, places, branch, q, price=np.stack(price, axis=1), worth=np.stack(worth, axis=1))

    def constant(self) -> Floats:
        """(P, T) m3 of places and turns that stay for the whole path; infinite where forbidden."""
        total = self.price.sum(axis=0)
        for k in range(1, len(self.price)):
            total = total + self.way(k, slice(None), slice(None), 0)
        return np.asarray(total)

    def way(self, k: int, to: Rows | slice, frm: Rows | slice, step: int) -> Floats:
        """(M, T) m3 of the joints' ways to places ``to`` at stage k from ``frm`` (M,) at k - 1, each from ``step``
        turns below; infinite where one is too fast."""
        move = self.q[k, to] - np.roll(self.q[k - 1, frm], step, axis=1)
        move = np.abs((move + np.pi) % (2 * np.pi) - np.pi)
        price = np.sum(self.worth[k, to] * move, axis=2)
        return np.where((move <= self.stages.allowed[k - 1]).all(axis=2), price, np.inf)

