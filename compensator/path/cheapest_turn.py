"""The cheapest way over a grid of turns about the tool axis, by dynamic programming."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def cheapest_turn(price: Floats, way: Callable[[int, int], Floats | float], fastest: int) -> Floats | None:
    """(S,) columns, whole numbers unwrapped over the full turn, from stage to stage; None where no way leads through.

    Bellman's recursion: what a column costs is its price and the cheapest way to it of those before.

    Args:
        price: (S, T) of every stage and column, infinite where forbidden.
        way: stage k from 1, step s -> (T,) price of going to each column from the one s columns below, at k - 1.
        fastest: columns that the turn may change by from stage to stage.
    """
    stages, turns = price.shape
    steps = np.arange(-fastest, fastest + 1)
    total, came = price[0], np.zeros((stages, turns), dtype=np.intp)
    for k in range(1, stages):
        options = np.stack([np.roll(total, s) + way(k, int(s)) for s in steps])
        best = np.argmin(options, axis=0)
        total = options[best, np.arange(turns)] + price[k]
        came[k] = steps[best]
    if not np.isfinite(total.min()):
        return None
    column, out = int(np.argmin(total)), np.empty(stages)
    for k in range(stages - 1, -1, -1):
        out[k] = column
        column -= int(came[k, column % turns])
    return out
