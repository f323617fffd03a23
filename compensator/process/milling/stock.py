"""Stock: what is machined, as it is before the first move; in the work object, SI."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.stock_distance import AROUND, BOX, CYLINDER, MESH, Solid, stock_distance
from compensator.process.milling.kernels.triangles import DEPTH, Tree, divided

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Stock:
    """A body with an inside.

    Attributes:
        solid: what the kernels take.
        source: in words, for messages and summaries.
    """

    solid: Solid
    source: str

    def __repr__(self) -> str:
        return f"Stock({self.source})"

    @property
    def box(self) -> Floats:
        """(2, 3) least and largest corner of what holds it, m."""
        return self.solid.number[AROUND:].reshape(2, 3)

    def distance(self, points: Floats) -> Floats:
        """Signed distance (N,) of points (N, 3), m, negative inside."""
        return np.array([stock_distance(self.solid, (x, y, z), np.inf) for x, y, z in points.tolist()])


def box_stock(low: Floats, high: Floats) -> Stock:
    """A box between two corners (3,), m."""
    size = np.concatenate([low, high]).astype(float)
    shown = " x ".join(f"{v * 1e3:g}" for v in size[3:] - size[:3])
    return Stock(Solid(np.array([BOX, *size, *size]), _no_tree()), f"box {shown} mm")


def cylinder_stock(center: Floats, radius: float, ends: tuple[float, float]) -> Stock:
    """A cylinder along z: ``center`` (2,), lower and upper end, m."""
    x, y = (float(v) for v in center)
    size = np.array([x, y, radius, *ends, 0.0])
    box = np.array([x - radius, y - radius, ends[0], x + radius, y + radius, ends[1]])
    shown = f"cylinder {2e3 * radius:g} mm, {1e3 * (ends[1] - ends[0]):g} mm long"
    return Stock(Solid(np.concatenate([[CYLINDER], size, box]), _no_tree()), shown)


def mesh_stock(corner: Floats, normal: Floats, source: str) -> Stock:
    """A closed mesh: corners (T, 3, 3) m and normals (T, 7, 3) as in kernels/triangles.py."""
    order, box, child = divided(corner)
    tree = Tree(corner[order], normal[order], box=box, child=child, stack=np.zeros(DEPTH, dtype=np.int32))
    size = np.concatenate([corner.min(axis=(0, 1)), corner.max(axis=(0, 1))])
    return Stock(Solid(np.array([MESH, *size, *size]), tree), source)


def _no_tree() -> Tree:
    none = np.zeros((0, 2), dtype=np.int32)
    return Tree(np.zeros((0, 3, 3)), np.zeros((0, 7, 3)), box=np.zeros((0, 6)), child=none, stack=none[:, 0].copy())
