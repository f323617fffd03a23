"""The cheapest way of rails and tables along a path over an axis lattice, by dynamic programming."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from compensator.axes.axis_lattice import AxisLattice
from compensator.turn.coarse_turn import TURNING

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]

TRAVEL = 0.1 * 3e-5**2  # m3 for each m that a rail goes in the cut: 30 um squared along 0.1 m of path. It moves tons,
# and turns round with more lost motion than joints have; so does a table, by the way of what is farthest from its axis
AIR = 0.1  # of it between the cuts: no to and fro for nothing
SHARE = 0.7  # of the speed, from stage to stage: a smooth way has to swing
FASTEST = 6  # cells that an axis may go by from stage to stage
TURNED = 2  # columns that the turn may change by
STILL = 1e-14  # m3 for each cell squared, in the air too


@dataclass(frozen=True, eq=False)
class CoarseWay:
    """Places (S, A) and turns (S,) rad, unwrapped, at the stages; ``low``, ``high`` (S, A): free places about them."""

    places: Floats
    turn: Floats
    branch: int
    low: Floats
    high: Floats
    price: float


def cheapest_way(
    lattice: AxisLattice, shape: tuple[int, ...], *, one_turn: bool, still: bool = False
) -> CoarseWay | None:
    """The way over the places of a lattice, a grid of ``shape`` over the axes in their order; None: none leads through.

    Args:
        one_turn: the turn stays along the path. still: the axes do.
    """
    steps = [0] if one_turn or lattice.price.shape[2] == 1 else list(range(-TURNED, TURNED + 1))
    total, came = lattice.price[0], list[Rows]()
    walk = _Walk(lattice, shape, 0 if still else FASTEST)
    for k in range(1, len(lattice.price)):
        best, origin = np.full(total.shape, np.inf), np.zeros(total.shape, dtype=np.intp)
        for to, frm, cost in walk.offsets(k):
            for step in steps:
                tried = np.roll(total[frm], step, axis=1) + lattice.way(k, to, frm, step) + cost + TURNING * step**2
                better = tried < best[to]
                best[to] = np.where(better, tried, best[to])
                origin[to] = np.where(better, frm[:, None] * 100 + (step + 50), origin[to])
        total = best + lattice.price[k]
        came.append(origin)
    if not np.isfinite(total.min()):
        return None
    return walk.back(total, came)


@dataclass(frozen=True, eq=False)
class _Walk:
    lattice: AxisLattice
    shape: tuple[int, ...]
    fastest: int

    def offsets(self, k: int) -> Iterator[tuple[Rows, Rows, float]]:
        """Places that are gone to at stage k, those that they are gone to from, and the price of it, m3."""
        free, stages = self.lattice.stages.free, self.lattice.stages
        lasts, price = stages.time[k] - stages.time[k - 1], TRAVEL * (1.0 if stages.motion.cut[k - 1] else AIR)
        cells = (free.high - free.low) / np.maximum(np.array(self.shape) - 1, 1)
        index = np.arange(len(self.lattice.places)).reshape(self.shape)
        reach = []
        for a, count in enumerate(self.shape):
            moves = free.moving[a] and count > 1
            most = int(min(self.fastest, SHARE * free.speed[a] * lasts / cells[a])) if moves else 0
            reach.append(range(-min(most, count - 1), min(most, count - 1) + 1))
        for go in product(*reach):
            to = index[tuple(slice(max(g, 0), n + min(g, 0)) for g, n in zip(go, self.shape, strict=True))]
            frm = index[tuple(slice(max(-g, 0), n + min(-g, 0)) for g, n in zip(go, self.shape, strict=True))]
            gone = float(np.sum(np.abs(go) * cells * free.size))
            yield to.ravel(), frm.ravel(), STILL * float(np.sum(np.square(go))) + price * gone

    def back(self, total: Floats, came: list[Rows]) -> CoarseWay:
        """The way that leads to the cheapest end."""
        lattice, turns = self.lattice, total.shape[1]
        place, turn = (int(v) for v in np.unravel_index(np.argmin(total), total.shape))
        price, stages = float(total[place, turn]), len(lattice.price)
        at, columns = np.zeros(stages, dtype=np.intp), np.zeros(stages, dtype=np.intp)
        at[-1], columns[-1] = place, turn
        for k in range(stages - 1, 0, -1):
            frm, step = divmod(int(came[k - 1][at[k], columns[k] % turns]), 100)
            at[k - 1], columns[k - 1] = frm, columns[k] - (step - 50)
        low, high = self._room(at, columns % turns)
        angle = columns * (2 * np.pi / turns)
        return CoarseWay(lattice.places[at], angle, lattice.branch, low=low, high=high, price=price)

    def _room(self, at: Rows, column: Rows) -> tuple[Floats, Floats]:
        """(S, A) each: how far each axis alone may go from the way, over free places."""
        lattice, (stages, axes) = self.lattice, (len(at), len(self.shape))
        low, high = lattice.places[at].copy(), lattice.places[at].copy()
        free = np.isfinite(lattice.price).reshape(stages, *self.shape, -1)
        for k in range(stages):
            here = np.unravel_index(at[k], self.shape)
            for a in range(axes):
                line = free[(k, *(slice(None) if b == a else int(here[b]) for b in range(axes)), column[k])]
                values = np.linspace(lattice.stages.free.low[a], lattice.stages.free.high[a], len(line))
                if len(line) > 1:
                    first, last = _run(line, int(here[a]))
                    low[k, a], high[k, a] = values[first], values[last]
        return low, high


def _run(free: Bools, at: int) -> tuple[int, int]:
    """The first and the last of the free ones about ``at``."""
    first, last = at, at
    while first > 0 and free[first - 1]:
        first -= 1
    while last < len(free) - 1 and free[last + 1]:
        last += 1
    return first, last
