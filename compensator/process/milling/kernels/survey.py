"""Survey: the field at points, on a regular grid, and the volume that is missing from the stock."""

from __future__ import annotations

from math import sqrt

import numpy as np

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.field import (
    AIR,
    CELL,
    NODES,
    SIDE,
    UNTOUCHED,
    WRITERS,
    Field,
    Floats,
    Floats32,
    Ints,
    brick_middle,
    exact_depth,
    near_depth,
)
from compensator.process.milling.kernels.stock_distance import stock_distance
from compensator.process.milling.kernels.sweep import Point
from compensator.process.milling.kernels.writing import node_place

PARTS = 2  # of a cell along each axis, where a surface passes it


@compiled
def depths(f: Field, points: Floats, reach: float, out: Floats) -> None:
    """The field (P,) at points (P, 3), m: exact where the surface may be nearer than ``reach`` m, else a bound."""
    for i in range(len(points)):
        out[i] = _depth(f, (points[i, 0], points[i, 1], points[i, 2]), reach)


@compiled
def _depth(f: Field, point: Point, reach: float) -> float:
    d = near_depth(f, point)
    return exact_depth(f, point) if abs(d) < reach else d


@compiled
def on_grid(f: Field, low: Floats, cell: float, out: Floats32) -> None:
    """The field at the nodes of a regular grid of its own, (nx, ny, nz), m."""
    nx, ny, nz = out.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                out[i, j, k] = _depth(f, (low[0] + i * cell, low[1] + j * cell, low[2] + k * cell), 1.75 * cell)


@compiled
def removed_volume(f: Field) -> float:
    """Volume of the stock that is gone, m3."""
    nx, ny, nz = f.brick.shape
    g, total = f.frame[CELL], 0.0
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                b = f.brick[i, j, k]
                if b == AIR:
                    total += _stock_in_brick(f, (i, j, k))
                elif b != UNTOUCHED:
                    for n in range(NODES):
                        if f.value[b, n, 0] > -g or f.value[b, n, 1] > -g:
                            total += _gone_at(f, node_place(f.frame, (i, j, k), n), f.value[b, n, 0])
    return total


@compiled
def _stock_in_brick(f: Field, at: tuple[int, int, int]) -> float:
    """Volume of the stock in a brick that is all air now, m3."""
    g = f.frame[CELL]
    half = 0.5 * SIDE * sqrt(3.0) * g
    d = stock_distance(f.solid, brick_middle(f.frame, at[0], at[1], at[2]), np.inf)
    if abs(d) > half:
        return (SIDE * g) ** 3 if d < 0.0 else 0.0
    total = 0.0
    for n in range(NODES):
        total += _gone_at(f, node_place(f.frame, at, n), g)
    return total


@compiled
def _gone_at(f: Field, point: Point, value: float) -> float:
    """Volume of the stock that is gone in the cell around a node with that value of the field, m3."""
    g, part = f.frame[CELL], f.frame[CELL] / PARTS
    d = stock_distance(f.solid, point, np.inf)
    if abs(d) > g and abs(value) >= g:
        return g * g * g if d < 0.0 and value > 0.0 else 0.0
    total = 0.0
    for n in range(PARTS * PARTS * PARTS):
        place = (
            point[0] + (n % PARTS + 0.5 * (1 - PARTS)) * part,
            point[1] + (n // PARTS % PARTS + 0.5 * (1 - PARTS)) * part,
            point[2] + (n // (PARTS * PARTS) + 0.5 * (1 - PARTS)) * part,
        )
        before = _filled(stock_distance(f.solid, place, np.inf), part)
        if before > 0.0:
            now = value if value >= g else exact_depth(f, place)
            total += before - _filled(now, part)
    return total * part * part * part


@compiled
def _filled(d: float, part: float) -> float:
    """Share of a cube that is inside, from the distance of its middle to a plane."""
    return min(max(0.5 - d / part, 0.0), 1.0)


@compiled
def writers_at(f: Field, points: Floats, out: Ints) -> None:
    """The move (P,) that cut deepest near points (P, 3); -1 where none did."""
    for i in range(len(points)):
        out[i] = _writer_near(f, (points[i, 0], points[i, 1], points[i, 2]))


@compiled
def _writer_near(f: Field, point: Point) -> int:
    g, best, who = f.frame[CELL], -np.inf, -1
    base = (
        int(np.floor((point[0] - f.frame[0]) / g)),
        int(np.floor((point[1] - f.frame[1]) / g)),
        int(np.floor((point[2] - f.frame[2]) / g)),
    )
    for corner in range(8):
        i, j, k = base[0] + (corner & 1), base[1] + (corner >> 1 & 1), base[2] + (corner >> 2)
        if i < 0 or j < 0 or k < 0 or i >= SIDE * f.brick.shape[0]:
            continue
        if j >= SIDE * f.brick.shape[1] or k >= SIDE * f.brick.shape[2]:
            continue
        b = f.brick[i // SIDE, j // SIDE, k // SIDE]
        if b < 0:
            continue
        n = ((i % SIDE) * SIDE + j % SIDE) * SIDE + k % SIDE
        for w in range(WRITERS):
            if f.writer[b, n, w] >= 0 and f.value[b, n, w] > best:
                best, who = f.value[b, n, w], f.writer[b, n, w]
    return who
