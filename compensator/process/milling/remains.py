"""Remains: what is left of the stock: its mesh, the volume that is gone, and how it compares with the finished part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.field import CELL, Field
from compensator.process.milling.kernels.survey import depths, on_grid, removed_volume, writers_at
from compensator.process.milling.stock import Stock
from compensator.process.milling.surface import nodes_around, surface

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Remains:
    """A stock after its moves.

    Attributes:
        field: from ``mill``.
        stock: as it was before.
        pose_of: (M,) the pose at which each row of moves ends.
    """

    field: Field
    stock: Stock
    pose_of: npt.NDArray[np.int64]

    def __repr__(self) -> str:
        return f"Remains({self.stock!r} after {len(self.pose_of)} moves)"

    def depth(self, points: Floats) -> Floats:
        """Signed distance (P,) of points (P, 3) to what is left, m, negative inside: exact within two cells of it."""
        out = np.empty(len(points))
        depths(self.field, np.ascontiguousarray(points), 2.0 * float(self.field.frame[CELL]), out)
        return out

    @property
    def removed(self) -> float:
        """Volume that is gone, m3."""
        return float(removed_volume(self.field))

    def mesh(self, cell: float | None = None) -> tuple[Floats, npt.NDArray[np.int64]]:
        """Vertices (V, 3) m and faces (F, 3) of what is left, closed, outward; by marching cubes.

        Args:
            cell: m between nodes; default that of the field, or more where that makes too many.
        """
        step = float(self.field.frame[CELL]) if cell is None else cell
        nodes = nodes_around(self.stock.box, step)
        values = np.empty(nodes.count, dtype=np.float32)
        on_grid(self.field, nodes.start, nodes.step, values)
        return surface(values, nodes)

    def writers(self, points: Floats) -> npt.NDArray[np.int64]:
        """The pose (P,) whose move cut deepest near points (P, 3); -1 where none did."""
        out = np.empty(len(points), dtype=np.int32)
        writers_at(self.field, np.ascontiguousarray(points), out)
        return np.where(out >= 0, self.pose_of[out], -1)
