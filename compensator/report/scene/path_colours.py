"""Colours of the path: what a reader can have it coloured by, a number at every pose."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.report.scene.flanks import last_reversed
from compensator.solve.assessment import Assessment
from compensator.solve.compensation import Compensation
from compensator.solve.turnarounds import reversals
from compensator.solve.uncertainty import QUANTILE

Floats = npt.NDArray[np.float64]
MM = 1e3
VIRIDIS = ((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37))  # by its corners, 0 to 255


@dataclass(frozen=True, repr=False, eq=False)
class PathColour:
    """What the path is coloured by.

    Attributes:
        key: short name. label: with the unit, as the legend has it.
        value: (N,) at every pose; NaN: not known there.
        joints: the values are numbers of joints, 0 for none.
    """

    key: str
    label: str
    value: Floats
    joints: bool = False

    def __repr__(self) -> str:
        return f"PathColour({self.label!r}, up to {np.nanmax(self.value, initial=0.0):.3g})"


def path_colours(c: Compensation, after: Floats | None, judged: Assessment | None) -> Iterator[PathColour]:
    """What there is for this path, the deflection first.

    Args:
        after: (N,) m, what the program leaves; None: nothing is corrected.
    """
    yield PathColour("deflection", "deflection, mm", np.linalg.norm(c.error_before, axis=1) * MM)
    if after is not None:
        yield PathColour("left", "left with the program, µm", after * 1e6)
    yield PathColour("force", "force, N", np.linalg.norm(c.wrench[:, :3], axis=1))
    if "ap_mm" in c.load.columns:
        yield PathColour("depth", "axial depth of cut, mm", c.load.columns["ap_mm"])
        arc = c.load.columns["exit_deg"] - c.load.columns["entry_deg"]
        yield PathColour("engagement", "engaged arc, deg", np.maximum(arc, 0.0))
    band = None if judged is None else _band(c, judged)
    if band is not None:
        yield PathColour("band", "half of the 95 % band, mm", band * MM)
    found = reversals(c, c.command.q)
    if found:
        yield PathColour("reversals", "joint that reversed last", last_reversed(len(c), found), joints=True)


def _band(c: Compensation, judged: Assessment) -> Floats | None:
    """(N,) m: what standard deviations of material, model and angles that were not learned leave at cutting poses."""
    out = np.full(len(c), np.nan)
    cut = np.flatnonzero(c.cutting)
    sd = judged.open.sd.copy()
    if judged.band is not None:
        plain = c.uncompensated
        rows = plain.path.toolpath.row[np.flatnonzero(plain.cutting)]
        some = rows[np.unique(np.linspace(0, len(rows) - 1, len(judged.band.size) - 2).astype(int))]
        sd = np.hypot(sd, np.interp(c.path.toolpath.row[cut], some, judged.band.sd[: len(some)]))
    if not np.any(sd > 0):
        return None
    out[cut] = QUANTILE * sd
    return out
