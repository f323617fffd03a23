"""Turning points: the rows of a commanded path at which a joint reverses; the rounding of a file is no reversal."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.memory.last_direction import last_direction

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


def turning_rows(q: Floats) -> list[Index]:
    """Per joint the rows (K,) of commands (R, n) rad at which it turns, ascending."""
    if len(q) < 3:
        return [np.empty(0, dtype=np.intp) for _ in q.T]
    direction = last_direction(np.diff(q, axis=0))
    return [_rows(way, angle) for way, angle in zip(direction.T, q.T, strict=True)]


def _rows(way: Floats, angle: Floats) -> Index:
    """Where a change of direction (R - 1,) is seen the joint has turned a little before: at its farthest angle."""
    changes = np.flatnonzero((way[1:] != way[:-1]) & (way[:-1] != 0)) + 1
    out, begin = [], 0
    for k in changes.tolist():
        between = angle[begin : k + 1] * way[k - 1]
        begin += int(np.argmax(between))
        out.append(begin)
    return np.array(out, dtype=np.intp)
