"""Sweep: the exact signed distance of a point to everything that a cutter passes during one straight move.

A move is a row of numbers: the tip goes straight, the tool axis stands still or turns a little. With an axis that
stands still the swept body is convex, and so is the distance along the move: across the axis, along it, and for a ball
the nearest place is known; only what is left is searched for, by the sign of the derivative.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.profile import BALL, LENGTH, RC, profile_distance

Floats = npt.NDArray[np.float64]
Point = tuple[float, float, float]

START, WAY, AXIS, LAST, RISE, ACROSS, TURN, REACH, RADIUS, RUN, BEGIN, END, CUTTER = (
    8, 11, 14, 17, 20, 21, 22, 23, 24, 25, 26, 27, 28,
)  # fmt: skip
MOVE_COLUMNS = 29
"""Columns of moves after those of the profile, m: tip at the start, way of the tip, axis at the start and at the end
(three each); rise of the tip along the axis; square of its way across; angle that the axis turns by, rad; radius of a
ball about the tip that holds the cutter; largest radius; number of the smooth pass; where the move begins and ends
along the path; number of the cutter."""

_CLOSE = 1e-8  # m along the move: the search ends
_STEPS = 40
_LEVEL = 1e-18  # share, squared: less is no part of the way


class Sight(NamedTuple):
    """A point as a cutter sees it whose axis stands still.

    Attributes:
        s: m above the tip at the start.
        square: m2, distance from the axis there, squared.
        toward: m2, that distance times the way across the axis.
        rise, across: m, m2, of the way.
    """

    s: float
    square: float
    toward: float
    rise: float
    across: float


@compiled
def sweep_distance(m: Floats, i: int, point: Point, end: float) -> tuple[float, float]:
    """Signed distance (m, negative inside) to the sweep up to the share ``end`` of the move.

    Outside it is the distance, inside the depth in the cutter at the place of the move where that is largest.

    Args:
        m, i: (M, 29) moves; which of them.

    Returns:
        (distance, share of the move where the cutter is nearest).
    """
    if m[i, TURN] > 0.0:
        return _turning(m, i, point, end)
    v = sight(m, i, point)
    if v.rise * v.rise <= _LEVEL * v.across:
        t = min(max(v.toward / v.across, 0.0), end)
        return profile_distance(m, i, _rho(v, t), v.s, longer=0.0).d, t
    low = v.s - min(v.rise, 0.0) * end
    if v.across <= _LEVEL * v.rise * v.rise:
        return profile_distance(m, i, sqrt(v.square), low, longer=abs(v.rise) * end).d, min(max(v.s / v.rise, 0.0), end)
    if m[i, BALL] > 0.0 and low <= m[i, LENGTH]:
        d, t = _ball(m, i, v, end)
        return max(d, low - m[i, LENGTH]), t
    return _searched(m, i, v, end)


@compiled
def sight(m: Floats, i: int, point: Point) -> Sight:
    """A point as seen from the start of a move whose axis stands still."""
    dx, dy, dz = point[0] - m[i, START], point[1] - m[i, START + 1], point[2] - m[i, START + 2]
    s = dx * m[i, AXIS] + dy * m[i, AXIS + 1] + dz * m[i, AXIS + 2]
    square = max(dx * dx + dy * dy + dz * dz - s * s, 0.0)
    toward = dx * m[i, WAY] + dy * m[i, WAY + 1] + dz * m[i, WAY + 2] - s * m[i, RISE]
    return Sight(s, square, toward, rise=m[i, RISE], across=m[i, ACROSS])


@compiled
def _rho(v: Sight, t: float) -> float:
    """Distance from the axis at a share of the move, m."""
    return sqrt(max(v.square - 2.0 * t * v.toward + t * t * v.across, 0.0))


@compiled
def _ball(m: Floats, i: int, v: Sight, end: float) -> tuple[float, float]:
    """A ball on a cylinder: the distance to the parallelogram of its centre line, less the radius."""
    t = min(max(v.toward / v.across, 0.0), end)
    up = v.s - t * v.rise - m[i, RC]
    if up < 0.0:  # below the centre line: nearest to the way of the centre itself
        t = min(max((v.toward + (v.s - m[i, RC]) * v.rise) / (v.across + v.rise * v.rise), 0.0), end)
        up = v.s - t * v.rise - m[i, RC]
    else:
        up = 0.0
    rho = _rho(v, t)
    return sqrt(rho * rho + up * up) - m[i, RC], t


@compiled
def _slope(m: Floats, i: int, v: Sight, t: float) -> tuple[float, float]:
    """Distance at a share of the move, and its derivative by the share."""
    rho = _rho(v, t)
    near = profile_distance(m, i, rho, v.s - t * v.rise, longer=0.0)
    outward = near.nr * (t * v.across - v.toward) / rho if rho > 1e-12 else 0.0
    return near.d, outward - near.ns * v.rise


@compiled
def _searched(m: Floats, i: int, v: Sight, end: float) -> tuple[float, float]:
    """The least of a convex function, by the sign of its derivative."""
    low, high = 0.0, end
    d, g_low = _slope(m, i, v, low)
    if g_low >= 0.0:
        return d, low
    d, g_high = _slope(m, i, v, high)
    if g_high <= 0.0:
        return d, high
    close, t = _CLOSE / sqrt(v.across + v.rise * v.rise), high
    for step in range(_STEPS):
        t = _between(low, high, g_low / (g_low - g_high), step)
        d, g = _slope(m, i, v, t)
        if g < 0.0:
            low, g_low = t, g
        else:
            high, g_high = t, g
        if high - low < close or g == 0.0:
            break
    return d, t


@compiled
def _between(low: float, high: float, share: float, step: int) -> float:
    """False position, halved every third time: at a kink of the outline one end would stay where it is."""
    if step % 3 == 2:
        share = 0.5
    return low + (high - low) * min(max(share, 0.02), 0.98)


@compiled
def _turning_slope(m: Floats, i: int, point: Point, t: float) -> tuple[float, float]:
    """Distance at a share of a move with a turning axis, and its derivative by the share."""
    qx = point[0] - m[i, START] - t * m[i, WAY]
    qy = point[1] - m[i, START + 1] - t * m[i, WAY + 1]
    qz = point[2] - m[i, START + 2] - t * m[i, WAY + 2]
    bx, by, bz = m[i, LAST] - m[i, AXIS], m[i, LAST + 1] - m[i, AXIS + 1], m[i, LAST + 2] - m[i, AXIS + 2]
    ax, ay, az = m[i, AXIS] + t * bx, m[i, AXIS + 1] + t * by, m[i, AXIS + 2] + t * bz
    size = 1.0 / sqrt(ax * ax + ay * ay + az * az)
    ax, ay, az = ax * size, ay * size, az * size
    s = qx * ax + qy * ay + qz * az
    rho = sqrt(max(qx * qx + qy * qy + qz * qz - s * s, 0.0))
    near = profile_distance(m, i, rho, s, longer=0.0)
    ab = ax * bx + ay * by + az * bz
    rate = size * (qx * (bx - ax * ab) + qy * (by - ay * ab) + qz * (bz - az * ab))
    rate -= m[i, WAY] * ax + m[i, WAY + 1] * ay + m[i, WAY + 2] * az
    outward = -(qx * m[i, WAY] + qy * m[i, WAY + 1] + qz * m[i, WAY + 2]) - s * rate
    return near.d, (near.nr * outward / rho if rho > 1e-12 else 0.0) + near.ns * rate


@compiled
def _turning(m: Floats, i: int, point: Point, end: float) -> tuple[float, float]:
    """As ``_searched``; a turn of a few degrees leaves one least value."""
    low, high = 0.0, end
    d, g_low = _turning_slope(m, i, point, low)
    d_high, g_high = _turning_slope(m, i, point, high)
    if g_low >= 0.0 or g_high <= 0.0:
        return (d, low) if d <= d_high else (d_high, high)
    close, t = _CLOSE / (sqrt(m[i, ACROSS] + m[i, RISE] * m[i, RISE]) + m[i, TURN] * m[i, REACH]), high
    for step in range(_STEPS):
        t = _between(low, high, g_low / (g_low - g_high), step)
        d, g = _turning_slope(m, i, point, t)
        if g < 0.0:
            low, g_low = t, g
        else:
            high, g_high = t, g
        if high - low < close or g == 0.0:
            break
    return d, t


@compiled
def least_possible(m: Floats, i: int, point: Point) -> float:
    """Never above ``sweep_distance`` of the whole move, and cheap: what tells that a point is out of reach."""
    if m[i, TURN] > 0.0:
        d, _ = _turning_slope(m, i, point, 0.5)
        hx = point[0] - m[i, START] - 0.5 * m[i, WAY]
        hy = point[1] - m[i, START + 1] - 0.5 * m[i, WAY + 1]
        hz = point[2] - m[i, START + 2] - 0.5 * m[i, WAY + 2]
        half = 0.5 * sqrt(m[i, ACROSS] + m[i, RISE] * m[i, RISE])
        return d - half - 0.5 * m[i, TURN] * (sqrt(hx * hx + hy * hy + hz * hz) + half)
    v = sight(m, i, point)
    t = min(max(v.toward / v.across, 0.0), 1.0) if v.across > 0.0 else 0.0
    return profile_distance(m, i, _rho(v, t), v.s - min(v.rise, 0.0), longer=abs(v.rise)).d


@compiled
def span(m: Floats, i: int, a: int, edge: float) -> tuple[float, float]:
    """Least and largest coordinate ``a`` of what is within ``edge`` of the sweep of a move, m; rather too far."""
    length, radius = m[i, LENGTH], m[i, RADIUS]
    low, high = np.inf, -np.inf
    for way, axis in ((0.0, m[i, AXIS + a]), (1.0, m[i, LAST + a])):
        tip = m[i, START + a] + way * m[i, WAY + a]
        wide = radius * sqrt(max(1.0 - axis * axis, 0.0))
        low = min(low, tip + min(length * axis, 0.0) - wide)
        high = max(high, tip + max(length * axis, 0.0) + wide)
    edge += 0.125 * m[i, TURN] * m[i, TURN] * (length + radius)
    return low - edge, high + edge
