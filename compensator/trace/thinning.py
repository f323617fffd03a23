"""Thinning: which readings of a long trace a fit takes: evenly along the path, and all about its turning points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.session.path_trace import CommandedRows
from stiffness.session.turning import turning_rows

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

MOST = 2400  # readings: of five micrometres each they tell a tenth of one
TURNING = 0.25  # of them that stand about turning points, at most
EACH = 6  # readings on both sides of a turning point


def thinned(index: Floats, run: Ints, rows: CommandedRows) -> Ints:
    """Readings (K,) to take, in their order; all where there are few.

    What is left out lies between neighbours of the same flanks, which tell the same of the arm.
    """
    count = len(index)
    if count <= MOST:
        return np.arange(count)
    near = _about_turning_points(index, run, rows)
    if len(near) > TURNING * MOST:
        near = near[np.linspace(0, len(near) - 1, int(TURNING * MOST)).astype(np.int64)]
    order = np.lexsort((index, run))
    even = order[np.linspace(0, count - 1, MOST - len(near)).astype(np.int64)]
    return np.unique(np.concatenate([near, even]))


def _about_turning_points(index: Floats, run: Ints, rows: CommandedRows) -> Ints:
    at = np.unique(np.concatenate(turning_rows(rows.q))).astype(float)
    found: list[Ints] = []
    for one in np.unique(run):
        mine = np.flatnonzero(run == one)
        mine = mine[np.argsort(index[mine], kind="stable")]
        place = np.searchsorted(index[mine], at)
        near = (place[:, None] + np.arange(-EACH, EACH)).ravel()
        found.append(mine[np.unique(near[(near >= 0) & (near < len(mine))])])
    return np.unique(np.concatenate(found)) if found else np.empty(0, dtype=np.int64)
