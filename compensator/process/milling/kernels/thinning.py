"""Thinning: moves taken away from the nodes of a regular grid without a memory of which move wrote what."""

from __future__ import annotations

from math import ceil, floor

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.field import Floats, Floats32
from compensator.process.milling.kernels.sweep import least_possible, span, sweep_distance


@compiled
def take_moves(moves: Floats, begin: int, end: int, share: float, low: Floats, cell: float, values: Floats32) -> None:
    """Take moves ``begin`` up to ``end`` away, of the last one the ``share`` that is done.

    Args:
        low: (3,) m, node 0; cell: m.
        values: (nx, ny, nz) m, signed distances to what is left, right within a cell of it.
    """
    for who in range(begin, end):
        _take(moves, who, share if who == end - 1 else 1.0, low, cell=cell, values=values)


@compiled
def _take(moves: Floats, who: int, share: float, low: Floats, cell: float, values: Floats32) -> None:
    nx, ny, nz = values.shape
    edge = 1.01 * cell
    ax, bx = span(moves, who, 0, edge)
    ay, by = span(moves, who, 1, edge)
    az, bz = span(moves, who, 2, edge)
    for i in range(max(ceil((ax - low[0]) / cell), 0), min(floor((bx - low[0]) / cell), nx - 1) + 1):
        for j in range(max(ceil((ay - low[1]) / cell), 0), min(floor((by - low[1]) / cell), ny - 1) + 1):
            for k in range(max(ceil((az - low[2]) / cell), 0), min(floor((bz - low[2]) / cell), nz - 1) + 1):
                least = max(values[i, j, k], -edge)
                if least >= cell:
                    continue
                point = (low[0] + i * cell, low[1] + j * cell, low[2] + k * cell)
                if -least_possible(moves, who, point) > least:
                    values[i, j, k] = max(values[i, j, k], -sweep_distance(moves, who, point, share)[0])
