"""Grid: room for the field around what the cutters pass, and its growth."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.field import (
    BAND,
    FREE,
    NODES,
    SIDE,
    UNTOUCHED,
    WRITERS,
    Field,
)
from compensator.process.milling.kernels.profile import LENGTH
from compensator.process.milling.kernels.stock_distance import AROUND, KIND, MESH, Solid
from compensator.process.milling.kernels.sweep import AXIS, LAST, RADIUS, START, WAY

Floats = npt.NDArray[np.float64]

ROWS = 1024  # bricks with nodes to begin with


def empty_field(solid: Solid, moves: Floats, cell: float) -> Field:
    """The stock as it is, with bricks where the moves (M, at least 1) may cut it."""
    swept = swept_box(moves)
    low = np.maximum(swept[0], solid.number[AROUND : AROUND + 3]) - (BAND + 2.0) * cell
    high = np.minimum(swept[1], solid.number[AROUND + 3 :]) + (BAND + 2.0) * cell
    count = np.maximum(np.ceil((high - low) / (SIDE * cell)), 1).astype(int)
    return Field(
        np.array([*low, cell]),
        brick=np.full(count, UNTOUCHED, dtype=np.int32),
        around=np.full(count if solid.number[KIND] == MESH else (1, 1, 1), np.nan, dtype=np.float32),
        value=np.empty((ROWS, NODES, WRITERS), dtype=np.float32),
        writer=np.empty((ROWS, NODES, WRITERS), dtype=np.int32),
        free=np.arange(ROWS, dtype=np.int32)[::-1].copy(),
        state=np.array([ROWS, 0, 0]),
        seen=np.full(len(moves), -1, dtype=np.int64),
        range=np.zeros(6, dtype=np.int64),
        solid=solid,
        moves=moves,
    )


def swept_box(moves: Floats) -> Floats:
    """(2, 3) m, a box that holds all that the cutters pass."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for way, axis in ((0.0, AXIS), (1.0, LAST)):
        tip = moves[:, START : START + 3] + way * moves[:, WAY : WAY + 3]
        top = tip + moves[:, [LENGTH]] * moves[:, axis : axis + 3]
        wide = moves[:, [RADIUS]]
        for end in (tip, top):
            low, high = np.minimum(low, (end - wide).min(axis=0)), np.maximum(high, (end + wide).max(axis=0))
    return np.stack([low, high])


def grown(f: Field) -> Field:
    """The same field with room for twice as many bricks."""
    rows = len(f.value)
    more = np.arange(2 * rows - 1, rows - 1, -1, dtype=np.int32)
    free = np.empty(2 * rows, dtype=np.int32)
    used = f.state[FREE]
    free[:used], free[used : used + rows] = f.free[:used], more
    state = np.array([used + rows, *f.state[1:]])
    return f._replace(value=_longer(f.value), writer=_longer(f.writer), free=free, state=state)


def _longer(rows: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Twice the rows; the new ones are not touched, so that they take no memory until they are used."""
    out = np.empty((2 * len(rows), *rows.shape[1:]), dtype=rows.dtype)
    out[: len(rows)] = rows
    return out
