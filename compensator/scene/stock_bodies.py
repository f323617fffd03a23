"""Stock bodies: stock and finished part of a milling process, on the work object."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from compensator.cell.placement import Placement
from compensator.scene.body import WORKOBJECT, Body, Role
from compensator.scene.shape import BoxShape, CylinderShape, MeshShape, Shape3
from compensator.scene.tool_bodies import milling_of
from toolpaths.frame import Frame

if TYPE_CHECKING:
    from compensator.process.milling.stock import Stock


def stock_bodies(placement: Placement) -> list[Body]:
    """Stock and part where the process has them."""
    process = milling_of(placement.process)
    if process is None:
        return []
    out = [_body("stock", process.shop.stock)]
    if process.shop.part is not None:
        out.append(_body("part", process.shop.part))
    return out


def _body(role: Role, stock: Stock) -> Body:
    from compensator.process.milling.kernels.stock_distance import BOX, CYLINDER, KIND, SIZE

    number = stock.solid.number
    shape: Shape3
    middle = np.zeros(3)
    if number[KIND] == BOX:
        low, high = number[SIZE : SIZE + 3], number[SIZE + 3 : SIZE + 6]
        shape, middle = BoxShape(high - low), 0.5 * (low + high)
    elif number[KIND] == CYLINDER:
        x, y, radius, low_z, high_z = (float(v) for v in number[SIZE : SIZE + 5])
        shape, middle = CylinderShape(radius, high_z - low_z), np.array([x, y, 0.5 * (low_z + high_z)])
    else:
        corner = stock.solid.tree.corner.reshape(-1, 3)
        vertices, inverse = np.unique(corner, axis=0, return_inverse=True)
        shape = MeshShape(vertices, inverse.reshape(-1, 3).astype(np.int64))
    return Body(role, WORKOBJECT, shape, Frame(np.eye(3), middle), role=role)
