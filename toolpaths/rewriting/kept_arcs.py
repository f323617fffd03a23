"""Corrected arcs of programs whose filter changes whole moves: whether one stays an arc, and through which point."""

from __future__ import annotations

import numpy as np

from toolpaths.rewriting.arc_fit import Arcs
from toolpaths.rewriting.corrections import Correction
from toolpaths.writing.program import Floats

_EVEN = 1e-6


def via_point(c: Correction, arcs: Arcs, row: Floats) -> Floats | None:
    """The point (3,) m, in the move's frame, that a corrected arc has to pass; None where it can be no arc.

    Args:
        row: of the poses of the program. Poses put in besides those that stand for the roundness (these are evenly
            spaced) are there because something changes at them.
    """
    poses = np.array([c.poses[0] - 1, *c.poses])
    if len(c.poses) < 2 or poses[0] < 0 or abs(row[poses[0]] - (c.move - 1)) > _EVEN:
        return None
    share = row[poses] - row[poses[0]]
    if np.abs(share - np.linspace(0.0, 1.0, len(poses))).max() > _EVEN:
        return None
    found = arcs.via(c.move, poses)
    return None if found is None else found[0]
