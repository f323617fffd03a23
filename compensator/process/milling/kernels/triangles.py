"""Triangles of a closed mesh: the exact signed distance of a point, through a tree of boxes.

The sign follows from the angle-weighted normal of the nearest face, edge or vertex: Baerentzen, Aanaes, Signed distance
computation using the angle weighted pseudonormal, IEEE TVCG 11 (2005) 243. The nearest point of a triangle: Ericson,
Real-time collision detection (2005), 5.1.5.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.compiled import compiled, compiled_with_memory

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]
Point = tuple[float, float, float]

LEAF = 6  # triangles in a box that is not divided further
DEPTH = 64  # most boxes that wait


class Tree(NamedTuple):
    """Triangles in the order of the tree.

    Attributes:
        corner: (T, 3, 3) m, corner by corner.
        normal: (T, 7, 3) outward: of the face, of the edges 01, 12, 20, of the corners; any length.
        box: (B, 6) m, least and largest corner.
        child: (B, 2) the two boxes inside, or -1 - first triangle and their number.
        stack: (64,) room for boxes still to be looked at.
    """

    corner: Floats
    normal: Floats
    box: Floats
    child: Ints
    stack: Ints


@compiled_with_memory
def divided(corner: Floats) -> tuple[Ints, Floats, Ints]:
    """The tree of boxes: order (T,) of the triangles, boxes (B, 6), children (B, 2)."""
    count = len(corner)
    order = np.arange(count).astype(np.int32)
    middle = np.empty((count, 3))
    for i in range(count):
        for a in range(3):
            middle[i, a] = corner[i, 0, a] + corner[i, 1, a] + corner[i, 2, a]
    box = np.empty((max(2 * count, 1), 6))
    child = np.empty((max(2 * count, 1), 2), dtype=np.int32)
    stack = [(0, 0, count)]
    used = 1
    while len(stack) > 0:
        b, first, last = stack.pop()
        for a in range(3):
            box[b, a], box[b, a + 3] = np.inf, -np.inf
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for i in order[first:last]:
            for a in range(3):
                low[a], high[a] = min(low[a], middle[i, a]), max(high[a], middle[i, a])
                for c in range(3):
                    box[b, a] = min(box[b, a], corner[i, c, a])
                    box[b, a + 3] = max(box[b, a + 3], corner[i, c, a])
        if last - first <= LEAF:
            child[b, 0], child[b, 1] = -1 - first, last - first
            continue
        axis = np.argmax(high - low)
        part = order[first:last]
        order[first:last] = part[np.argsort(middle[part, axis])]
        half = (first + last) // 2
        child[b, 0], child[b, 1] = used, used + 1
        stack.append((used, first, half))
        stack.append((used + 1, half, last))
        used += 2
    return order, box[:used].copy(), child[:used].copy()


@compiled
def _box_square(box: Floats, b: int, point: Point) -> float:
    """Squared distance to a box, m2."""
    square = 0.0
    for a in range(3):
        out = max(box[b, a] - point[a], point[a] - box[b, a + 3], 0.0)
        square += out * out
    return square


@compiled
def mesh_distance(tree: Tree, point: Point, within: float) -> float:
    """Signed distance, m, negative inside.

    Args:
        within: m, no less than the distance; inf where nothing is known.
    """
    best, sign = within * within * (1.0 + 1e-9) + 1e-18, 0.0
    stack = tree.stack
    stack[0], height = 0, 1
    while height > 0:
        height -= 1
        b = stack[height]
        if _box_square(tree.box, b, point) > best:
            continue
        first, second = tree.child[b, 0], tree.child[b, 1]
        if first < 0:
            for i in range(-1 - first, -1 - first + second):
                square, side = _triangle(tree, i, point)
                if square < best:
                    best, sign = square, side
        else:
            nearer = _box_square(tree.box, first, point) < _box_square(tree.box, second, point)
            stack[height], stack[height + 1] = (second, first) if nearer else (first, second)
            height += 2
    return sqrt(best) if sign >= 0.0 else -sqrt(best)


@compiled
def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _triangle(tree: Tree, i: int, point: Point) -> tuple[float, float]:
    """Squared distance to a triangle, and on which side of its nearest place the point is."""
    c, n = tree.corner, tree.normal
    px, py, pz = point[0] - c[i, 0, 0], point[1] - c[i, 0, 1], point[2] - c[i, 0, 2]
    u = (c[i, 1, 0] - c[i, 0, 0], c[i, 1, 1] - c[i, 0, 1], c[i, 1, 2] - c[i, 0, 2])
    v = (c[i, 2, 0] - c[i, 0, 0], c[i, 2, 1] - c[i, 0, 1], c[i, 2, 2] - c[i, 0, 2])
    square = (_dot(u, u), _dot(u, v), _dot(v, v))
    a, b, k = _nearest_weights(square, _dot((px, py, pz), u), _dot((px, py, pz), v))
    rx, ry, rz = px - a * u[0] - b * v[0], py - a * u[1] - b * v[1], pz - a * u[2] - b * v[2]
    return rx * rx + ry * ry + rz * rz, rx * n[i, k, 0] + ry * n[i, k, 1] + rz * n[i, k, 2]


@compiled
def _nearest_weights(square: Point, pu: float, pv: float) -> tuple[float, float, int]:
    """Weights of the sides 01 and 02 at the nearest place, and what it is on: face 0, edges 1-3, corners 4-6."""
    uu, uv, vv = square
    if pu <= 0.0 and pv <= 0.0:
        return 0.0, 0.0, 4
    bu, bv = pu - uu, pv - uv  # seen from corner 1
    if bu >= 0.0 and bv <= bu:
        return 1.0, 0.0, 5
    vc = pu * bv - bu * pv
    if vc <= 0.0 and pu >= 0.0 and bu <= 0.0:
        return pu / (pu - bu), 0.0, 1
    cu, cv = pu - uv, pv - vv  # seen from corner 2
    if cv >= 0.0 and cu <= cv:
        return 0.0, 1.0, 6
    vb = cu * pv - pu * cv
    if vb <= 0.0 and pv >= 0.0 and cv <= 0.0:
        return 0.0, pv / (pv - cv), 3
    va = bu * cv - cu * bv
    if va <= 0.0 and bv - bu >= 0.0 and cu - cv >= 0.0:
        b = (bv - bu) / ((bv - bu) + (cu - cv))
        return 1.0 - b, b, 2
    scale = 1.0 / (va + vb + vc)
    return vb * scale, vc * scale, 0
