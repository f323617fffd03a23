"""Writing moves into the field: bricks that a cutter passes, node by node."""

from __future__ import annotations

from math import floor

import numpy as np

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.field import (
    AIR,
    BAND,
    CELL,
    DONE,
    FREE,
    HALF,
    NOBODY,
    NODES,
    SIDE,
    STOCK,
    UNTOUCHED,
    WRITERS,
    Field,
    Floats,
    brick_middle,
)
from compensator.process.milling.kernels.stock_distance import stock_distance
from compensator.process.milling.kernels.sweep import (
    BEGIN,
    END,
    RUN,
    Point,
    least_possible,
    span,
    sweep_distance,
)


@compiled
def bricks_of(f: Field, who: int) -> None:
    """First and last brick along x, y, z that a move may write, into ``f.range``; none where it is out of the grid."""
    for a in range(3):
        low, high = span(f.moves, who, a, BAND * f.frame[CELL])
        size = SIDE * f.frame[CELL]
        f.range[a] = max(floor((low - f.frame[a]) / size), 0)
        f.range[a + 3] = min(floor((high - f.frame[a]) / size), f.brick.shape[a] - 1)


@compiled
def room_for(f: Field, who: int) -> bool:
    """Whether there are rows for all bricks that a move may need."""
    bricks_of(f, who)
    at = f.range
    needed = 0
    for i in range(at[0], at[3] + 1):
        for j in range(at[1], at[4] + 1):
            for k in range(at[2], at[5] + 1):
                needed += f.brick[i, j, k] == UNTOUCHED
    return needed <= f.state[FREE]


@compiled
def write_move(f: Field, who: int) -> None:
    """Take the sweep of a move away from the stock."""
    bricks_of(f, who)
    at = f.range
    g = f.frame[CELL]
    reach = (BAND + HALF) * g
    for i in range(at[0], at[3] + 1):
        for j in range(at[1], at[4] + 1):
            for k in range(at[2], at[5] + 1):
                b = f.brick[i, j, k]
                if b == AIR:
                    continue
                middle = brick_middle(f.frame, i, j, k)
                if least_possible(f.moves, who, middle) > reach:
                    continue
                d, _ = sweep_distance(f.moves, who, middle, 1.0)
                if d > reach:
                    continue
                if d < -reach:
                    _release(f, b, (i, j, k))
                    continue
                if b == UNTOUCHED:
                    b = _begun(f, middle, (i, j, k))
                    if b == AIR:
                        continue
                if _write_brick(f, b, who, (i, j, k)) > BAND * g:
                    _release(f, b, (i, j, k))
    f.state[DONE] = who + 1


@compiled
def _release(f: Field, b: int, at: tuple[int, int, int]) -> None:
    """A brick that holds nothing but air gives its row back."""
    f.brick[at[0], at[1], at[2]] = AIR
    if b >= 0:
        f.free[f.state[FREE]] = b
        f.state[FREE] += 1


@compiled
def _begun(f: Field, middle: Point, at: tuple[int, int, int]) -> int:
    """Nodes for a brick, with the distance to the stock; AIR where the stock is out of reach."""
    g = f.frame[CELL]
    d = stock_distance(f.solid, middle, np.inf)
    if d > (BAND + HALF) * g:
        f.brick[at[0], at[1], at[2]] = AIR
        return AIR
    f.state[FREE] -= 1
    b = f.free[f.state[FREE]]
    f.brick[at[0], at[1], at[2]] = b
    deep = d < -(BAND + HALF) * g
    for n in range(NODES):
        f.value[b, n, 0], f.writer[b, n, 0] = d + HALF * g, STOCK
        for w in range(1, WRITERS):
            f.value[b, n, w], f.writer[b, n, w] = -np.inf, NOBODY
    if deep:
        return b
    within = abs(d) + HALF * g
    for n in range(NODES):
        point = node_place(f.frame, at, n)
        d = stock_distance(f.solid, point, within)
        f.value[b, n, 0] = d
        within = abs(d) + SIDE * g if (n + 1) % SIDE == 0 else abs(d) + g
        if (n + 1) % (SIDE * SIDE) == 0:
            within += SIDE * g
    return b


@compiled
def node_place(frame: Floats, at: tuple[int, int, int], n: int) -> Point:
    """Where node ``n`` of a brick stands, m."""
    g = frame[CELL]
    return (
        frame[0] + (SIDE * at[0] + n // (SIDE * SIDE)) * g,
        frame[1] + (SIDE * at[1] + n // SIDE % SIDE) * g,
        frame[2] + (SIDE * at[2] + n % SIDE) * g,
    )


@compiled
def _write_brick(f: Field, b: int, who: int, at: tuple[int, int, int]) -> float:
    """One move into the nodes of one brick; the least value that stands there then, m."""
    band = BAND * f.frame[CELL]
    least = np.inf
    for n in range(NODES):
        if f.value[b, n, 0] <= band:
            point = node_place(f.frame, at, n)
            bound = -least_possible(f.moves, who, point)
            if bound > -band and bound > f.value[b, n, WRITERS - 1]:
                v = -sweep_distance(f.moves, who, point, 1.0)[0]
                if v > -band:
                    _put(f, b, n, who, value=v)
        least = min(least, f.value[b, n, 0])
    return least


@compiled
def _put(f: Field, b: int, n: int, who: int, value: float) -> None:
    """Enter a writer in its place; of one smooth pass near the node only the best is kept."""
    m, last = f.moves, WRITERS - 1
    for w in range(WRITERS):
        old = f.writer[b, n, w]
        if old >= 0 and m[old, RUN] == m[who, RUN] and m[who, BEGIN] - m[old, END] < 2.0 * f.frame[CELL]:
            if f.value[b, n, w] >= value:
                return
            last = w
            break
    if f.value[b, n, last] >= value:
        return
    while last > 0 and f.value[b, n, last - 1] < value:
        f.value[b, n, last] = f.value[b, n, last - 1]
        f.writer[b, n, last] = f.writer[b, n, last - 1]
        last -= 1
    f.value[b, n, last] = value
    f.writer[b, n, last] = who
