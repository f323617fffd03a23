"""Arcs and helices as points: the chords between them stay within a distance of the arc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.toolpath import Floats

COARSEST = np.pi / 4  # rad a chord may span however small the arc is
FULL_CIRCLE = 1e-6  # rad; an arc with a smaller sweep is the whole circle


@dataclass(frozen=True, repr=False)
class ArcPoints:
    """Points inside N arcs, one arc after the other, without their ends.

    Attributes:
        position: (M, 3) m.
        arc: (M,) index of the arc.
        fraction: (M,) share of the arc that lies behind the point, 0 < fraction < 1.
    """

    position: Floats
    arc: npt.NDArray[np.intp]
    fraction: Floats


def chord_count(radius: Floats, sweep: Floats, chord: float) -> npt.NDArray[np.intp]:
    """Chords that keep the sagitta r (1 - cos(step / 2)) within ``chord``; radius (N,) m, sweep (N,) rad."""
    ratio = np.minimum(chord / np.maximum(radius, 1e-300), 1.0)
    step = np.minimum(4.0 * np.arcsin(np.sqrt(ratio / 2.0)), COARSEST)
    return np.maximum(np.ceil(np.abs(sweep) / step - 1e-9), 1.0).astype(np.intp)


def arc_points(
    start: Floats, end: Floats, center: Floats, normal: Floats, sweep: Floats, chord: float
) -> ArcPoints:
    """Points inside arcs from ``start`` to ``end`` (N, 3), by ``sweep`` (N,) rad about ``normal`` (N, 3).

    The rise along the normal is spread evenly (helix), and so is a small difference of the radii at the ends.
    """
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    rise = np.einsum("ij,ij->i", end - start, normal)
    out = start - center
    base = center + np.einsum("ij,ij->i", out, normal)[:, None] * normal
    out = start - base
    radius = np.linalg.norm(out, axis=1)
    stretch = np.linalg.norm(end - base - rise[:, None] * normal, axis=1) / np.maximum(radius, 1e-300) - 1.0
    count = chord_count(radius * (1.0 + np.maximum(stretch, 0.0)), sweep, chord)
    arc = np.repeat(np.arange(len(start)), count - 1)
    first = np.cumsum(count - 1) - (count - 1)
    fraction = (np.arange(len(arc)) - first[arc] + 1) / count[arc]
    angle = sweep[arc] * fraction
    side = np.cross(normal, out)
    turned = np.cos(angle)[:, None] * out[arc] + np.sin(angle)[:, None] * side[arc]
    position = base[arc] + (1.0 + fraction * stretch[arc])[:, None] * turned
    position += (fraction * rise[arc])[:, None] * normal[arc]
    return ArcPoints(position, arc, fraction)
