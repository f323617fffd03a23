"""Profile of a cutter: the outline that turns about the tool axis, and the exact signed distance to the body.

All cutters are one convex outline in (rho, s), rho from the axis and s up the tool from the tip: a flat bottom, an arc,
a line at the half angle to the axis, and straight up from where the body has its diameter, to the length of the edge.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.compiled import compiled

Floats = npt.NDArray[np.float64]

# columns of profiles, lengths in m
E, RC, SIN, COS, LENGTH, BODY, SHOULDER, BALL = range(8)
PROFILE_COLUMNS = 8
"""E: rho of the arc's centre (flat bottom up to there); RC: radius of the arc; SIN, COS: of the half angle; LENGTH: of
the edge; BODY: the largest radius, SHOULDER: the height where it is reached; BALL: 1 where the arc is a hemisphere on a
cylinder."""


class Nearest(NamedTuple):
    """Signed distance (m, negative inside) and the outward normal of the nearest place, along rho and s."""

    d: float
    nr: float
    ns: float


@compiled
def profile_distance(t: Floats, row: int, rho: float, s: float, longer: float) -> Nearest:
    """Signed distance of a point to the body.

    Args:
        t, row: (.., 8 and more) profiles, or moves, which begin with the profile of their cutter; which of them.
        rho, s: m, the point.
        longer: m that the body is longer than its edge (a plunge).
    """
    x, y = rho - t[row, E], s - t[row, RC]
    if x >= 0.0 and x * t[row, SIN] + y * t[row, COS] <= 0.0:  # from the arc's centre, straight down up to the line
        size = sqrt(x * x + y * y)
        near = Nearest(-t[row, RC], t[row, COS], -t[row, SIN])
        if size > 0.0:
            near = Nearest(size - t[row, RC], x / size, y / size)
    else:
        side = x * t[row, COS] - y * t[row, SIN] - t[row, RC]
        near = Nearest(side, t[row, COS], -t[row, SIN]) if side > -s else Nearest(-s, 0.0, -1.0)
    if rho - t[row, BODY] > near.d or (near.d > 0.0 and rho > t[row, BODY]):
        near = _shoulder(t, row, rho, s, near=near)
    top = s - t[row, LENGTH] - longer
    if top <= 0.0 and top <= near.d:
        return near
    x = rho - t[row, BODY]
    if x > 0.0:
        size = sqrt(x * x + top * top)
        return Nearest(size, x / size, top / size)
    return Nearest(top, 0.0, 1.0) if top > near.d else near


@compiled
def _shoulder(t: Floats, row: int, rho: float, s: float, near: Nearest) -> Nearest:
    """Above the half angle: straight up, and the corner where that begins."""
    x, y = rho - t[row, BODY], s - t[row, SHOULDER]
    if y < 0.0 and x * t[row, SIN] + y * t[row, COS] > 0.0:
        size = sqrt(x * x + y * y)
        return Nearest(size, x / size, y / size)
    return Nearest(x, 1.0, 0.0) if y >= 0.0 and x > near.d else near
