"""The start of the choice: a turn along a path by dynamic programming on a coarse grid."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.path.cheapest_turn import cheapest_turn
from compensator.turn.turn_cost import LASTS, WINDUP, TurnCost

Floats = npt.NDArray[np.float64]

STAGES = 400  # keys that are decided on; the turn is straight between them
FASTEST = 6  # columns that the turn may change by from stage to stage
BACK = np.radians(1.0)  # of a joint: so much travel is priced as one crossing, for who travels less reverses less
TURNING = 1e-10  # m3 for each column squared: the reversals and accelerations that a bend makes, which the travel
# from stage to stage does not show; with a hundredth the start costs ten times the constant turn (docs/path-turn.md)


def coarse_turn(cost: TurnCost, allowed: Floats) -> Floats | None:
    """(K,) rad, unwrapped; None where no way leads along the path.

    Args:
        allowed: (K - 1, n) rad that each joint may go from key to key.
    """
    count = len(cost.sd)
    stages = np.unique(np.linspace(0, count - 1, min(count, STAGES)).round().astype(np.intp))
    price = np.where(cost.grid.free, cost.motion.weight[:, None] * cost.sd**2, np.inf)
    middle = np.append(0, (stages[1:] + stages[:-1] + 1) // 2)
    price = np.add.reduceat(price, middle, axis=0)
    most = np.add.reduceat(allowed, stages[:-1], axis=0)
    cut = np.logical_and.reduceat(cost.motion.cut, stages[:-1])
    q = cost.grid.q[stages]
    found = cost.reliance.crossing[stages[1:]] ** 2 + (WINDUP * cost.reliance.lever[stages[1:]]) ** 2
    worth = np.where(cut[:, None, None], np.nan_to_num(found) * LASTS / BACK, 0.0)

    def way(k: int, step: int) -> Floats:
        return _way(q[k - 1], q[k], step, most=most[k - 1], worth=worth[k - 1]) + TURNING * step**2

    columns = cheapest_turn(price, way, FASTEST)
    return None if columns is None else np.interp(np.arange(count), stages, columns * cost.grid.step)


def _way(before: Floats, after: Floats, step: int, *, most: Floats, worth: Floats) -> Floats:
    """(T,) price of the way to each column from the one ``step`` columns below; infinite where a joint is too fast."""
    move = after - np.roll(before, step, axis=0)
    move = np.abs((move + np.pi) % (2 * np.pi) - np.pi)
    price = np.sum(worth * move, axis=1)
    return np.where((move <= most).all(axis=1), price, np.inf)

