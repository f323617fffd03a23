"""Stations: the poses of a path at which the scene shows the arm, and the points at which it draws the path."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

MOST_STATIONS = 800  # of the arm; a slider on a screen has fewer steps
MOST_POINTS = 6000  # of the path
MOST_WANTED = 300  # poses that have to be among the stations, such as those of findings


def stations(count: int, wanted: Iterable[int] = (), most: int = MOST_STATIONS) -> Index:
    """Rows of ``count`` poses, ascending: first and last, the ``wanted`` ones, evenly many between them."""
    if count <= most:
        return np.arange(count)
    first = list(dict.fromkeys(k for k in wanted if 0 <= k < count))[:MOST_WANTED]
    even = np.linspace(0, count - 1, most - len(first)).round().astype(np.intp)
    return np.union1d(even, np.array(first, dtype=np.intp))


def nearest(rows: Index, pose: int) -> int:
    """Which of the ascending ``rows`` is nearest to a pose."""
    at = int(np.searchsorted(rows, pose))
    around = [k for k in (at - 1, at) if 0 <= k < len(rows)]
    return min(around, key=lambda k: abs(int(rows[k]) - pose))
