"""Lean cost: what turn and lean along a path cost: as turn cost, and a price of leaning.

    lean  LEANING squared at the edge of the cone, in proportion to the lean: less than that it is not worth, and where
          nothing is gained by it the tool stays upright

Standard deviations and what joints give are taken where the tool is, and their derivatives by small differences.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.path.chosen_turn import TurnValue
from compensator.path.lean import LeanRoom
from compensator.path.motion_bounds import MotionBounds
from compensator.turn.lean_kinematics import LeanKinematics, Some
from compensator.turn.reliance import ToolReliance
from compensator.turn.turn_cost import WINDUP, KeyMotion, priced_travel, runs, valued
from compensator.turn.turn_grid import Clearance
from compensator.turn.turn_kinematics import moves
from stiffness.kinematics.full_turns import nearest_turn

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]

LEANING = 3e-6  # m: what a lean at the edge of the cone is worth; a tenth of a usual standard deviation
SHIFT = 1e-4  # rad: of the differences
LONG = 20 * WINDUP  # a run of a joint that is to stay one: travel is cheap there, and a new reversal would be, too


@dataclass(frozen=True, eq=False)
class Postures:
    """At M keys: commands (M, n) rad; sd (M,) m; gap, windup (M, n) m of crossings; all without derivatives."""

    commands: Floats
    sd: Floats
    gap: Floats
    windup: Floats
    width: Floats  # (n,) rad, the largest gaps


@dataclass(frozen=True, eq=False)
class ArmRoom:
    """Where an arm may be: limits, singularities, and ``clear`` as in ``turn_grid``, of poses ``rows`` (K,)."""

    bounds: MotionBounds
    clear: Clearance | None
    rows: Rows

    @property
    def middle(self) -> Floats:
        """(n,) rad, of the limits; 0 where there are none."""
        low, high = self.bounds.robot.lower, self.bounds.robot.upper
        finite = np.isfinite(low + high)
        return np.where(finite, (np.where(finite, low, 0.0) + np.where(finite, high, 0.0)) / 2, 0.0)

    def within(self, q: Floats) -> Floats:
        """(M, n) rad, each joint as near as full turns bring it to the middle of its limits."""
        return np.asarray(nearest_turn(q, self.middle))

    def free(self, q: Floats, reach: Floats, some: Some) -> Bools:
        """(M,) whether the arm may be at joint angles (M, n) rad, ``reach`` (M,) m within reach, of some keys."""
        ok = (reach > 0) & np.isfinite(q).all(axis=1)
        near = np.where(ok[:, None], self.within(q), self.middle)
        ok &= self.bounds.margin(near) >= 0
        if self.clear is not None and ok.any():
            at = np.flatnonzero(ok)
            ok[at] = self.clear(self.rows[some][at], near[at, None])[:, 0]
        return ok


@dataclass(frozen=True, repr=False, eq=False)
class LeanCost:
    """The cost of states (K, 3) rad, turn and lean, along the keys of a path.

    Attributes:
        acceleration: (n,) rad/s2, limits; infinite where not known.
        reliance: by the kernel of ``kinematics.tool``.
        wrench: (K, 6) of the process, base axes; it does not turn with the tool.
        room: of the keys.
        offset: (K, n) rad, of solved commands from those at neutral joint states: flanks, as they were last seen.
    """

    kinematics: LeanKinematics
    motion: KeyMotion
    arm: ArmRoom
    acceleration: Floats
    reliance: tuple[ToolReliance, ...]
    wrench: Floats
    room: LeanRoom
    offset: Floats

    def postures(self, state: Floats, some: Some = slice(None)) -> Postures:
        """What there is at states (M, 3) of some keys, that are free."""
        q, _, _ = self.kinematics.angles(state, some)
        return self.at(self.arm.within(q), np.arange(len(self.wrench))[some])

    def at(self, q: Floats, rows: Rows) -> Postures:
        """What there is at joint angles (M, n) rad of keys ``rows`` (M,)."""
        sd, n = np.empty(len(q)), q.shape[1]
        lever, give, between = (np.empty((len(q), n)) for _ in range(3))
        for k, one in enumerate(self.reliance):
            at = np.flatnonzero(self.kinematics.tool[rows] == k)
            if len(at):
                nominal = self.kinematics.reference.origin[rows[at]]
                found = one.in_parts(q[at], self.wrench[rows[at]], nominal)
                _, sd[at], lever[at], give[at], between[at] = found
        width = between.max(axis=0, initial=0.0)
        commands = q - give + self.offset[rows]
        return Postures(commands=commands, sd=sd, gap=lever * between, windup=lever * WINDUP, width=width)

    def slopes(self, state: Floats, some: Some = slice(None)) -> tuple[Postures, Floats, Floats]:
        """``postures``, and derivatives of the commands (M, n, 3) and of the standard deviation (M, 3)."""
        rows, count = np.arange(len(self.wrench))[some], len(state)
        shifted = np.concatenate([state, *(state + SHIFT * np.eye(3)[k] for k in range(3))])
        q, slope, _ = self.kinematics.angles(shifted, np.tile(rows, 4))
        found = self.at(self.arm.within(q), np.tile(rows, 4))
        give = (self.arm.within(q) - found.commands).reshape(4, count, -1)  # less the offset, the same in all four
        sd = found.sd.reshape(4, count)
        more = np.moveaxis((give[1:] - give[0]) / SHIFT, 0, 2)
        first = {name: getattr(found, name)[:count] for name in ("commands", "sd", "gap", "windup")}
        here = Postures(**first, width=found.width)
        return here, slope[:count] - more, ((sd[1:] - sd[0]) / SHIFT).T

    def free(self, state: Floats, some: Some = slice(None)) -> Bools:
        """(M,) whether the arm may be at states (M, 3) of some keys."""
        q, _, reach = self.kinematics.angles(state, some)
        return self.arm.free(q, reach, some)

    def price(self, state: Floats) -> Floats:
        """(M,) m2 of leaning."""
        return np.asarray(LEANING**2 * np.linalg.norm(state[:, 1:], axis=1) / self.room.cone)

    def travel(self, state: Floats) -> tuple[Floats, Floats]:
        """(K - 1, n) m3 for each rad that joints travel, and the directions of long runs in the cut; 0: of none."""
        at = self.postures(state)
        way, cut = moves(at.commands), self.motion.cut
        long = cut[:, None] & (runs(way, cut) > LONG)
        return priced_travel(self.motion, way, at.gap, at.windup, width=at.width), np.where(long, np.sign(way), 0.0)

    def value(self, state: Floats, q: Floats | None = None) -> TurnValue:
        """What states (K, 3) rad cost; ``q``: (K, n) rad, their commands, where they are solved for."""
        at = self.postures(state)
        step = moves(at.commands if q is None else q)
        gaps = (at.gap, at.windup, at.width)
        value = valued(self.motion, step, at.sd, gaps=gaps, acceleration=self.acceleration)
        weight = self.motion.weight
        return replace(value, lean=float(np.sum(weight * self.price(state)) / max(weight.sum(), 1e-9)))
