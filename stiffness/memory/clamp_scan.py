"""Clamps applied one after the other along a path, without a Python loop over the poses.

A run of clamps is one clamp (effects/effect.py): rows are folded into runs that stand side by side, the clamp
of every run is composed, the states between the runs follow from a scan over those, and then every run is
walked from its own. Long paths are taken in pieces, so that the work stays in the cache. Who scans much has the runs
composed and walked in C, where there is a compiler: number for number the same.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.effects.memory import Clamp
from stiffness.memory.clamps_in_c import ClampsInC, clamps_in_c

Floats = npt.NDArray[np.float64]

_PIECE = 16384  # rows at a time
_WIDTH = 4096  # numbers side by side: numpy's overhead no longer counts, and they fit the first cache
_SHORT = 48  # rows; fewer are walked one by one
_FAR = 1e100  # beyond every state, and a million of it are still a number
_MUCH = 5_000_000  # numbers of rows, a tenth of a second in numpy: what a compiler takes


class _Work:
    """How much this process has scanned."""

    numbers = 0

    def more(self, numbers: int) -> bool:
        """Whether it is much, with so many more."""
        self.numbers += numbers
        return self.numbers > _MUCH


_DONE = _Work()


def scan(clamp: Clamp, starts: Floats) -> Floats:
    """States (S, rows, n) after every clamp of a run, from S states before the first.

    Args:
        clamp: arrays (rows, ...) of n numbers a row, at least one row.
        starts: (S, n).
    """
    rows = len(clamp.shift)
    shift, low, high = (a.reshape(rows, -1) for a in (clamp.shift, clamp.low, clamp.high))
    out = np.empty((len(starts), rows, starts.shape[1]))
    for first in range(0, rows, _PIECE):
        some = slice(first, first + _PIECE)
        if np.all(starts == starts[0]):  # they have met: one goes on for all
            starts = starts[:1]
        states = _states(np.clip(shift[some], -_FAR, _FAR), low[some], high[some], starts)
        out[:, some] = states.swapaxes(0, 1)
        starts = states[-1]
    return out


def _states(shift: Floats, low: Floats, high: Floats, starts: Floats) -> Floats:
    """(rows, S, n) from clamps (rows, n) and starts (S, n)."""
    rows, n = shift.shape
    if rows <= _SHORT or 4 * n >= _WIDTH:
        return _walked(shift, low, high, starts)
    length = max(16, -(-rows * n // _WIDTH))
    runs = -(-rows // length)
    if library := clamps_in_c() if _DONE.more(rows * n) else None:
        clamps = ClampsInC(library, shift, low, high, length=length)
        after = _states(*clamps.composed(_FAR), starts)
        return clamps.walked(np.concatenate([starts[None], after[:-1]]))
    shift, low, high = (_folded(a, runs, length, f) for a, f in ((shift, 0.0), (low, -_FAR), (high, _FAR)))
    bounds = np.repeat([[-_FAR], [_FAR]], runs * n, axis=1)
    for s, a, b in zip(shift, low, high, strict=True):
        _clamp(bounds, s, a, b, bounds)
    lowest, highest = bounds.reshape(2, runs, n)
    after = _states(shift.sum(axis=0).reshape(runs, n), lowest, highest, starts)
    before = np.concatenate([starts[None], after[:-1]]).swapaxes(0, 1).reshape(len(starts), runs * n)
    states = _walked(shift, low, high, before).reshape(length, len(starts), runs, n)
    return states.transpose(2, 0, 1, 3).reshape(-1, len(starts), n)[:rows]


def _walked(shift: Floats, low: Floats, high: Floats, state: Floats) -> Floats:
    """Row after row: (rows, S, n)."""
    out = np.empty((len(shift), *state.shape))
    for s, a, b, o in zip(shift, low, high, out, strict=True):
        _clamp(state, s, a, b, o)
        state = o
    return out


def _clamp(state: Floats, shift: Floats, low: Floats, high: Floats, out: Floats) -> None:
    np.add(state, shift, out=out)
    np.maximum(out, low, out=out)
    np.minimum(out, high, out=out)


def _folded(rows: Floats, runs: int, length: int, filler: float) -> Floats:
    """(length, runs * n) from (rows, n): row i of every run stands in row i; the last run is filled up."""
    n = rows.shape[1]
    full, whole = np.full((length, runs, n), filler), (runs - 1) * length
    full[:, :-1] = rows[:whole].reshape(runs - 1, length, n).swapaxes(0, 1)
    full[: len(rows) - whole, -1] = rows[whole:]
    return full.reshape(length, runs * n)
