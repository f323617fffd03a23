"""Centre and sweep of a G2 or G3 block, with the checks of LinuxCNC.

Rules and tolerances: LinuxCNC G-code reference, section G2, G3 Arc Move.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from toolpaths.reading.arc_points import FULL_CIRCLE

# the radii at both ends may differ by this much, m; and by more only below the share of the radius
RADIUS_TOLERANCE, RADIUS_SHARE, RADIUS_MOST = 5e-6, 1e-3, 0.5e-3
OFFSETS = "IJK"


def arc_geometry(
    words: Mapping[str, float], start: Sequence[float], end: Sequence[float], normal: int, *, clockwise: bool
) -> tuple[tuple[float, float, float], float]:
    """Centre (m, at the height of ``start``) and sweep (rad, right-handed about the axis ``normal``).

    Args:
        words: I, J, K (from ``start``) or R, m.
        start: and ``end``: (3,) m.
        normal: 0, 1, 2 for the planes YZ, ZX, XY.
        clockwise: seen against the axis, as G2.

    Raises:
        ValueError: the words do not make an arc; tells why.
    """
    first, second = (normal + 1) % 3, (normal + 2) % 3
    if any(letter in words for letter in OFFSETS):
        cu, cv = _from_offsets(words, start, normal)
        ends = [math.hypot(p[first] - cu, p[second] - cv) for p in (start, end)]
        _check_radii(*ends)
    elif "R" in words:
        cu, cv = _from_radius(words["R"], start=start, end=end, normal=normal, clockwise=clockwise)
    else:
        raise ValueError("an arc without centre (I, J, K) and without radius R")
    sweep = math.atan2(end[second] - cv, end[first] - cu) - math.atan2(start[second] - cv, start[first] - cu)
    sweep = (-sweep if clockwise else sweep) % math.tau
    if sweep < FULL_CIRCLE:
        sweep += math.tau
    center = [start[0], start[1], start[2]]
    center[first], center[second] = cu, cv
    return (center[0], center[1], center[2]), -sweep if clockwise else sweep


def _from_offsets(words: Mapping[str, float], start: Sequence[float], normal: int) -> tuple[float, float]:
    if "R" in words:
        raise ValueError("an arc with both R and I, J, K")
    if OFFSETS[normal] in words:
        plane = ("G19 (YZ)", "G18 (ZX)", "G17 (XY)")[normal]
        raise ValueError(f"{OFFSETS[normal]} is no centre word of the plane {plane}")
    first, second = (normal + 1) % 3, (normal + 2) % 3
    return start[first] + words.get(OFFSETS[first], 0.0), start[second] + words.get(OFFSETS[second], 0.0)


def _from_radius(
    radius: float, start: Sequence[float], end: Sequence[float], normal: int, clockwise: bool
) -> tuple[float, float]:
    """Centre of the short arc (R > 0) or the long one (R < 0)."""
    first, second = (normal + 1) % 3, (normal + 2) % 3
    du, dv = end[first] - start[first], end[second] - start[second]
    half = math.hypot(du, dv) / 2
    if half < 1e-9:
        raise ValueError("an arc with R ends where it starts: its centre is not known")
    if half > abs(radius) + RADIUS_TOLERANCE:
        raise ValueError(f"R{radius * 1e3:g} mm is too small: the ends lie {2e3 * half:g} mm apart")
    height = math.sqrt(max(radius * radius - half * half, 0.0))
    # the centre of a short counterclockwise arc lies to the left of the way
    left = height if clockwise == (radius < 0) else -height
    scale = left / (2 * half)
    return (start[first] + end[first]) / 2 - scale * dv, (start[second] + end[second]) / 2 + scale * du


def _check_radii(at_start: float, at_end: float) -> None:
    if max(at_start, at_end) < 1e-9:
        raise ValueError("an arc of radius zero")
    gap = abs(at_start - at_end)
    if gap > RADIUS_MOST or (gap > RADIUS_TOLERANCE and gap > RADIUS_SHARE * at_start):
        mm = f"{at_start * 1e3:.6g} mm at the start, {at_end * 1e3:.6g} mm at the end"
        raise ValueError(f"the radius is {mm}")
