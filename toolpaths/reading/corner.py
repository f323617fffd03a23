"""Corners of a contour in a plane: rounded by an arc that is tangent to both elements, or cut by a chamfer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

Point = tuple[float, float]
ON = 1e-7  # m; how far a touching point may lie outside of its element
SAME_WAY = 1e-6  # sine of the angle between two elements that go on smoothly


class PlaneElement(NamedTuple):
    """A line, or an arc, in a plane; m.

    Attributes:
        start: and ``end``.
        center: of an arc; None: a line.
        sweep: rad of an arc, above 0 counterclockwise.
    """

    start: Point
    end: Point
    center: Point | None = None
    sweep: float = 0.0

    def direction(self, at: Point) -> Point:
        """Unit vector of travel at a point of the element."""
        if self.center is None:
            u, v = self.end[0] - self.start[0], self.end[1] - self.start[1]
        else:
            side = math.copysign(1.0, self.sweep)
            u, v = -side * (at[1] - self.center[1]), side * (at[0] - self.center[0])
        size = math.hypot(u, v)
        return (u / size, v / size) if size > 0 else (0.0, 0.0)

    def touching(self, point: Point) -> Point:
        """The point of the line or circle that is nearest."""
        if self.center is None:
            d = self.direction(point)
            along = (point[0] - self.start[0]) * d[0] + (point[1] - self.start[1]) * d[1]
            return self.start[0] + along * d[0], self.start[1] + along * d[1]
        u, v = point[0] - self.center[0], point[1] - self.center[1]
        size, radius = math.hypot(u, v), math.dist(self.center, self.start)
        return (self.center[0] + u / size * radius, self.center[1] + v / size * radius) if size > 0 else self.start

    def holds(self, point: Point) -> bool:
        """Whether a point of the line or circle lies between start and end."""
        if self.center is None:
            d, length = self.direction(point), math.dist(self.start, self.end)
            along = (point[0] - self.start[0]) * d[0] + (point[1] - self.start[1]) * d[1]
            return -ON <= along <= length + ON
        turned, slack = turn(self.center, self.start, point, self.sweep), ON / math.dist(self.center, self.start)
        return turned <= abs(self.sweep) + slack or turned >= math.tau - slack


class CornerArc(NamedTuple):
    """What rounds a corner: from ``start``, where it leaves the first element, to ``end`` on the second one."""

    start: Point
    end: Point
    center: Point
    sweep: float


def turn(center: Point, start: Point, end: Point, sweep: float) -> float:
    """rad from 0 to a turn from ``start`` to ``end`` in the sense of ``sweep``."""
    angle = math.atan2(end[1] - center[1], end[0] - center[0]) - math.atan2(start[1] - center[1], start[0] - center[0])
    return (angle if sweep >= 0 else -angle) % math.tau


def smooth(first: PlaneElement, second: PlaneElement) -> bool:
    """Whether the second element goes on in the direction of the first: there is no corner."""
    (a, b), (c, d) = first.direction(first.end), second.direction(second.start)
    return abs(a * d - b * c) < SAME_WAY and a * c + b * d > 0


def rounding(first: PlaneElement, second: PlaneElement, radius: float) -> CornerArc:
    """The arc of a radius (m) that is tangent to both elements, nearest to their corner.

    Raises:
        ValueError: it does not fit between them.
    """
    best: tuple[float, CornerArc] | None = None
    for center in _centres(first, second, radius):
        start, end = first.touching(center), second.touching(center)
        if not (first.holds(start) and second.holds(end)):
            continue
        way = first.direction(start)
        left = way[0] * (center[1] - start[1]) - way[1] * (center[0] - start[0]) > 0
        sweep = turn(center, start, end, 1.0 if left else -1.0)
        arc = CornerArc(start, end, center, sweep if left else -sweep)
        out = PlaneElement(start, end, center, arc.sweep).direction(end)
        there = second.direction(end)
        if out[0] * there[0] + out[1] * there[1] < 1.0 - 1e-9 or sweep > math.pi + 1e-9:
            continue
        off = math.dist(start, first.end) + math.dist(end, first.end)
        if best is None or off < best[0]:
            best = off, arc
    if best is None:
        raise ValueError(f"no arc of radius {radius * 1e3:g} mm fits into the corner")
    return best[1]


def chamfer(first: PlaneElement, second: PlaneElement, side: float) -> tuple[Point, Point]:
    """Both ends of a chamfer that takes ``side`` (m) off each of two lines.

    Raises:
        ValueError: an element is an arc, or too short.
    """
    if first.center is not None or second.center is not None:
        raise ValueError("a chamfer beside an arc")
    for element in (first, second):
        if side > (length := math.dist(element.start, element.end)) + ON:
            raise ValueError(f"a chamfer of {side * 1e3:g} mm on a line of {length * 1e3:g} mm")
    a, b, corner = first.direction(first.start), second.direction(second.start), first.end
    return (corner[0] - side * a[0], corner[1] - side * a[1]), (corner[0] + side * b[0], corner[1] + side * b[1])


def side_of_length(first: PlaneElement, second: PlaneElement, length: float) -> float:
    """What a chamfer of a length (m) takes off each of two lines."""
    (a, b), (c, d) = first.direction(first.end), second.direction(second.start)
    return length / max(math.hypot(a + c, b + d), 1e-12)


def _centres(first: PlaneElement, second: PlaneElement, radius: float) -> Iterator[Point]:
    """Points that keep a distance from both lines or circles."""
    for a in _offsets(first, radius):
        for b in _offsets(second, radius):
            yield from _meeting(a, b)


#: A line through a point in a direction, or a circle: centre and radius.
_Curve = tuple[Point, Point, float]


def _offsets(element: PlaneElement, by: float) -> Iterator[_Curve]:
    if element.center is None:
        u, v = element.direction(element.start)
        for side in (by, -by):
            yield (element.start[0] - side * v, element.start[1] + side * u), (u, v), 0.0
        return
    radius = math.dist(element.center, element.start)
    for r in (radius + by, radius - by):
        if r > ON:
            yield element.center, (0.0, 0.0), r


def _meeting(a: _Curve, b: _Curve) -> Iterator[Point]:
    if a[2] and not b[2]:
        a, b = b, a
    (p, d, r), (q, e, s) = a, b
    u, v = q[0] - p[0], q[1] - p[1]
    if not s:  # two lines
        cross = d[0] * e[1] - d[1] * e[0]
        if abs(cross) > 1e-12:
            along = (u * e[1] - v * e[0]) / cross
            yield p[0] + along * d[0], p[1] + along * d[1]
    elif not r:  # a line and a circle
        along = u * d[0] + v * d[1]
        half = s * s - (u * u + v * v - along * along)
        for t in _roots(half):
            yield p[0] + (along + t) * d[0], p[1] + (along + t) * d[1]
    elif (gap := math.hypot(u, v)) > ON:  # two circles
        along = (gap * gap + r * r - s * s) / (2.0 * gap)
        for t in _roots(r * r - along * along):
            yield p[0] + (along * u - t * v) / gap, p[1] + (along * v + t * u) / gap


def _roots(square: float) -> tuple[float, ...]:
    if square < -ON * ON:
        return ()
    root = math.sqrt(max(square, 0.0))
    return (root, -root) if root > 0 else (0.0,)
