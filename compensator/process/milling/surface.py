"""Surface: the mesh where a signed distance on the nodes of a regular grid is zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]

MOST_NODES = 20_000_000  # of the grid that a mesh is made on


@dataclass(frozen=True, repr=False)
class Nodes:
    """A regular grid: ``start`` (3,) m of its first node, ``step`` m between nodes, ``count`` (3,) of them."""

    start: Floats
    step: float
    count: npt.NDArray[np.int64]

    def __repr__(self) -> str:
        return f"Nodes({' x '.join(map(str, self.count))}, {self.step * 1e3:.3g} mm)"


def nodes_around(box: Floats, step: float) -> Nodes:
    """Nodes in a box (2, 3) m and around it, ``step`` m apart, or more where these are too many."""
    low, high = box
    step = max(step, float((np.prod(high - low) / MOST_NODES) ** (1 / 3)))
    # no node on a face of the stock: there the surface would have no side
    return Nodes(low - 1.003 * step, step, np.ceil((high - low) / step).astype(int) + 3)


def surface(values: npt.NDArray[np.float32], nodes: Nodes) -> tuple[Floats, Faces]:
    """Vertices (V, 3) m and faces (F, 3) where ``values`` m, negative inside, are zero; closed, outward.

    By marching cubes. The rim of ``values`` is overwritten: outside.
    """
    from skimage.measure import marching_cubes  # half a second, and only where a mesh is asked for

    for axis in range(3):
        rim = np.moveaxis(values, axis, 0)
        rim[[0, -1]] = np.maximum(rim[[0, -1]], nodes.step)
    if values.min() >= 0:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    vertices, faces, _, _ = marching_cubes(values, 0.0)  # type: ignore[no-untyped-call]
    return vertices * nodes.step + nodes.start, faces.astype(np.int64)
