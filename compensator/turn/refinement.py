"""The refinement: the turn at every key of a path by sequential quadratic programs, in windows that overlap.

Of a window the cost is made small by Gauss-Newton steps: variance of the deflection, travel of joints, and
accelerations at the programmed feed. Crossings are not smooth: travel of the commanded joints stands in for them, at a
price that makes a run in one direction cost as much as a crossing. Short runs are the dearest, and vanish first when
it is done again. Limits and singularities are bounds: a corridor of free cells of the grid about the start. So are the
ways from key to key.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.turn.turn_cost import TurnCost
from compensator.turn.turn_grid import TurnGrid
from compensator.turn.turn_kinematics import moves
from compensator.turn.windows import (
    DAMPING,
    STILL,
    Refined,
    descended,
    minimised,
    refined_in_windows,
    smooth_weights,
    travelled,
)

Floats = npt.NDArray[np.float64]

STEPS = 12
TRUST = np.radians(10.0)  # of a step


def refined(cost: TurnCost, turn: Floats, allowed: Floats) -> Refined:
    """A turn that costs less than ``turn`` (K,) rad, or the same.

    Args:
        allowed: (K - 1, n) rad that each joint may go from key to key.
    """
    low, high = corridor(cost.grid, turn)
    price = cost.travel_price(turn, moves(cost.commands(turn)[0]))

    def solve(part: slice, held: int, now: Floats) -> Floats | None:
        ways = slice(part.start, part.stop - 1)
        return _Window(cost, part, held, price=price[ways], allowed=allowed[ways]).solved(now, low[part], high[part])

    return refined_in_windows(turn, solve)


def corridor(grid: TurnGrid, turn: Floats) -> tuple[Floats, Floats]:
    """(K,) rad each, unwrapped as ``turn`` (K,): free cells on both sides of it; the turn itself where it is not."""
    base = np.floor(turn / grid.step).astype(np.intp)
    k, turns = np.arange(len(turn)), len(grid.turns)
    below, above = np.zeros(len(turn)), np.zeros(len(turn))
    going = [grid.free[k, base % turns], grid.free[k, (base + 1) % turns]]
    for reach in range(1, turns // 2):
        going[0] = going[0] & grid.free[k, (base - reach) % turns]
        going[1] = going[1] & grid.free[k, (base + 1 + reach) % turns]
        below, above = below + going[0], above + going[1]
    inside = grid.free_at(turn)
    low = np.where(inside, np.minimum((base - below) * grid.step, turn), turn)
    high = np.where(inside, np.maximum((base + 1 + above) * grid.step, turn), turn)
    alone = inside & ~grid.free[k, base % turns]  # on the column above, exactly
    return np.where(alone, turn, low), high


@dataclass(frozen=True, eq=False)
class _Window:
    """Some keys of a path.

    Attributes:
        part: which ones. held: how many of the first ones stay.
        price, allowed: (m - 1, n) of the ways between: m3/rad for travel, rad at most.
    """

    cost: TurnCost
    part: slice
    held: int
    price: Floats
    allowed: Floats

    def solved(self, turn: Floats, low: Floats, high: Floats) -> Floats | None:
        """(m,) rad; None where a program failed."""
        low, high = low.copy(), high.copy()
        low[: self.held] = high[: self.held] = turn[: self.held]
        return descended(
            turn,
            size=self._size,
            step=lambda now: self._step(now, np.maximum(low - now, -TRUST), np.minimum(high - now, TRUST)),
            moved=np.add,
            steps=STEPS,
        )

    def _size(self, turn: Floats) -> float:
        """m3, the smooth cost that steps make smaller."""
        q, _ = self.cost.commands(turn, self.part)
        way, (weight, rough, before, after) = moves(q), smooth_weights(self.cost.motion, self.part)
        sd, _ = self.cost.deviation(turn, self.part)
        bent = (after * way[1:] - before * way[:-1]) / self.cost.acceleration
        return float(np.sum(weight * sd**2) + travelled(self.price, way) + np.sum(rough * bent**2))

    def _step(self, turn: Floats, low: Floats, high: Floats) -> Floats | None:
        """(m,) rad within bounds (m,) that minimises the quadratic model; None where the program failed."""
        q, g = self.cost.commands(turn, self.part)
        way, (weight, rough, before, after) = moves(q), smooth_weights(self.cost.motion, self.part)
        sd, slope = self.cost.deviation(turn, self.part)
        d0, gradient = 2 * weight * slope**2, 2 * weight * sd * slope
        d1, d2 = np.zeros(len(turn) - 1), np.zeros(max(len(turn) - 2, 0))
        pull = self.price / np.sqrt(way**2 + STILL**2)
        d0[:-1] += np.sum(pull * g[:-1] ** 2, axis=1)
        d0[1:] += np.sum(pull * g[1:] ** 2, axis=1)
        d1 -= np.sum(pull * g[:-1] * g[1:], axis=1)
        gradient[:-1] -= np.sum(pull * way * g[:-1], axis=1)
        gradient[1:] += np.sum(pull * way * g[1:], axis=1)
        limit = self.cost.acceleration
        bent = (after * way[1:] - before * way[:-1]) / limit
        parts = (before * g[:-2] / limit, -(before + after) * g[1:-1] / limit, after * g[2:] / limit)
        for k, one in enumerate(parts):
            at = slice(k, len(turn) - 2 + k)
            d0[at] += 2 * np.sum(rough * one**2, axis=1)
            gradient[at] += 2 * np.sum(rough * one * bent, axis=1)
        d1[:-1] += 2 * np.sum(rough * parts[0] * parts[1], axis=1)
        d1[1:] += 2 * np.sum(rough * parts[1] * parts[2], axis=1)
        d2 += 2 * np.sum(rough * parts[0] * parts[2], axis=1)
        scale = float(d0.max())
        if scale == 0.0:  # nothing depends on the turn
            return np.zeros(len(turn))
        bands = ((d0 + DAMPING * scale) / scale, d1 / scale, d2 / scale)
        return _program(bands, gradient / scale, g, way, allowed=self.allowed, bounds=(low, high))


def _program(
    bands: tuple[Floats, Floats, Floats], gradient: Floats, g: Floats, way: Floats, *, allowed: Floats,
    bounds: tuple[Floats, Floats],
) -> Floats | None:  # fmt: skip
    """Minimise x H x / 2 + gradient x, H of three bands; ways (m - 1, n) with slopes g (m, n) stay within allowed."""
    m, n = g.shape
    solver, h, a = _solver(m, n)
    most = np.maximum(allowed, np.abs(way))
    x = minimised(
        solver, h=ca.DM(h, _banded(*bands)), a=ca.DM(a, _columns(g)), g=gradient,
        lba=(-most - way).ravel(), uba=(most - way).ravel(), lbx=bounds[0], ubx=bounds[1],
    )  # fmt: skip
    return None if x is None else np.asarray(np.clip(x, *bounds))


@lru_cache(maxsize=8)
def _solver(m: int, n: int) -> tuple[ca.Function, ca.Sparsity, ca.Sparsity]:
    """PIQP for m keys and n joints, and the patterns of its matrices."""
    h = ca.Sparsity.banded(m, 2)
    rows = np.repeat(np.arange((m - 1) * n), 2)
    columns = (np.arange((m - 1) * n)[:, None] // n + np.arange(2)).ravel()
    a = ca.Sparsity.triplet((m - 1) * n, m, rows.tolist(), columns.tolist())
    return ca.conic("turn", "piqp", {"h": h, "a": a}, {"error_on_fail": False, "print_time": False}), h, a


def _banded(d0: Floats, d1: Floats, d2: Floats) -> Floats:
    """The numbers of a symmetric matrix of five bands, column by column."""
    m = len(d0)
    table = np.full((m, 5), np.nan)
    table[2:, 0], table[1:, 1], table[:, 2], table[:-1, 3], table[:-2, 4] = d2, d1, d0, d1, d2
    flat = table.ravel()
    return np.asarray(flat[~np.isnan(flat)])


def _columns(g: Floats) -> Floats:
    """The numbers of the matrix that makes ways of steps, column by column: g ends one way, and begins the next."""
    m = len(g)
    table = np.stack([g, -g], axis=1)
    keep = np.ones((m, 2), dtype=bool)
    keep[0, 0] = keep[-1, 1] = False
    return np.asarray(table[keep].ravel())
