"""Axis cost: what places of rails and tables along a path cost, at its turns: as turn cost, and a price of moving.

    axes  TRAVEL for each metre that a rail goes, or the part on a table, in the air a tenth; ROUGH squared where it
          accelerates with its limit, the square of the share below

Standard deviations and what joints give are taken where the tool is, their derivatives by small differences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.axes.cheapest_way import AIR, TRAVEL
from compensator.axes.free_axes import FreeAxes
from compensator.axes.table_turn import TableTurn
from compensator.cell.job import Job
from compensator.path.chosen_turn import TurnValue
from compensator.path.planned_path import PlannedPath
from compensator.turn.lean_cost import ArmRoom, Postures
from compensator.turn.reliance import ToolReliance
from compensator.turn.turn_choice import key_motion
from compensator.turn.turn_cost import ROUGH, WINDUP, KeyMotion, priced_travel, valued
from compensator.turn.turn_kinematics import configuration_signs, kernels_by_tool, moves
from stiffness.numerics.kernel import Kernel
from stiffness.statics.tool import Tool
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]
Some = slice | Rows

KEYS = 3000  # poses that costs are taken at
SHIFT = 1e-4  # m, of the differences


@dataclass(frozen=True, repr=False, eq=False)
class AxisCost:
    """The cost of places (K, A), mm or deg, at the keys of a path; tables that are set once stay where they are.

    Attributes:
        rows: (K,) poses of the path. tcp: (K) in the base, with rails at 0.
        acceleration: (n,) rad/s2 limits of joints. allowed: (K - 1, n) rad that they may go.
        wrench: (K, 6) of the process, base axes, where the path has tables; rails do not change it.
        table: that turns along the path; None: none may.
    """

    free: FreeAxes
    rows: Rows
    tcp: Frame
    signs: Floats
    tool: Rows
    kernels: tuple[Kernel, ...]
    motion: KeyMotion
    acceleration: Floats
    allowed: Floats
    arm: ArmRoom
    reliance: tuple[ToolReliance, ...]
    wrench: Floats
    table: TableTurn | None

    @classmethod
    def of(
        cls, job: Job, free: FreeAxes, path: PlannedPath, *, wrench: Floats, tools: Mapping[int, ToolReliance]
    ) -> AxisCost:
        """Of a path that is followed with axes where it has them; ``wrench`` (N, 6), ``tools`` by their numbers."""
        rows = np.unique(np.linspace(0, len(path) - 1, min(len(path), KEYS)).round().astype(np.intp))
        inverse, some = job.planner.inverse, path.toolpath.take(rows)
        tool, kernels = kernels_by_tool(inverse, some.tool, _placed)
        motion, acceleration, allowed = key_motion(job, path, rows)
        at, tcp = places_of(free, path)[rows], path.tcp.take(rows)
        numbers = list(inverse.tools.by_number)
        return cls(
            free=free, rows=rows, tcp=Frame(tcp.rotation, tcp.origin + at @ free.ways),
            signs=configuration_signs(path.branch[rows]), tool=tool, kernels=kernels, motion=motion,
            acceleration=acceleration, allowed=allowed, arm=ArmRoom(job.planner.bounds, None, rows),
            reliance=tuple(tools[k] for k in numbers), wrench=wrench[rows], table=TableTurn.of(free, path, rows, at),
        )  # fmt: skip

    def angles(self, places: Floats, some: Some = slice(None)) -> tuple[Floats, Floats, Floats]:
        """(M, n) rad without regard to full turns, (M, n, A) by the places (M, A) of rails, and (M,) m within reach."""
        rotation, origin = self.tcp.rotation[some], self.tcp.origin[some]
        signs, tool = self.signs[some], self.tool[some]
        if self.table is not None:
            rotation, origin = self.table.moved(rotation, origin, places, some)
        rotation, origin = rotation.reshape(-1, 9), origin - places @ self.free.ways
        q, slope, reach = np.empty((len(places), 6)), np.empty((len(places), 18)), np.empty(len(places))
        for k, kernel in enumerate(self.kernels):
            at = np.flatnonzero(tool == k)
            if len(at):
                q[at], slope[at], margins = kernel.run(rotation[at], origin[at], signs[at])
                reach[at] = margins.min(axis=1)
        by_position = slope.reshape(-1, 3, 6).swapaxes(1, 2)
        return q, -by_position @ self.free.ways.T, reach

    def at(self, q: Floats, places: Floats, some: Some = slice(None)) -> Postures:
        """What there is at joint angles (M, n) rad of some keys, with axes at places (M, A)."""
        rows, n, load = np.arange(len(self.rows))[some], q.shape[1], self.wrench[some]
        load = load if self.table is None else self.table.load(load, places, some)
        sd, (lever, give, between) = np.empty(len(q)), (np.empty((len(q), n)) for _ in range(3))
        for k, one in enumerate(self.reliance):
            mine = np.flatnonzero(self.tool[rows] == k)
            if len(mine):
                found = one.in_parts(q[mine], load[mine], self.tcp.origin[rows[mine]])
                _, sd[mine], lever[mine], give[mine], between[mine] = found
        width = between.max(axis=0, initial=0.0)
        return Postures(commands=q - give, sd=sd, gap=lever * between, windup=lever * WINDUP, width=width)

    def postures(self, places: Floats, some: Some = slice(None)) -> Postures:
        """What there is at places (M, A) of some keys, that are free."""
        return self.at(self.arm.within(self.angles(places, some)[0]), places, some)

    def slopes(self, places: Floats, some: Some = slice(None)) -> tuple[Postures, Floats, Floats]:
        """``postures``, and derivatives of the commands (M, n, A) and of the standard deviation (M, A) by mm or deg."""
        q, slope, _ = self.angles(places, some)
        here, width = self.at(self.arm.within(q), places, some), places.shape[1]
        more, sd = np.zeros_like(slope), np.zeros((len(q), width))
        for a in np.flatnonzero(self.free.moving):
            shift = SHIFT / self.free.size[a]
            there = places + shift * np.eye(width)[a]
            off = self.angles(there, some)[0]
            found = self.at(self.arm.within(off), there, some)
            give, before = self.arm.within(off) - found.commands, self.arm.within(q) - here.commands
            more[:, :, a], sd[:, a] = (give - before) / shift, (found.sd - here.sd) / shift
            if not self.free.rail[a]:
                slope[:, :, a] = ((off - q + np.pi) % (2 * np.pi) - np.pi) / shift
        return here, slope - more, sd

    def allows(self, places: Floats, some: Some = slice(None)) -> Bools:
        """(M,) whether the arm may be there: reach, limits, singularities."""
        q, _, reach = self.angles(places, some)
        return self.arm.free(q, reach, some)

    def travel(self, places: Floats) -> Floats:
        """(K - 1, n) m3 for each rad that joints travel."""
        at = self.postures(places)
        return priced_travel(self.motion, moves(at.commands), at.gap, at.windup, width=at.width)

    @property
    def toll(self) -> Floats:
        """(K - 1,) m3 for each m that an axis goes between the keys."""
        return np.where(self.motion.cut, TRAVEL, AIR * TRAVEL)

    def value(self, places: Floats, bends: Floats | None = None) -> TurnValue:
        """What places (K, A) cost; ``bends``: accelerations (K, A) of axes, per s2, where they move."""
        at = self.postures(places)
        gaps = (at.gap, at.windup, at.width)
        value = valued(self.motion, moves(at.commands), at.sd, gaps=gaps, acceleration=self.acceleration)
        if bends is None:
            return value
        moving, weight = self.free.moving, self.motion.weight
        way = np.abs(np.diff(places, axis=0))[:, moving] * self.free.size[moving]
        rough = ROUGH**2 * np.sum(np.where(moving, bends / self.free.acceleration, 0.0) ** 2, axis=1)
        axes = np.sum(weight * rough) + np.sum(self.toll * way.sum(axis=1))
        return replace(value, axes=float(axes / max(weight.sum(), 1e-9)))


def places_of(free: FreeAxes, path: PlannedPath) -> Floats:
    """(N, A) where the axes stand along a path."""
    ways = path.toolpath.ways
    if ways is None:
        return np.zeros((len(path), len(free)))
    at = ways.at(path.toolpath.row)
    return np.stack([at[name] for name in free.names], axis=1)


def _placed(inverse: ca.Function, tool: Tool) -> ca.Function:
    """(R (9) row-major, p (3), signs (3)) of the TCP -> q (n), dq/dp (n x 3 by columns), margins."""
    flat, p, signs = ca.SX.sym("R", 9), ca.SX.sym("p", 3), ca.SX.sym("s", 3)
    flange = ca.mtimes(ca.reshape(flat, 3, 3).T, ca.DM(np.asarray(tool.rotation.T)))
    q, margins, _ = inverse(ca.vec(flange.T), p - ca.mtimes(flange, ca.DM(np.asarray(tool.position))), signs)
    outputs = [ca.densify(q), ca.vec(ca.densify(ca.jacobian(q, p))), ca.densify(margins)]
    return ca.Function("placed", [flat, p, signs], outputs)
