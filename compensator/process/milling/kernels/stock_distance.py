"""Distance to the stock as it was before the first move: a box, a cylinder, or a mesh."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.triangles import Point, Tree, mesh_distance

Floats = npt.NDArray[np.float64]

BOX, CYLINDER, MESH = 0.0, 1.0, 2.0
KIND, SIZE, AROUND = 0, 1, 7
SOLID_NUMBERS = 13


class Solid(NamedTuple):
    """The stock as the kernels take it, m.

    Attributes:
        number: (13,) kind; size: of a box its least and largest corner, of a cylinder along z its middle x and y,
            radius, lower and upper end, 0, of a mesh its box; least and largest corner of what holds it.
        tree: of a mesh; of others, no triangles.
    """

    number: Floats
    tree: Tree


@compiled
def stock_distance(solid: Solid, point: Point, within: float) -> float:
    """Signed distance to the stock, m, negative inside; ``within`` is no less than its size, inf: not known."""
    if solid.number[KIND] == BOX:
        return _box(solid.number, point)
    if solid.number[KIND] == CYLINDER:
        return _cylinder(solid.number, point)
    return mesh_distance(solid.tree, point, within)


@compiled
def _box(n: Floats, point: Point) -> float:
    x = max(n[SIZE] - point[0], point[0] - n[SIZE + 3])
    y = max(n[SIZE + 1] - point[1], point[1] - n[SIZE + 4])
    z = max(n[SIZE + 2] - point[2], point[2] - n[SIZE + 5])
    least = max(x, max(y, z))
    if least <= 0.0:
        return least
    x, y, z = max(x, 0.0), max(y, 0.0), max(z, 0.0)
    return sqrt(x * x + y * y + z * z)


@compiled
def _cylinder(n: Floats, point: Point) -> float:
    x, y = point[0] - n[SIZE], point[1] - n[SIZE + 1]
    side = sqrt(x * x + y * y) - n[SIZE + 2]
    end = max(n[SIZE + 3] - point[2], point[2] - n[SIZE + 4])
    if side > 0.0 and end > 0.0:
        return sqrt(side * side + end * end)
    return max(side, end)
