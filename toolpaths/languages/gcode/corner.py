"""Corners that are rounded or broken: ,R and ,C behind a line (Fanuc: optional chamfering and corner R).

The corner needs the next block: until then the line is kept back. R is the radius of the arc, C the distance of both
ends of the chamfer from the corner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from toolpaths.frame import Vector
from toolpaths.languages.gcode.programmed_move import ProgrammedMove

_STRAIGHT = 1e-9  # rad: lines that go on like this have no corner
_FLAT = 1e-7  # m by which a line may leave the plane


@dataclass(frozen=True)
class PendingCorner:
    """A line that ends in a corner.

    Attributes:
        move: the line; the corner has its feed, too.
        radius: m of ,R; None: a chamfer.
        chamfer: m of ,C.
        normal: index of the axis normal to the plane.
    """

    move: ProgrammedMove
    radius: float | None
    chamfer: float
    normal: int


@dataclass(frozen=True)
class MadeCorner:
    """How a corner is gone: the end of the line, the end of the corner, and of an arc centre and sweep (rad)."""

    begin: Vector
    end: Vector
    center: Vector | None = None
    sweep: float = 0.0


def made(pending: PendingCorner, end: Vector) -> MadeCorner:
    """The corner between the line that was kept back and one to ``end``.

    Raises:
        ValueError: a line is too short, leaves the plane, or comes back on itself.
    """
    normal = pending.normal
    first, second = (normal + 1) % 3, (normal + 2) % 3
    start, corner = pending.move.start, pending.move.end
    if any(abs(p[normal] - corner[normal]) > _FLAT for p in (start, end)):
        raise ValueError("a corner (,R or ,C) between lines that leave the plane")
    before = corner[first] - start[first], corner[second] - start[second]
    after = end[first] - corner[first], end[second] - corner[second]
    lengths = math.hypot(*before), math.hypot(*after)
    if min(lengths) < _FLAT:
        raise ValueError("a corner (,R or ,C) at a line without length")
    u = before[0] / lengths[0], before[1] / lengths[0]
    v = after[0] / lengths[1], after[1] / lengths[1]
    turn = math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
    if abs(turn) < _STRAIGHT:
        return MadeCorner(corner, corner)
    if abs(turn) > math.pi - 1e-6:
        raise ValueError("a corner (,R or ,C) where the path comes back on itself")
    cut = pending.chamfer if pending.radius is None else pending.radius * math.tan(abs(turn) / 2)
    if cut > min(lengths) + _FLAT:
        shown = f",C{cut * 1e3:g}" if pending.radius is None else f",R{pending.radius * 1e3:g}"
        raise ValueError(f"{shown} mm needs {cut * 1e3:g} mm of both lines, one has {min(lengths) * 1e3:g} mm")
    begin = _moved(corner, -cut, u, normal)
    last = _moved(corner, cut, v, normal)
    if pending.radius is None:
        return MadeCorner(begin, last)
    side = math.copysign(pending.radius, turn)
    center = _moved(begin, side, (-u[1], u[0]), normal)
    return MadeCorner(begin, last, center, turn)


def _moved(p: Vector, by: float, way: tuple[float, float], normal: int) -> Vector:
    out = [p[0], p[1], p[2]]
    out[(normal + 1) % 3] += by * way[0]
    out[(normal + 2) % 3] += by * way[1]
    return out[0], out[1], out[2]
