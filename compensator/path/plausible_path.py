"""Toolpaths beyond the usual range: metres for mm, m/s or mm/s for mm/min."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolpaths.finding import WARNING, Finding
from toolpaths.toolpath import CUT, Toolpath

EXTENT = 5e-3  # m: a robot is not set up to cut less
FEED = (5.0, 60e3)  # mm/min; reaming takes tens, routing of wood 20,000, trimming by laser and water jet up to 60,000


def path_doubts(path: Toolpath) -> Iterator[Finding]:
    """What is unusual about the numbers of a toolpath."""
    cut = path.kind == CUT
    position = path.position[cut]
    position = position[np.isfinite(position).all(axis=1)]
    extent = float(np.linalg.norm(np.ptp(position, axis=0))) if len(position) else 0.0
    if 0 < extent < EXTENT:
        what = f"all cutting poses lie within {extent * 1e3:.3g} mm (usual is more than {EXTENT * 1e3:g} mm)"
        yield Finding(WARNING, path.source, what, f"{_unit_of(path)}: were these metres or inches?")
    feed = path.feed[cut] * 60e3
    feed = feed[np.isfinite(feed)]
    usual = float(np.median(feed)) if len(feed) else FEED[0]
    low, high = FEED
    if not low <= usual <= high:
        what = f"the median feed of the cuts is {usual:.3g} mm/min (usual are {low:g} to {high:,.0f} mm/min)"
        yield Finding(WARNING, path.source, what, "Feeds are in mm/min: were these m/s, m/min or inches?")


def _unit_of(path: Toolpath) -> str:
    return "Columns are in mm" if path.language == "csv" else "Lengths are in the unit that the file names"
