"""G41 and G42: the path of the cutter's centre beside the programmed one, in the plane G17.

As LinuxCNC does it (interp_convert.cc, convert_straight_comp1 and 2, convert_arc_comp1 and 2; compared with rs274):
the move that begins it ends beside its own end; at an outer corner the centre goes round the corner on an arc, at an
inner one it stops where both offset paths meet; after G40 it goes straight to the next programmed point.
"""

from __future__ import annotations

import math

from toolpaths.frame import Vector
from toolpaths.languages.gcode.programmed_move import Point, ProgrammedMove
from toolpaths.reading.track import CUT_MARK, Track

NORMAL: Vector = (0.0, 0.0, 1.0)
_SAME = 1e-9  # m
_SMOOTH = 1e-6  # rad: a corner that is none


class CutterCompensation:
    """What is done to the moves of one stretch of G41 or G42.

    Args:
        track: where moves are appended; the end of the last one is moved where the next meets it in an inner corner.
        radius: of the cutter, m.
        left: G41.
    """

    def __init__(self, track: Track, radius: float, *, left: bool) -> None:
        self._track, self._radius, self._side = track, radius, 1.0 if left else -1.0
        self._last: ProgrammedMove | None = None  # the last programmed move in the plane
        self._at: Point = (math.nan, math.nan)  # where the centre is
        self._from: Point = (math.nan, math.nan)  # where the last move of the centre began
        self._moves: list[int] = []  # rows of the track that stand at the end of the last move

    def segment(self, s: ProgrammedMove) -> None:
        """The next programmed move.

        Raises:
            ValueError: the cutter does not fit.
        """
        if math.hypot(s.end[0] - s.start[0], s.end[1] - s.start[1]) <= _SAME and s.center is None:
            self._append(s, (s.end[0], s.end[1]) if self._last is None else self._at, s.end[2])
            return
        if self._last is None:
            self._begin(s)
        else:
            self._corner(self._last, s)
            self._follow(s)
        self._last = s

    def _begin(self, s: ProgrammedMove) -> None:
        if s.center is not None:
            raise ValueError("cutter compensation begins with an arc", "Begin it with a straight move.")
        if math.hypot(s.end[0] - s.start[0], s.end[1] - s.start[1]) <= self._radius:
            raise ValueError("the move that begins cutter compensation is not longer than the radius of the cutter")
        self._from = math.nan, math.nan  # this move runs beside nothing: wherever the next one begins, it leads there
        self._moves = []
        self._append(s, self._beside(s.end, s.way(s.end)), s.end[2])

    def _beside(self, p: Vector, way: Point) -> Point:
        """Where the centre stands beside a programmed point."""
        return p[0] - self._side * self._radius * way[1], p[1] + self._side * self._radius * way[0]

    def _corner(self, before: ProgrammedMove, s: ProgrammedMove) -> None:
        """From the end of the last move of the centre to where the next one begins."""
        u, v = before.way(before.end), s.way(s.start)
        turn = math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
        if abs(turn) <= _SMOOTH:
            return
        if turn * self._side > 0 and abs(turn) < math.pi - _SMOOTH:
            self._meet(before, s, turn)
            return
        sweep = turn if turn * self._side < 0 else -turn  # straight back: round the corner
        if s.mark == CUT_MARK:
            center = s.start[0], s.start[1], s.start[2]
            self._track.arc(center, NORMAL, sweep)
            self._moves = []
            self._append(s, self._beside(s.start, v), s.start[2])

    def _meet(self, before: ProgrammedMove, s: ProgrammedMove, turn: float) -> None:
        """An inner corner: the centre stops where both offset paths meet."""
        p = s.start
        if before.center is None and s.center is None:
            back = self._radius * math.tan(abs(turn) / 2)
            u = before.way(before.end)
            meet = self._at[0] - back * u[0], self._at[1] - back * u[1]
        else:
            meet = _nearest(_meetings(self._curve(before), self._curve(s)), (p[0], p[1]))
        self._check_meeting(before, meet, self._from, -1.0)
        self._check_meeting(s, meet, self._beside(s.end, s.way(s.end)), 1.0)
        if before.center is not None:
            self._turn_last_arc(before, meet)
        for row in self._moves:
            self._track.moves[7 * row], self._track.moves[7 * row + 1] = meet
        self._at = meet

    def _check_meeting(self, s: ProgrammedMove, meet: Point, far: Point, sign: float) -> None:
        """The meeting point lies on the offset move, before its other end; ``sign``: +1 where that is its end."""
        if s.center is None:
            way = s.way(s.end)
            room = sign * ((far[0] - meet[0]) * way[0] + (far[1] - meet[1]) * way[1])
        else:
            a = math.atan2(meet[1] - s.center[1], meet[0] - s.center[0])
            b = math.atan2(far[1] - s.center[1], far[0] - s.center[0])
            room = (sign * math.copysign(1.0, s.sweep) * (b - a)) % math.tau
            room = 1.0 if room <= abs(s.sweep) + _SMOOTH or abs(s.sweep) > math.pi else -1.0
        if room < -_SAME:
            radius = f"{self._radius * 1e3:g} mm"
            raise ValueError(f"a cutter of radius {radius} does not fit into the corner before this move",
                             "Take a smaller cutter, or let CAM compensate.")  # fmt: skip

    def _curve(self, s: ProgrammedMove) -> tuple[Point, Point | None, float]:
        """Offset path: a point and a direction of a line, or centre and radius of a circle."""
        if s.center is None:
            way = s.way(s.end)
            return self._beside(s.end, way), way, 0.0
        return (s.center[0], s.center[1]), None, self._offset_radius(s)

    def _offset_radius(self, s: ProgrammedMove) -> float:
        center = s.center or s.start
        radius = math.hypot(s.start[0] - center[0], s.start[1] - center[1])
        radius -= self._side * math.copysign(self._radius, s.sweep)
        if radius <= _SAME:
            raise ValueError(f"an arc of a smaller radius than that of the cutter, {self._radius * 1e3:g} mm")
        return radius

    def _turn_last_arc(self, s: ProgrammedMove, meet: Point) -> None:
        """The last arc of the track ends at another place."""
        center = s.center or s.start
        a = math.atan2(self._from[1] - center[1], self._from[0] - center[0])
        b = math.atan2(meet[1] - center[1], meet[0] - center[0])
        sign = math.copysign(1.0, s.sweep)
        sweep = (sign * (b - a)) % math.tau
        whole = math.tau * math.floor(abs(s.sweep) / math.tau - 1e-9)
        self._track.arcs[-1] = sign * (sweep + whole)

    def _follow(self, s: ProgrammedMove) -> None:
        end = self._beside(s.end, s.way(s.end))
        self._from, self._moves = self._at, []
        if s.center is not None:
            self._offset_radius(s)
            sign = math.copysign(1.0, s.sweep)
            a = math.atan2(self._from[1] - s.center[1], self._from[0] - s.center[0])
            b = math.atan2(end[1] - s.center[1], end[0] - s.center[0])
            sweep = (sign * (b - a)) % math.tau
            if sweep < _SMOOTH or (abs(s.sweep) > math.pi and sweep < math.pi and abs(s.sweep) - sweep > math.pi):
                sweep += math.tau
            whole = math.tau * max(math.ceil(abs(s.sweep) / math.tau - 1e-9) - 1, 0)
            self._track.arc((s.center[0], s.center[1], s.center[2]), NORMAL, sign * (sweep + whole))
        self._append(s, end, s.end[2])

    def _append(self, s: ProgrammedMove, to: Point, height: float) -> None:
        self._moves.append(len(self._track))
        self._track.moves.extend((to[0], to[1], height, 0.0, 0.0, 1.0, s.feed))
        self._track.marks.extend((s.mark, s.tool, s.line))
        self._at = to


Curve = tuple[Point, Point | None, float]


def _meetings(a: Curve, b: Curve) -> list[Point]:
    """Where a line and a circle, or two circles, meet."""
    if a[1] is None and b[1] is not None:
        a, b = b, a
    (px, py), way, ra = a
    (cx, cy), _, rb = b
    if way is not None:
        along = (cx - px) * way[0] + (cy - py) * way[1]
        fx, fy = px + along * way[0], py + along * way[1]
        rest = rb * rb - (fx - cx) ** 2 - (fy - cy) ** 2
        half = math.sqrt(rest) if rest > 0 else 0.0
        found = [(fx - half * way[0], fy - half * way[1]), (fx + half * way[0], fy + half * way[1])]
        return found if rest > -_SAME * rb else []
    dx, dy = cx - px, cy - py
    d = math.hypot(dx, dy)
    if d <= _SAME:
        return []
    along = (ra * ra - rb * rb + d * d) / (2 * d)
    rest = ra * ra - along * along
    if rest < -_SAME * ra:
        return []
    half = math.sqrt(max(rest, 0.0))
    fx, fy = px + along * dx / d, py + along * dy / d
    return [(fx - half * dy / d, fy + half * dx / d), (fx + half * dy / d, fy - half * dx / d)]


def _nearest(points: list[Point], to: Point) -> Point:
    if not points:
        raise ValueError("the cutter does not fit into the corner before this move", "Let CAM compensate.")
    return min(points, key=lambda p: math.hypot(p[0] - to[0], p[1] - to[1]))
