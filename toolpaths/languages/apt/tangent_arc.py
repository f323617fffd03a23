"""INDIRV and TLON,GOFWD of APT/CL: the arcs of CATIA V5 and of Creo's APT_FORMAT, a whole move in one statement.

Meaning: INDIRV is the direction at the start, LINE goes from the centre to the end. Where the arc ends: CATIA
post-processors take the end of LINE; APT drives to the first meeting with the endless line, with 2,INTOF to the
second one. Read is what both agree on: up to half a turn, with 2,INTOF from half a turn up to a whole one.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from toolpaths.frame import Frame, Vector
from toolpaths.languages.apt.circle import ENDS, AptCircle, sweep
from toolpaths.languages.apt.frames import point, vector
from toolpaths.languages.apt.words import AptStatement, numbers, refusal

TANGENT = 0.1  # sine, by how much INDIRV may miss the tangent: at small radii the rounding of files is seen
MOST_SLACK = 0.1  # rad
TILT = 1e-4  # rad, by how much the rounding of the tool axis may tilt the plane
_REMEDY = "Output GOTO points."
_FORM = re.compile(
    r"\s*\(\s*CIRCLE\s*/([^()]*)\)\s*,\s*ON\s*,(\s*2\s*,\s*INTOF\s*,)?\s*\(\s*LINE\s*/([^()]*)\)\s*", re.IGNORECASE
)


class TangentArc(NamedTuple):
    """End, centre, unit normal in the first frame, and sweep (rad, right-handed about the normal)."""

    end: Vector
    center: Vector
    normal: Vector
    sweep: float


def direction(s: AptStatement, source: str) -> Vector:
    """INDIRV/dx,dy,dz as a unit vector.

    Raises:
        ReadError: other than three numbers, or no direction.
    """
    x, y, z = numbers(s, (3,), source)
    norm = math.hypot(x, y, z)
    if not norm > ENDS[1]:
        raise refusal(source, s, "a direction without length")
    return x / norm, y / norm, z / norm


def tlon(s: AptStatement, way: Vector, axis: Vector, start: Vector, frame: Frame | None, source: str) -> TangentArc:
    """The arc from ``start`` (in the first frame) that leaves along ``way`` about ``axis`` (both in the file's frame).

    Raises:
        ReadError: another form, or start, end and direction do not lie on the circle and in its plane.
    """
    form = _FORM.fullmatch(s.text)
    if form is None:
        problem = "(CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z), or ON,2,INTOF,(LINE..), is expected"
        raise refusal(source, s, problem, _REMEDY)
    cx, cy, cz, radius = numbers(AptStatement(s.word, form[1], s.line), (4,), source)
    *begin, ex, ey, ez = numbers(AptStatement(s.word, form[3], s.line), (6,), source)
    center, end = (cx, cy, cz), (ex, ey, ez)
    if math.dist(begin, center) > ENDS[0]:
        raise refusal(source, s, "the line does not begin at the centre of the circle", _REMEDY)
    center, end, way, axis = point(frame, center), point(frame, end), vector(frame, way), vector(frame, axis)
    _check_plane(s, center=center, axis=axis, ends=(start, end), source=source)
    clockwise = _clockwise(s, way=way, axis=axis, start=start, center=center, source=source)
    found = sweep(
        s,
        arc=AptCircle(center=center, axis=axis, radius=radius, clockwise=clockwise, turns=None),
        start=start,
        end=end,
        frame=None,
        source=source,
    )
    angle = _turn(s, abs(found[2]), ENDS[0] / radius, second=form[2] is not None, source=source)
    return TangentArc(end, center, found[1], math.copysign(angle, found[2]))


def _check_plane(s: AptStatement, center: Vector, axis: Vector, ends: tuple[Vector, Vector], source: str) -> None:
    for p in ends:
        height = sum((a - c) * n for a, c, n in zip(p, center, axis, strict=True))
        if abs(height) > max(ENDS[0], TILT * math.dist(p, center)):
            problem = f"an end lies {height:.6g} above its centre along the tool axis, 0 expected"
            raise refusal(source, s, problem, _REMEDY)


def _clockwise(s: AptStatement, way: Vector, axis: Vector, start: Vector, center: Vector, source: str) -> bool:
    """Whether ``way`` is the tangent at the start that turns clockwise about the axis."""
    x, y, z = (a - c for a, c in zip(start, center, strict=True))
    i, j, k = axis
    tangent = j * z - k * y, k * x - i * z, i * y - j * x
    norm = math.hypot(*tangent)
    along = sum(a * b for a, b in zip(way, tangent, strict=True)) / norm if norm > 0 else 0.0
    if abs(along) < math.sqrt(1 - TANGENT**2):
        degrees = math.degrees(math.acos(min(1.0, abs(along))))
        problem = f"INDIRV lies {degrees:.3g} degrees beside the tangent of the circle at the start"
        raise refusal(source, s, problem, _REMEDY)
    return along < 0


def _turn(s: AptStatement, angle: float, slack: float, *, second: bool, source: str) -> float:
    """``angle`` (above 0, up to a turn), a turn more where 2,INTOF ends at the start."""
    slack = min(slack, MOST_SLACK)
    if second and angle <= slack:
        return angle + math.tau
    if angle < math.pi - slack if second else angle > math.pi + slack:
        meeting = "second" if second else "first"
        problem = f"its end, {math.degrees(angle):.4g} degrees on, is not where the line is met the {meeting} time"
        raise refusal(source, s, problem, _REMEDY)
    return angle
