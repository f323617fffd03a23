"""Axis ways: where external axes stand along a path, that were chosen for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.frame import Frame
from toolpaths.rotation import matrix_about

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TurningTable:
    """A table that turns along a path.

    Attributes:
        name: of the axis. direction: (3,) of length 1, center: (3,) m, both in the frame of the poses.
    """

    name: str
    direction: Floats
    center: Floats


@dataclass(frozen=True, repr=False, eq=False)
class AxisWays:
    """Places of axes at K rows of a toolpath, even between them.

    Attributes:
        row: (K,) ascending, as in Toolpath.
        places: name of the axis -> (K,) mm or deg.
        drift: (K, 3) m, how rails move the part against the poses, in the frame of the poses.
        table: that turns on the way; None: none does.
    """

    row: Floats
    places: Mapping[str, Floats]
    drift: Floats
    table: TurningTable | None = None

    def __repr__(self) -> str:
        return f"AxisWays({', '.join(self.places)})"

    def at(self, row: Floats) -> dict[str, Floats]:
        """(N,) mm or deg of each axis at rows (N,)."""
        return {name: np.interp(row, self.row, values) for name, values in self.places.items()}

    def drift_at(self, row: Floats) -> Floats:
        """(N, 3) m at rows (N,)."""
        return np.stack([np.interp(row, self.row, column) for column in self.drift.T], axis=1)

    def part_at(self, row: Floats) -> Frame | None:
        """(N) where the part is that stands on the table that turns, in the frame of the poses; None: none turns."""
        if self.table is None:
            return None
        angle = np.radians(np.interp(row, self.row, self.places[self.table.name]))
        rotation, center = matrix_about(self.table.direction, angle), self.table.center
        return Frame(rotation, center - rotation @ center + self.drift_at(row))

    def on_part(self, row: Floats, position: Floats) -> Floats:
        """Positions (N, 3) m at rows (N,), as the part sees them."""
        part = self.part_at(row)
        return position - self.drift_at(row) if part is None else part.inward(position)
