"""Milling load: the wrench of a cut with what it was computed from, and the figures of a whole path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from compensator.process.milling.material import NAMES, SI, Material
from compensator.process.process import ProcessLoad
from toolpaths.spilled_rows import SpilledRows

if TYPE_CHECKING:
    from compensator.process.milling.mill import Cut

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class CoefficientShares:
    """What each coefficient has of the wrench at some poses.

    Attributes:
        rows: (K,) poses, ascending; None: all.
        values: (K, 6, 6) wrench on the robot per coefficient (SI, order of NAMES), base axes, about the TCP.
    """

    rows: Rows | None
    values: Floats | SpilledRows

    def at(self, poses: Rows) -> Floats:
        """(P, 6, 6) at poses (P,); KeyError: it does not have one of them."""
        if self.rows is None:
            return self.values[poses]
        if not np.isin(poses, self.rows).all():
            raise KeyError(f"shares are kept at {len(self.rows)} poses, and not at all of those asked for")
        return self.values[np.searchsorted(self.rows, poses)]

    def only(self, poses: Rows) -> CoefficientShares:
        """At some poses (P,) alone."""
        rows = np.unique(poses)
        return CoefficientShares(rows, self.at(rows))


@dataclass(frozen=True, repr=False)
class MilledForce(ProcessLoad):
    """What is known of the force of a cut.

    Attributes:
        material: as used; key: how it was named. cell: m, spacing of the grid.
        shares: of the coefficients; None where they have no standard deviations, or nobody asks.
    """

    material: Material = field(kw_only=True)
    key: str = field(kw_only=True)
    cell: float = field(kw_only=True)
    shares: CoefficientShares | None = field(kw_only=True)

    def __repr__(self) -> str:
        return f"MilledForce({len(self.wrench)} poses, {self.material!r})"

    def predicted(self, rows: Rows) -> MilledForce:
        shares = None if self.shares is None else self.shares.only(rows)
        return MilledForce(
            self.wrench, self.findings, programmed=self.programmed, material=self.material, key=self.key,
            cell=self.cell, shares=shares,
        )  # fmt: skip


@dataclass(frozen=True, repr=False)
class MillingLoad(MilledForce):
    """The load of a milled path, with its ``cut``: engagement, pose by pose, and the stock that remains."""

    cut: Cut = field(kw_only=True)

    def solved(self) -> MillingLoad:
        return replace(self, shares=None)

    def __repr__(self) -> str:
        return f"MillingLoad({self.cut!r}, {self.material!r})"

    @property
    def size(self) -> Floats:
        """(N,) N, norm of the mean force."""
        return np.asarray(np.linalg.norm(self.wrench[:, :3], axis=1))

    @property
    def air_share(self) -> float:
        """Share of the feed length on which nothing is engaged."""
        length = np.where(self.cut.path.rapid, 0.0, self.cut.path.length)
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


@dataclass(frozen=True, eq=False)
class CutColumns(Mapping[str, Floats]):
    """Columns (N,) of a cut for tables of the poses, made where they are asked for; ``stopped`` (N,) spindles cut none.
    """

    cut: Cut
    stopped: npt.NDArray[np.bool_]

    def __getitem__(self, name: str) -> Floats:
        return self.at(name, np.arange(len(self.cut)))

    def at(self, name: str, rows: Rows) -> Floats:
        """(K,) of a column, at poses."""
        cut = self.cut
        match name:
            case "ap_mm":
                return cut.ap[rows] * 1e3
            case "entry_deg":
                return np.degrees(cut.entry[rows])
            case "exit_deg":
                return np.degrees(cut.exit[rows])
            case "engaged_mm2":
                return cut.area[rows] * 1e6
            case "mrr_mm3_min":
                return cut.removal_rate_at(rows) * 60e9
            case "feed_per_tooth_mm":
                return np.where(self.stopped[rows], 0.0, cut.path.feed_per_tooth_at(rows)) * 1e3
            case "peak_n":
                return cut.peak[rows]
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(COLUMNS)

    def __len__(self) -> int:
        return len(COLUMNS)


COLUMNS = ("ap_mm", "entry_deg", "exit_deg", "engaged_mm2", "mrr_mm3_min", "feed_per_tooth_mm", "peak_n")
