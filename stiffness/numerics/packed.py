"""Packed: a symmetric matrix by its lower triangle, row by row: half the memory, blocks of it as they are needed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


@dataclass(frozen=True, repr=False)
class Packed:
    """``triangle`` (n (n + 1) / 2,): the entries (0, 0), (1, 0), (1, 1), (2, 0), ..."""

    triangle: Floats

    @classmethod
    def of(cls, matrix: Floats) -> Packed:
        """Of a symmetric matrix (n, n)."""
        return cls(np.concatenate([row[: k + 1] for k, row in enumerate(matrix)]))

    def __repr__(self) -> str:
        return f"Packed({len(self)}, {len(self)})"

    def __len__(self) -> int:
        return int(np.sqrt(2 * len(self.triangle)))

    def __add__(self, other: Packed) -> Packed:
        return Packed(self.triangle + other.triangle)

    def whole(self) -> Floats:
        """(n, n)."""
        n = len(self)
        out = np.empty((n, n))
        ends = np.arange(n + 1) * np.arange(1, n + 2) // 2
        for k in range(n):
            row = self.triangle[ends[k] : ends[k + 1]]
            out[k, : k + 1] = row
            out[: k + 1, k] = row
        return out

    def block(self, at: Index) -> Floats:
        """(k, k) of rows and columns ``at`` (k,)."""
        row, column = np.maximum(at[:, None], at), np.minimum(at[:, None], at)
        return np.asarray(self.triangle[row * (row + 1) // 2 + column])
