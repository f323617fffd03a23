"""Centre and sweep of a G2 or G3 block, with the checks of LinuxCNC.

Rules and tolerances: LinuxCNC G-code reference, section G2, G3 Arc Move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from toolpaths.reading.plane_arc import RadiusTolerance, centre_of_radius, in_plane, radii, sweep_about

TOLERANCE = RadiusTolerance(5e-6, 1e-3, 0.5e-3)
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
    if any(letter in words for letter in OFFSETS):
        center = _from_offsets(words, start, normal)
        TOLERANCE.check(*radii(start, end, center, normal))
    elif "R" in words:
        least = TOLERANCE.least
        center = centre_of_radius(words["R"], start, end, normal, clockwise=clockwise, tolerance=least)
    else:
        raise ValueError("an arc without centre (I, J, K) and without radius R")
    return in_plane(start, center, normal), sweep_about(center, start, end, normal, clockwise=clockwise)


def _from_offsets(words: Mapping[str, float], start: Sequence[float], normal: int) -> tuple[float, float]:
    if "R" in words:
        raise ValueError("an arc with both R and I, J, K")
    if OFFSETS[normal] in words:
        plane = ("G19 (YZ)", "G18 (ZX)", "G17 (XY)")[normal]
        raise ValueError(f"{OFFSETS[normal]} is no centre word of the plane {plane}")
    first, second = (normal + 1) % 3, (normal + 2) % 3
    return start[first] + words.get(OFFSETS[first], 0.0), start[second] + words.get(OFFSETS[second], 0.0)
