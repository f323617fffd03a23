"""Moments: the stations of a scene, and the poses at which what changes along the path has to be right."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Index = npt.NDArray[np.intp]


@dataclass(frozen=True, repr=False, eq=False)
class Moments:
    """Stations of a scene, and the poses at which what it shows has to be exact.

    Attributes:
        rows: (S,) ascending, the pose of every station.
        wanted: poses that a reader is led to, the most important first.
    """

    rows: Index
    wanted: tuple[int, ...] = ()

    def __repr__(self) -> str:
        return f"Moments({len(self.rows)} stations)"
