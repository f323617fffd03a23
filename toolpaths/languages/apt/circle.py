"""CIRCLE of APT/CL and NX CLSF: an arc that ends at the next GOTO; the sweep of any arc between two places.

Turning direction: counterclockwise about i, j, k as in ISO 4343; in the 11 numbers of NX clockwise. Both follow
from real files: drawn the other way, the path turns back on itself at most arcs. TIMES,n of NX is n - 1 whole turns
and the rest: so six helices of a real file end where their next move begins.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpaths.frame import Frame, Vector
from toolpaths.languages.apt.frames import point, vector
from toolpaths.languages.apt.words import UNIT_TOLERANCE, AptStatement, number, numbers, refusal
from toolpaths.reading.arc_points import FULL_CIRCLE

ENDS = 2e-3, 1e-3  # file units, share of the radius: by how much an end may miss the circle
MOST_TURNS = 100.0
TURN_SHARE = 1e-3  # of a turn, by which TIMES may miss the end


class AptCircle(NamedTuple):
    """The values of CIRCLE, in the file's frame and length unit."""

    center: Vector
    axis: Vector
    radius: float | None
    clockwise: bool
    turns: float | None = None
    angle: float | None = None  # rad, where the file gives it: then it tells the sense as well


def circle(s: AptStatement, source: str) -> AptCircle:
    """Read CIRCLE with 6 (centre, axis), 7 (radius) or 11 numbers (NX: tool and tolerances), and TIMES,n.

    Raises:
        ReadError: another form.
    """
    minor, turns = s.minor, None
    if len(minor) > 2 and minor[-2] == "TIMES":
        turns, minor = number(minor[-1]), minor[:-2]
        if turns is None or not 0.0 < turns <= MOST_TURNS:
            raise refusal(source, s, f"TIMES with a number above 0 and up to {MOST_TURNS:g} is expected")
    if len(minor) not in (6, 7, 11):
        problem = f"{len(minor)} values; read are x,y,z,i,j,k with or without r, and the 11 of NX"
        raise refusal(source, s, problem, "Output GOTO points instead of circles.")
    v = numbers(AptStatement(s.word, ",".join(minor), s.line), (6, 7, 11), source)
    radius = v[6] if len(v) > 6 else None
    return AptCircle(
        center=(v[0], v[1], v[2]), axis=(v[3], v[4], v[5]), radius=radius, clockwise=len(v) == 11, turns=turns
    )


def sweep(
    s: AptStatement, arc: AptCircle, start: Vector, end: Vector, frame: Frame | None, source: str
) -> tuple[Vector, Vector, float]:
    """Centre, unit normal and sweep (rad, right-handed about the normal) of an arc between two points.

    Raises:
        ReadError: the ends do not lie on the circle, or TIMES does not fit them.
    """
    center, axis = point(frame, arc.center), vector(frame, arc.axis)
    norm = math.hypot(*axis)
    if not abs(norm - 1.0) <= UNIT_TOLERANCE:
        raise refusal(source, s, f"the axis of the circle has length {norm:.6g}, 1 expected")
    n = (axis[0] / norm, axis[1] / norm, axis[2] / norm)
    u, v = _beside(start, center, n), _beside(end, center, n)
    _check_radius(s, arc, (math.hypot(*u), math.hypot(*v)), source)
    return center, n, _angle(s, arc=arc, u=u, v=v, n=n, source=source)


# Plain numbers: there is one circle a move in some files, and arrays of three take twenty times as long.


def _beside(p: Vector, center: Vector, n: Vector) -> Vector:
    """From the axis of the circle to a place, at right angles."""
    x, y, z = p[0] - center[0], p[1] - center[1], p[2] - center[2]
    rise = x * n[0] + y * n[1] + z * n[2]
    return x - rise * n[0], y - rise * n[1], z - rise * n[2]


def _angle(s: AptStatement, arc: AptCircle, u: Vector, v: Vector, n: Vector, source: str) -> float:
    """How far the arc turns from u to v, rad, right-handed about n; more than one turn with TIMES or ANGLE."""
    (a, b, c), (x, y, z) = u, v
    across = (b * z - c * y) * n[0] + (c * x - a * z) * n[1] + (a * y - b * x) * n[2]
    left = math.atan2(across, a * x + b * y + c * z)
    if arc.angle is not None:
        return _given(s, arc.angle, left, source)
    angle = _whole(-left if arc.clockwise else left)
    if arc.turns is not None:
        angle += math.tau * _more_turns(s, arc.turns, angle, source)
    return -angle if arc.clockwise else angle


def _whole(angle: float) -> float:
    """Above 0, up to a turn."""
    angle %= math.tau
    return angle if angle >= FULL_CIRCLE else angle + math.tau


def _more_turns(s: AptStatement, turns: float, angle: float, source: str) -> int:
    """Whole turns of TIMES before the rest: one less than a whole number of times (NX), or as many as fit the end."""
    if turns == round(turns):
        return round(turns) - 1
    more = turns - angle / math.tau
    if abs(more - round(more)) > TURN_SHARE or round(more) < 0:
        problem = f"TIMES,{turns:g}, but the end lies {angle / math.tau:.4g} of a turn behind the start"
        raise refusal(source, s, problem, "Output one CIRCLE a turn, or GOTO points.")
    return round(more)


def _given(s: AptStatement, angle: float, left: float, source: str) -> float:
    """The sweep of an arc with an angle of its own: the way round that fits the end, counterclockwise if both do."""
    for way in (1.0, -1.0):
        sweep = _whole(way * left)
        sweep += math.tau * max(round((angle - sweep) / math.tau), 0)
        if abs(sweep - angle) <= TURN_SHARE * math.tau:
            return way * sweep
    ends = [math.degrees(_whole(way * left)) for way in (1.0, -1.0)]
    problem = f"ANGLE,{math.degrees(angle):.6g}, but the end lies {ends[0]:.6g} or {ends[1]:.6g} degrees on"
    raise refusal(source, s, problem, "Output GOTO points.")


def _check_radius(s: AptStatement, arc: AptCircle, found: tuple[float, float], source: str) -> None:
    radius = found[0] if arc.radius is None else arc.radius
    most = max(ENDS[0], ENDS[1] * abs(radius))
    if not radius > 0 or any(abs(r - radius) > most for r in found):
        given = "" if arc.radius is None else f"radius {radius:g}, but "
        problem = f"{given}the ends lie {found[0]:.6g} and {found[1]:.6g} from its centre"
        raise refusal(source, s, problem, "Output GOTO points.")
