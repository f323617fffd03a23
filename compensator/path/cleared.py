"""What earlier cuts have cleared, seen along the tool: a rapid that stays in there meets no material."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

AROUND = 0.010  # m around the path of a cut that are taken as cleared: no more than a cutter of 20 mm clears
CELL = 0.0025  # m
MOST_CELLS = 1500  # along a side: a larger part has larger cells
SLACK = 1e-4  # m: a rapid at the height of the cut before it runs along its floor


class ClearedGround:
    """The lowest cut so far at every place of a box, in axes whose third is the tool.

    Args:
        low, high: (3,) m, corners of the box.
    """

    def __init__(self, low: Floats, high: Floats) -> None:
        self._cell = max(CELL, float((high - low)[:2].max()) / MOST_CELLS)
        self._ring = int(np.ceil(AROUND / self._cell))
        self._origin = low[:2] - (self._ring + 1) * self._cell
        shape = self._cells(high[None, :2])[0] + self._ring + 2
        self._lowest = np.full(shape, np.inf)

    def cut(self, begin: Floats, end: Floats) -> None:
        """Cuts from ``begin`` to ``end`` (M, 3) m."""
        parts = np.ceil(np.linalg.norm(end - begin, axis=1) / self._cell).astype(np.intp) + 1
        which = np.repeat(np.arange(len(parts)), parts)
        share = (np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)) / np.maximum(parts - 1, 1)[which]
        points = begin[which] + share[:, None] * (end - begin)[which]
        i, j = np.clip(self._cells(points[:, :2]), 0, np.array(self._lowest.shape) - 1).T
        np.minimum.at(self._lowest, (i, j), points[:, 2])

    def clear(self, points: Floats) -> npt.NDArray[np.bool_]:
        """(M,) whether a cut as low as the point (M, 3) m went by within ``AROUND``."""
        step = np.arange(-self._ring, self._ring + 1)
        near = np.stack(np.meshgrid(step, step, indexing="ij"), axis=-1).reshape(-1, 2)
        near = near[np.hypot(*near.T) * self._cell <= AROUND + 0.5 * self._cell]
        at = np.clip(self._cells(points[:, :2])[:, None] + near, 0, np.array(self._lowest.shape) - 1)
        return np.asarray(self._lowest[at[..., 0], at[..., 1]].min(axis=1) <= points[:, 2] + SLACK)

    def _cells(self, xy: Floats) -> npt.NDArray[np.intp]:
        return np.floor((xy - self._origin) / self._cell).astype(np.intp)
