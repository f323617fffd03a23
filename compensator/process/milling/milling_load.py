"""Milling load: the wrench of a cut with what it was computed from, and the figures of a whole path."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from compensator.process.milling.material import NAMES, SI, Material
from compensator.process.process import ProcessLoad

if TYPE_CHECKING:
    from compensator.process.milling.mill import Cut

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class MillingLoad(ProcessLoad):
    """The load of a milled path.

    Attributes:
        cut: engagement, pose by pose, and the stock that remains.
        material: as used; key: how it was named. cell: m, spacing of the grid.
        shares: (N, 6, 6) wrench on the robot per coefficient (SI, order of NAMES), base axes, about the TCP.
    """

    cut: Cut = field(kw_only=True)
    material: Material = field(kw_only=True)
    key: str = field(kw_only=True)
    cell: float = field(kw_only=True)
    shares: Floats = field(kw_only=True)

    def __repr__(self) -> str:
        return f"MillingLoad({self.cut!r}, {self.material!r})"

    @property
    def size(self) -> Floats:
        """(N,) N, norm of the mean force."""
        return np.asarray(np.linalg.norm(self.wrench[:, :3], axis=1))

    @property
    def air_share(self) -> float:
        """Share of the feed length on which nothing is engaged."""
        length = np.where(self.cut.path.rapid, 0.0, np.linalg.norm(self.cut.path.way, axis=1))
        total = float(length.sum())
        return float(length[~self.cut.engaged].sum()) / total if total else 0.0

    @property
    def removed(self) -> float:
        """m3 that the whole path takes off the stock."""
        return 0.0 if self.cut.remains is None else self.cut.remains.removed

    def summary(self) -> dict[str, Any]:
        """The figures of the path, as the JSON report has them: mm, mm3, N."""
        engaged = self.cut.engaged
        return {
            "material": self.key.removeprefix("built-in material "),
            "coefficients": {n: float(v) for n, v in zip(NAMES, self.material.coefficients / SI, strict=True)},
            "grid_mm": self.cell * 1e3,
            "removed_mm3": self.removed * 1e9,
            "peak_n": float(self.cut.peak.max(initial=0.0)),
            "mean_n": float(self.size[engaged].mean()) if engaged.any() else 0.0,
            "air_share": self.air_share,
        }

    @property
    def worst(self) -> int:
        """The pose with the largest mean force."""
        return int(np.argmax(self.size))
