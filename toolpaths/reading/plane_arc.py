"""Arcs of CNC programs in a plane: centre from a radius, sweep about a centre, and how far its ends may miss it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from toolpaths.reading.arc_points import FULL_CIRCLE

ZERO = 1e-9  # m; radii and chords below it are none
#: By the index of the axis at right angles to it.
PLANES = ("YZ", "ZX", "XY")


class RadiusTolerance(NamedTuple):
    """By how much the radii at both ends of an arc may differ, as a controller has it.

    Attributes:
        least: m that are always allowed.
        share: of the radius that is allowed beyond that.
        most: m that are never allowed.
    """

    least: float
    share: float
    most: float

    def check(self, at_start: float, at_end: float) -> None:
        """Refuse an arc.

        Raises:
            ValueError: names both radii.
        """
        if max(at_start, at_end) < ZERO:
            raise ValueError("an arc of radius zero")
        gap = abs(at_start - at_end)
        if gap > self.most or (gap > self.least and gap > self.share * at_start):
            mm = f"{at_start * 1e3:.6g} mm at the start, {at_end * 1e3:.6g} mm at the end"
            raise ValueError(f"the radius is {mm}")


def radii(
    start: Sequence[float], end: Sequence[float], center: tuple[float, float], normal: int
) -> tuple[float, float]:
    """How far both ends lie from the centre in the plane, m; ``normal``: 0, 1, 2 for the planes YZ, ZX, XY."""
    first, second = (normal + 1) % 3, (normal + 2) % 3
    u, v = center
    return math.hypot(start[first] - u, start[second] - v), math.hypot(end[first] - u, end[second] - v)


def centre_of_radius(
    radius: float, start: Sequence[float], end: Sequence[float], normal: int, *, clockwise: bool, tolerance: float
) -> tuple[float, float]:
    """Centre in the plane of the short arc (radius above 0) or of the long one.

    Args:
        radius: m.
        start: and ``end``: (3,) m.
        normal: 0, 1, 2 for the planes YZ, ZX, XY.
        clockwise: seen against the axis.
        tolerance: m by which the radius may be too small for its ends.

    Raises:
        ValueError: the ends are one point, or too far apart.
    """
    first, second = (normal + 1) % 3, (normal + 2) % 3
    du, dv = end[first] - start[first], end[second] - start[second]
    half = math.hypot(du, dv) / 2
    if half < ZERO:
        raise ValueError("an arc by its radius ends where it starts: its centre is not known")
    if half > abs(radius) + tolerance:
        raise ValueError(f"radius {radius * 1e3:g} mm is too small: the ends lie {2e3 * half:g} mm apart")
    height = math.sqrt(max(radius * radius - half * half, 0.0))
    # the centre of a short counterclockwise arc lies to the left of the way
    scale = (height if clockwise == (radius < 0) else -height) / (2 * half)
    return (start[first] + end[first]) / 2 - scale * dv, (start[second] + end[second]) / 2 + scale * du


def sweep_about(
    center: tuple[float, float], start: Sequence[float], end: Sequence[float], normal: int, *, clockwise: bool
) -> float:
    """rad from ``start`` to ``end``, right-handed about the axis ``normal``; a whole turn where they agree."""
    first, second = (normal + 1) % 3, (normal + 2) % 3
    u, v = center
    sweep = math.atan2(end[second] - v, end[first] - u) - math.atan2(start[second] - v, start[first] - u)
    sweep = (-sweep if clockwise else sweep) % math.tau
    if sweep < FULL_CIRCLE:
        sweep += math.tau
    return -sweep if clockwise else sweep


def in_plane(point: Sequence[float], center: tuple[float, float], normal: int) -> tuple[float, float, float]:
    """The centre (m) at the height of ``point``."""
    out = [point[0], point[1], point[2]]
    out[(normal + 1) % 3], out[(normal + 2) % 3] = center
    return out[0], out[1], out[2]


def tangent_arc(
    start: Sequence[float], end: Sequence[float], heading: tuple[float, float], normal: int
) -> tuple[tuple[float, float], float] | None:
    """Centre in the plane and sweep of the arc that leaves ``start`` in a direction; None: the end lies straight ahead.

    Raises:
        ValueError: the end lies straight behind the start, or is the start.
    """
    first, second = (normal + 1) % 3, (normal + 2) % 3
    u, v = end[first] - start[first], end[second] - start[second]
    ahead, left = u * heading[0] + v * heading[1], v * heading[0] - u * heading[1]
    if abs(left) <= ZERO:
        if ahead > ZERO:
            return None
        raise ValueError("a tangential arc to a point straight behind its start")
    along = (u * u + v * v) / (2.0 * left)  # of the centre, to the left
    center = start[first] - along * heading[1], start[second] + along * heading[0]
    return center, sweep_about(center, start, end, normal, clockwise=left < 0)
