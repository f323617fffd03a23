"""Spacing check: where the force changes from one pose to the next, too far apart for a correction between them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from compensator.path.pose_text import place
from compensator.process.milling.mill import Cut
from toolpaths.finding import NOTE, Finding
from toolpaths.toolpath import Toolpath

JUMP = 0.3  # of the largest mean force
APART = 0.25  # radii of the cutter: over less of the way a force hardly changes


def spacing_findings(cut: Cut, toolpath: Toolpath, source: str) -> Iterator[Finding]:
    """A note about entries, exits and steps of the material between poses that stand wide apart.

    Args:
        source: the cell, for messages.
    """
    force, way = cut.force, cut.path.length
    change = np.abs(np.diff(force, prepend=force[:1]))
    near = APART * np.array([c.radius for c in cut.path.cutters])[cut.path.cutter]
    wide = ~cut.path.rapid & (change > JUMP * force.max(initial=0.0)) & (way > near)
    if not wide.any():
        return
    worst = int(np.argmax(np.where(wide, change, 0.0)))
    what = (
        f"the cutter enters or leaves material between poses up to {way[wide].max() * 1e3:.3g} mm apart, at "
        f"{int(wide.sum()):,} places; the force changes there by up to {change[worst]:.0f} N: between them it is taken "
        "to change evenly"
    )
    remedy = f"[sampling] spacing = {near[wide].min() * 1e3:.2g} in {source} follows it"
    yield Finding(NOTE, place(toolpath, worst), what, remedy)
