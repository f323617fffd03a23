"""Field: what is left of the stock, as signed distances on a grid that also knows which moves wrote them.

A composite distance field (Sullivan, Erdim, Perry, Frisken, High accuracy NC milling simulation using composite
adaptively sampled distance fields, Computer-Aided Design 44 (2012) 522). A node holds the largest of the distance to
the stock and the negative distances to the moves, with the move that wrote it, and the next ones of other passes.
Away from a surface the nearest node decides; near one the exact distances to the stock and to the moves that the
eight nodes around name, and to their neighbours along the path. Nodes stand in bricks of 8 x 8 x 8 that exist where a
surface is.
"""

from __future__ import annotations

from math import floor, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.stock_distance import KIND, MESH, Solid, stock_distance
from compensator.process.milling.kernels.sweep import BEGIN, END, RADIUS, RUN, Point, sweep_distance

Floats = npt.NDArray[np.float64]
Floats32 = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]
Longs = npt.NDArray[np.int64]

BITS = 3
SIDE = 1 << BITS  # nodes along a brick
NODES = SIDE**3
WRITERS = 3  # moves of different passes that a node remembers
BAND = 3.0  # cells: a move writes nodes up to here outside of it
STOCK, NOBODY = -1, -2  # writers that are no move
UNTOUCHED, AIR = -1, -2  # bricks without nodes: the stock alone counts; nothing is left
HALF = 0.5 * (SIDE - 1) * sqrt(3.0)  # cells from the middle of a brick to its corner nodes
_BEND = 0.25  # radii along the path that the nearest move of a bent path may be away from the one that wrote
FREE, DONE, QUESTION = 0, 1, 2
CELL = 3


class Field(NamedTuple):
    """The grid.

    Attributes:
        frame: (4,) m, where node 0 is, and the cell.
        brick: (nx, ny, nz) row of ``value``, or UNTOUCHED or AIR; around: m, distance from its middle to the stock,
            NaN: not asked for yet.
        value: (B, 512, 3) m, writer: (B, 512, 3); sorted, largest first.
        free: (B,) rows that no brick uses; state: how many these are, number of moves that are done, of the question.
        seen: (M,) last question in which a move was looked at; range: (6,) bricks that the move at hand may write.
        moves: (M, 29) straight moves that cut, in their order, see sweep.py.
        solid: the stock.
    """

    frame: Floats
    brick: Ints
    around: Floats32
    value: Floats32
    writer: Ints
    free: Ints
    state: Longs
    seen: Longs
    range: Longs
    moves: Floats
    solid: Solid


@compiled
def near_depth(f: Field, point: Point) -> float:
    """A bound of the field with its sign where the nearest node decides, else 0. m."""
    g = f.frame[CELL]
    x, y, z = (point[0] - f.frame[0]) / g, (point[1] - f.frame[1]) / g, (point[2] - f.frame[2]) / g
    i, j, k = floor(x + 0.5), floor(y + 0.5), floor(z + 0.5)
    b = brick_at(f.brick, i, j, k)
    if b == AIR:
        return g
    if b == UNTOUCHED:
        return _of_stock(f, (i >> BITS, j >> BITS, k >> BITS), point)
    x, y, z, n = x - i, y - j, z - k, node_at(i, j, k)
    bound = _sure(f.value[b, n, 0], (sqrt(x * x + y * y + z * z) + 1e-6) * g)
    who = f.writer[b, n, 0]
    if bound == 0.0 and who >= 0:  # one move that took the point away decides
        bound = max(-sweep_distance(f.moves, who, point, 1.0)[0], 0.0)
    return bound


@compiled
def _sure(v: float, away: float) -> float:
    """What a value of a signed distance leaves so far away from its place; 0: even the sign may differ."""
    if v > away:
        return v - away
    return v + away if v < -away else 0.0


@compiled
def _of_stock(f: Field, at: tuple[int, int, int], point: Point) -> float:
    """Where no move came near: the stock, from the middle of the brick where that decides."""
    nx, ny, nz = f.brick.shape
    i, j, k = at
    if f.solid.number[KIND] != MESH or i < 0 or j < 0 or k < 0 or i >= nx or j >= ny or k >= nz:
        return stock_distance(f.solid, point, np.inf)
    middle = brick_middle(f.frame, i, j, k)
    if np.isnan(f.around[i, j, k]):
        f.around[i, j, k] = stock_distance(f.solid, middle, np.inf)
    x, y, z = point[0] - middle[0], point[1] - middle[1], point[2] - middle[2]
    bound = _sure(f.around[i, j, k], sqrt(x * x + y * y + z * z) * (1.0 + 1e-6))
    return bound if bound != 0.0 else stock_distance(f.solid, point, np.inf)


@compiled
def brick_middle(frame: Floats, i: int, j: int, k: int) -> Point:
    """Where the middle of a brick is, m."""
    g, half = frame[CELL], 0.5 * (SIDE - 1)
    return frame[0] + (SIDE * i + half) * g, frame[1] + (SIDE * j + half) * g, frame[2] + (SIDE * k + half) * g


@compiled
def brick_at(brick: Ints, i: int, j: int, k: int) -> int:
    """The brick of a node; outside of the grid the stock alone counts."""
    bi, bj, bk = i >> BITS, j >> BITS, k >> BITS
    nx, ny, nz = brick.shape
    if bi < 0 or bj < 0 or bk < 0 or bi >= nx or bj >= ny or bk >= nz:
        return UNTOUCHED
    return brick[bi, bj, bk]


@compiled
def node_at(i: int, j: int, k: int) -> int:
    """Number of a node in its brick."""
    return (((i & SIDE - 1) << BITS | j & SIDE - 1) << BITS) | k & SIDE - 1


@compiled
def exact_depth(f: Field, point: Point) -> float:
    """The field from the exact distances to the stock and to the moves that wrote the eight nodes around. m."""
    g = f.frame[CELL]
    i, j = floor((point[0] - f.frame[0]) / g), floor((point[1] - f.frame[1]) / g)
    k = floor((point[2] - f.frame[2]) / g)
    f.state[QUESTION] += 1
    question, depth, stock = f.state[QUESTION], -np.inf, False
    for corner in range(8):
        ci, cj, ck = i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2)
        b = brick_at(f.brick, ci, cj, ck)
        if b < 0:
            stock = stock or b == UNTOUCHED
            continue
        n = node_at(ci, cj, ck)
        for w in range(WRITERS):
            who = f.writer[b, n, w]
            if who < 0:
                stock = stock or who == STOCK
            elif f.seen[who] != question:
                d = along_pass(f.moves, f.seen, who, point, question=question, done=f.state[DONE], cell=g)
                depth = max(depth, -d)
    if stock:
        return max(depth, stock_distance(f.solid, point, np.inf))
    return depth if depth > -np.inf else g


@compiled
def along_pass(
    moves: Floats, seen: Longs, who: int, point: Point, question: int, done: int, cell: float
) -> float:
    """Distance to the smooth pass around a move: down along the path from there."""
    seen[who] = question
    best, t = sweep_distance(moves, who, point, 1.0)
    slack = 2.0 * cell + _BEND * moves[who, RADIUS]
    start = best
    for way in (1, -1):
        at, share, here = who, t, start
        while True:
            length = moves[at, END] - moves[at, BEGIN]
            rest = (1.0 - share) * length if way > 0 else share * length
            following = at + way
            if rest > slack or following < 0 or following >= done or moves[following, RUN] != moves[who, RUN]:
                break
            if seen[following] == question:
                break
            seen[following] = question
            d, share = sweep_distance(moves, following, point, 1.0)
            if d >= here:
                break
            here, at = d, following
        best = min(best, here)
    return best
