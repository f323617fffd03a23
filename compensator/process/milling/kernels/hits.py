"""Hits: parts of a tool that do not cut in the material: above the edge, shank, holder, and anything during a rapid."""

from __future__ import annotations

from math import ceil, pi, sqrt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.contact import NONE, depth_at
from compensator.process.milling.kernels.field import CELL, Field
from compensator.process.milling.kernels.lattice import (
    Envelope,
    Floats,
    Stand,
    angle_limit,
    place_at,
)
from compensator.process.milling.kernels.profile import BODY, LENGTH
from compensator.process.milling.kernels.stock_distance import AROUND
from compensator.process.milling.kernels.sweep import Point

RAPID_HIT, ABOVE_EDGE, SHANK_HIT, HOLDER_HIT, SIDEWAYS = 1, 2, 4, 8, 16
"""Bits: a rapid through material; material above the cutting edge; shank, holder in it; a drill that goes sideways."""

TOUCH = 2e-5  # m: less is the rounding of a file and of its arcs
_AROUND = 36  # angles of a ring


@compiled
def _deep(f: Field, stand: Stand, point: Point) -> bool:
    """Whether a place is inside the material by more than TOUCH."""
    d = depth_at(f, stand, point, False)
    return d < 0.0 and (d < -4.0 * TOUCH or depth_at(f, stand, point, True) < NONE - TOUCH)


@compiled
def above_edge(f: Field, e: Envelope, stand: Stand, highest: float) -> int:
    """ABOVE_EDGE where the feed pushes what is above the edge into the material; ``highest`` is what is engaged."""
    row = e.first[stand.cutter + 1] - 1
    if highest < 0.5 * (e.s[row] + e.s[row - 1]):
        return 0
    limit = angle_limit(stand, 0.5 * pi)
    radius, height = e.profile[stand.cutter, BODY], e.profile[stand.cutter, LENGTH] + 2.0 * TOUCH
    for c in range(_AROUND + 1):
        angle = limit * (2.0 * c / _AROUND - 1.0)
        if _deep(f, stand, place_at(stand, radius, height, angle)):
            return ABOVE_EDGE
    return 0


@compiled
def _ring_hits(f: Field, stand: Stand, rho: float, s: float) -> bool:
    """Whether a ring of the tool is in the material."""
    box = f.solid.number
    for a in range(3):
        middle = stand.tip[a] - s * stand.z[a]
        wide = rho * sqrt(max(1.0 - stand.z[a] * stand.z[a], 0.0))
        if middle + wide < box[AROUND + a] or middle - wide > box[AROUND + a + 3]:
            return False
    found = False
    for c in range(_AROUND):
        if _deep(f, stand, place_at(stand, rho, s, 2.0 * pi * c / _AROUND)):
            found = True
            break
    return found


@compiled
def stack_hits(f: Field, stand: Stand, stack: Floats) -> int:
    """SHANK_HIT, HOLDER_HIT: cylinders above the edge in the material."""
    found = 0
    for i in range(len(stack)):
        low, high, radius, which = stack[i, 0], stack[i, 1], stack[i, 2], stack[i, 3]
        bit = SHANK_HIT if which == 1.0 else HOLDER_HIT
        if radius <= 0.0 or found & bit or not _reaches_stock(f, stand, low, high, radius=radius):
            continue
        pitch = max(f.frame[CELL], radius / 8.0)
        rings = ceil((high - low) / pitch)
        for k in range(rings + 1):
            if _ring_hits(f, stand, radius, low + (high - low) * k / rings):
                found |= bit
                break
        rings = ceil(radius / pitch)
        for k in range(rings):
            if found & bit == 0 and _ring_hits(f, stand, radius * k / rings, low):
                found |= bit
    return found


@compiled
def _reaches_stock(f: Field, stand: Stand, low: float, high: float, radius: float) -> bool:
    """Whether the box around a cylinder of the tool meets the box around the stock."""
    box = f.solid.number
    for a in range(3):
        first, second = stand.tip[a] - low * stand.z[a], stand.tip[a] - high * stand.z[a]
        wide = radius * sqrt(max(1.0 - stand.z[a] * stand.z[a], 0.0))
        if max(first, second) + wide < box[AROUND + a] or min(first, second) - wide > box[AROUND + a + 3]:
            return False
    return True


@compiled
def rapid_hits(f: Field, e: Envelope, stand: Stand, way: Floats, stack: Floats) -> int:
    """RAPID_HIT where any part of the tool passes material on its way to the stand; ``way`` in axes of the stand."""
    length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    parts = max(1, ceil(length / max(f.frame[CELL], 0.25 * e.profile[stand.cutter, BODY])))
    for k in range(parts + 1):
        back = k / parts - 1.0
        u, v, w = back * way[0], back * way[1], back * way[2]
        tip = (
            stand.tip[0] + u * stand.x[0] + v * stand.y[0] + w * stand.z[0],
            stand.tip[1] + u * stand.x[1] + v * stand.y[1] + w * stand.z[1],
            stand.tip[2] + u * stand.x[2] + v * stand.y[2] + w * stand.z[2],
        )
        here = Stand(
            tip, stand.x, stand.y, stand.z, fx=0.0, fz=0.0, cutter=stand.cutter, part=stand.part, share=stand.share
        )
        if not _reaches_stock(f, here, 0.0, e.profile[stand.cutter, LENGTH], radius=e.profile[stand.cutter, BODY]):
            if stack_hits(f, here, stack):
                return RAPID_HIT
            continue
        for r in range(e.first[stand.cutter], e.first[stand.cutter + 1]):
            if _ring_hits(f, here, e.rho[r], e.s[r]):
                return RAPID_HIT
        if stack_hits(f, here, stack):
            return RAPID_HIT
    return 0
