"""Axis ways: where external axes stand along a path, that were chosen for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class AxisWays:
    """Places of axes at K rows of a toolpath, even between them.

    Attributes:
        row: (K,) ascending, as in Toolpath.
        places: name of the axis -> (K,) mm or deg.
        drift: (K, 3) m, how rails move the part against the poses, in the frame of the poses.
    """

    row: Floats
    places: Mapping[str, Floats]
    drift: Floats

    def __repr__(self) -> str:
        return f"AxisWays({', '.join(self.places)})"

    def at(self, row: Floats) -> dict[str, Floats]:
        """(N,) mm or deg of each axis at rows (N,)."""
        return {name: np.interp(row, self.row, values) for name, values in self.places.items()}

    def drift_at(self, row: Floats) -> Floats:
        """(N, 3) m at rows (N,)."""
        return np.stack([np.interp(row, self.row, column) for column in self.drift.T], axis=1)
