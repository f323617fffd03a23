"""CncMotion: the tool of a CNC program: lines, arcs and corners in the frame in force, tilted planes, retracts."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

from toolpaths.frame import Vector
from toolpaths.machine import Machine
from toolpaths.reading.corner import PlaneElement, chamfer, rounding, side_of_length, smooth, turn
from toolpaths.reading.machine_retract import MachineRetract, around_the_cuts
from toolpaths.reading.plain_frame import PlainFrame
from toolpaths.reading.plane_arc import PLANES, in_plane
from toolpaths.reading.source_text import comment_word
from toolpaths.reading.tool_posture import ToolPosture
from toolpaths.reading.track import CUT_MARK, RAPID_MARK, Track
from toolpaths.toolpath import Toolpath

LOST: Vector = (math.nan, math.nan, math.nan)
NORMALS: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ROUND, CHAMFER, CHAMFER_LENGTH = "rounding", "chamfer", "chamfer by its length"
FLAT = 1e-9  # m; heights of one plane


class Corner(NamedTuple):
    """What is put into the corner where the last move ends, at the next one.

    Attributes:
        kind: ROUND, CHAMFER or CHAMFER_LENGTH.
        size: m.
        feed: m/s; NaN: that of the next move.
        line: of the file.
    """

    kind: str
    size: float
    feed: float
    line: int


class CncArc(NamedTuple):
    """An arc in the frame in force: centre m, sweep rad about the axis ``normal`` (0, 1, 2), or about ``axis`` (-1)."""

    center: Vector
    normal: int
    sweep: float
    axis: Vector | None = None


class CncMotion(ToolPosture):
    """The tool of one file.

    Args:
        machine: what the file was posted for.
        tip_word: as for RotaryState.

    Attributes:
        at: m in the frame in force, nan where not known.
        frame: in force, in the work object.
        tool: number of the tool in use.
        normal: 0, 1, 2: the axis at right angles to the working plane.
        text: of the block that is read, for remarks.
        corner: that waits for its next move.
    """

    def __init__(self, source: str, language: str, machine: Machine | None, tip_word: tuple[str, str]) -> None:
        super().__init__(machine, tip_word)
        self.source, self.track = source, Track(source, language)
        self.at, self.frame, self.text = (machine.start if machine and machine.start else LOST), PlainFrame(), ""
        self.tool, self.normal = 0, 2
        self.retracts: list[MachineRetract] = []
        self.corner: Corner | None = None
        self._placed = False  # the last pose is where the tool is
        self._last: tuple[Vector, Vector, CncArc | None, int] | None = None

    def toolpath(self, chord: float) -> Toolpath:
        """The poses in the work object."""
        path = self.rotary.in_work(self.track.toolpath(chord), chord)
        return around_the_cuts(path, self.retracts)

    def go(self, mark: int, end: Vector, feed: float, line: int, time: float = math.nan) -> None:
        """Straight to a place of the frame in force.

        Args:
            mark: CUT_MARK or RAPID_MARK.
            end: m.
            feed: m/s, NaN for a rapid.
            line: of the file.
            time: s that the move takes, NaN where its feed is that of the tip.

        Raises:
            ValueError: a cut to a place that is not known, or while it is not known how the tool stands.
        """
        if self.standing or self._unchecked or (self.waiting and mark == CUT_MARK):
            self.check()
        x, y, z = end
        if x != x or y != y or z != z or (self.rotary.used and not self.given and self.rotary.lost()):
            self._unknown(mark, end, line)
            return
        if mark == CUT_MARK and not self._placed:
            self._begin(line)
        if self.corner is not None:
            self._cut_corner(end, None, feed)
        self._append(mark, end=end, feed=feed, line=line, time=time)

    def sweep(self, arc: CncArc, end: Vector, feed: float, line: int) -> None:
        """Along an arc or helix from where the tool is.

        Raises:
            ValueError: where it starts or ends is not known.
        """
        if self.standing or self._unchecked or self.waiting:
            self.check()
        self._begin(line)
        if not self._placed or any(v != v for v in (*self.at, *end)):
            raise ValueError("an arc, but where it starts is not known", "Name X, Y and Z in a line first.")
        if self.corner is not None:
            arc = self._cut_corner(end, arc, feed) or arc
        about = NORMALS[arc.normal] if arc.axis is None else arc.axis
        self.track.arc(self.frame.out(arc.center), self.frame.along(about), arc.sweep)
        self._append(CUT_MARK, end=end, feed=feed, line=line, arc=arc)

    def _begin(self, line: int) -> None:
        """The file begins with a cut: where [machine] start has the tool before it is a pose."""
        if not len(self.track) and all(v == v for v in self.at) and not (self.rotary.used and self.rotary.lost()):
            self._append(RAPID_MARK, end=self.at, feed=math.nan, line=line)

    def heading(self, normal: int) -> tuple[float, float] | None:
        """Unit vector in a plane in which the last move arrived; None where it did not in that plane."""
        if self._last is None:
            return None
        start, end, arc, _ = self._last
        element = _element(start, end, arc, normal)
        return element.direction(element.end) if element and (arc is None or arc.normal == normal) else None

    def turning_time(self, rate: float, length: float, before: tuple[float, ...], word: float) -> float:
        """s that a move takes whose feed is not that of the tip; NaN: it is.

        Args:
            rate: m/s of the programmed way, NaN for a rapid.
            length: of that way, m.
            before: ``rotary.angles`` before the move.
            word: F, deg/min where only rotary axes move.
        """
        if rate != rate or not self.rotary.used or self.given or self.rotary.angles == before:
            return math.nan
        if length > 0:
            return math.nan if self.tip else length / rate
        turn = sum(abs(a - b) for a, b in zip(self.rotary.angles, before, strict=True))
        return math.degrees(turn) * 60.0 / word if turn > 0 else math.nan

    def _append(
        self, mark: int, end: Vector, feed: float, line: int, time: float = math.nan, arc: CncArc | None = None
    ) -> None:
        track = self.track
        track.moves.extend((*self.frame.out(end), *self.axis, feed))
        track.marks.extend((mark, self.tool, line))
        if self.rotary.used:
            self.rotary.note(self.tip, time, self.given)
        self._last = (self.at, end, arc, mark) if self._placed else None
        self.at, self._placed = end, True

    def _unknown(self, mark: int, end: Vector, line: int) -> None:
        if mark == CUT_MARK:
            names = [a for a, v in zip("XYZ", end, strict=True) if v != v] or ["a rotary axis"]
            problem = f"a cutting move, but where {', '.join(names)} is, is not known"
            start = "" if len(self.track) else ", or give [machine] start = [x, y, z] in the cell"
            raise ValueError(problem, f"Approach with a rapid that names all axes{start}.")
        self.no_corner()
        self.at, self._placed, self._last = end, False, None
        self.track.event(f"{comment_word(self.text)}, before the position is known", line)

    # Corners

    def put_corner(self, corner: Corner) -> None:
        """A rounding or chamfer behind the last move.

        Raises:
            ValueError: there is no move that ends in a corner.
        """
        if self._last is None or self.corner is not None or not corner.size > 0:
            raise ValueError(f"a {corner.kind} of {corner.size * 1e3:g} mm, but no move ends in a corner before it")
        self.corner = corner

    def no_corner(self) -> None:
        """What comes now cannot stand between a corner and the move behind it.

        Raises:
            ValueError: a corner waits.
        """
        if self.corner is not None:
            raise ValueError(f"the {self.corner.kind} of line {self.corner.line} has no move behind it in its plane")

    def _cut_corner(self, end: Vector, arc: CncArc | None, feed: float) -> CncArc | None:
        """Shorten the last move, put the corner in; the arc that comes, from its new start."""
        corner, last = self.corner, self._last
        self.corner = None
        if corner is None or last is None:
            return arc
        start, at, before, mark = last
        normal = before.normal if before else arc.normal if arc else self.normal
        first, second = _element(start, at, before, normal), _element(at, end, arc, normal)
        if mark != CUT_MARK or (arc and arc.normal != normal) or first is None or second is None:
            problem = f"the {corner.kind} of line {corner.line} stands beside a move out of the plane {PLANES[normal]}"
            raise ValueError(problem, "Post its moves instead.")
        if smooth(first, second):
            return arc
        if corner.kind == ROUND:
            put = rounding(first, second, corner.size)
            begin, stop = put.start, put.end
            between: CncArc | None = CncArc(in_plane(at, put.center, normal), normal, put.sweep)
        else:
            side = corner.size if corner.kind == CHAMFER else side_of_length(first, second, corner.size)
            (begin, stop), between = chamfer(first, second, side), None
        self._end_last(in_plane(at, begin, normal), first, begin)
        if between:
            self.track.arc(self.frame.out(between.center), self.frame.along(NORMALS[normal]), between.sweep)
        rate = feed if corner.feed != corner.feed else corner.feed
        self._append(CUT_MARK, end=in_plane(at, stop, normal), feed=rate, line=corner.line, arc=between)
        if arc is None or second.center is None:
            return arc
        left = abs(arc.sweep) - turn(second.center, second.start, stop, arc.sweep)
        return arc._replace(sweep=math.copysign(left, arc.sweep))

    def _end_last(self, end: Vector, element: PlaneElement, stop: tuple[float, float]) -> None:
        """The last move ends earlier."""
        moves = self.track.moves
        moves[-7], moves[-6], moves[-5] = self.frame.out(end)
        if element.center is not None:
            swept = turn(element.center, element.start, stop, element.sweep)
            self.track.arcs[-1] = math.copysign(swept, element.sweep)
        self.at = end

    # Where coordinates count from

    def set_frame(self, frame: PlainFrame) -> None:
        """Coordinates count from another frame; the tool stays where it is."""
        self.no_corner()
        old, self.frame, self._last = self.frame, frame, None
        if all(v == v for v in self.at) or (old.rows is None and frame.rows is None):
            self.at = frame.inward(old.out(self.at))
        else:
            self.at = LOST

    def lose(self, axes: Collection[str], words: str, line: int) -> None:
        """A retract to a place of the machine: these axes, or all where it names none, are not known any more."""
        self.no_corner()
        every = self.frame.rows is not None or not axes
        x, y, z = (math.nan if every or a in axes else v for a, v in zip("XYZ", self.at, strict=True))
        self.at, self._placed, self._last = (x, y, z), False, None
        self.retracts.append(MachineRetract(len(self.track), line, words))
        self.track.event(words, line)

    def swivel(self, frame: PlainFrame, words: str, line: int, *, turns: bool, keeps: bool) -> None:
        """A tilted working plane.

        Args:
            frame: that the coordinates count in.
            words: of the block, for the remark.
            line: of the file.
            turns: the control turns the rotary axes itself; else words of the program do.
            keeps: the tip stays where it is on the work.
        """
        self._change_frame(frame, words, line, keeps=keeps)
        self.tilt(frame.z, turns=turns)

    def end_swivel(self, frame: PlainFrame, words: str, line: int, *, turns: bool, keeps: bool = False) -> None:
        """No tilted working plane any more; ``turns``: the rotary axes go back to 0."""
        self._change_frame(frame, words, line, keeps=keeps)
        self.level(turns=turns)

    def _change_frame(self, frame: PlainFrame, words: str, line: int, *, keeps: bool) -> None:
        turned = not frame.turns_as(self.frame)
        self.set_frame(frame)
        if turned and not keeps:
            self.lose((), words, line)
        else:
            self.track.event(words, line)


def _element(start: Vector, end: Vector, arc: CncArc | None, normal: int) -> PlaneElement | None:
    """A move in its plane; None where it leaves it, or goes nowhere."""
    u, v = (normal + 1) % 3, (normal + 2) % 3
    center = (arc.center[u], arc.center[v]) if arc else None
    element = PlaneElement((start[u], start[v]), (end[u], end[v]), center, arc.sweep if arc else 0.0)
    nowhere = arc is None and math.dist(element.start, element.end) <= FLAT
    return None if nowhere or normal < 0 or abs(end[normal] - start[normal]) > FLAT else element
