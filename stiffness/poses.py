"""Poses: where N frames stand in the base, as signatures take them and as results give them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class Poses(Protocol):
    """Anything with the rotations (N, 3, 3) and origins (N, 3) m of N frames: other packages bring their own."""

    @property
    def rotation(self) -> Floats: ...

    @property
    def origin(self) -> Floats: ...

    @property
    def count(self) -> int: ...

    def take(self, rows: slice | npt.NDArray[np.intp], /) -> Poses: ...


@dataclass(frozen=True, repr=False, eq=False)
class PoseArray:
    """``rotation`` (N, 3, 3) and ``origin`` (N, 3) m of N frames."""

    rotation: Floats
    origin: Floats

    def __len__(self) -> int:
        return len(self.origin)

    @property
    def count(self) -> int:
        """N."""
        return len(self.origin)

    def __repr__(self) -> str:
        return f"PoseArray({len(self)})"

    def take(self, rows: npt.NDArray[np.intp] | slice) -> PoseArray:
        """Some of them."""
        return PoseArray(self.rotation[rows], self.origin[rows])
