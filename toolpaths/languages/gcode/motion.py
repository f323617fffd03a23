"""GcodeMotion: what the blocks of a G-code file do to the tool: moves, arcs, cycles, shifts of the origin, retracts."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from toolpaths.frame import Vector
from toolpaths.languages.gcode.arc import arc_geometry
from toolpaths.languages.gcode.codes import ARCS, CYCLES, G
from toolpaths.languages.gcode.drilled_holes import DrilledHoles
from toolpaths.languages.gcode.modal_state import UP
from toolpaths.languages.gcode.placed_moves import NORMALS
from toolpaths.languages.gcode.programmed_move import ProgrammedMove
from toolpaths.languages.gcode.retract import Clearance
from toolpaths.languages.gcode.words import Words
from toolpaths.machine import Machine
from toolpaths.reading.track import CUT_MARK

MOST_TURNS = 100  # of one arc: more is a mistake, and would fill the memory


class MovedBlock(NamedTuple):
    """The modal state under which a block moved, for whoever writes the block again."""

    line: int
    first: int  # moves before the block
    last: int  # moves after it
    motion: G
    unit: float
    relative: bool
    shift: Vector
    inverse: bool
    vectors: bool
    end: Vector


class GcodeMotion(DrilledHoles):
    """The tool of one file; positions in m in the work object, nan where not known.

    Attributes:
        trace: the blocks that moved, for whoever writes them again; None where nobody does.
        clearances: feeds to a height before the position is known.
    """

    def __init__(self, source: str, machine: Machine | None, *, trace: bool = False) -> None:
        super().__init__(source, machine)
        self.trace: list[MovedBlock] | None = [] if trace else None
        self.clearances: list[Clearance] = []

    def shift(self, g: G, values: Words) -> None:
        """G52, G92, G92.1, G92.2, G92.3."""
        name = g.word
        others = values.keys() & set("IJKRABC")
        if others:
            raise ValueError(f"{name} with {', '.join(sorted(others))}: it shifts X, Y and Z only")
        named = {k: values[a] * self.scale() for k, a in enumerate("XYZ") if a in values}
        self.refuse_open(name)
        if self.plane is not None:
            raise ValueError(f"{name} under G68.2", "Write G69 before it.")
        if g in (G.LOCAL_ORIGIN, G.SHIFT) and not named:
            raise ValueError(f"{name} without X, Y or Z")
        if g is G.LOCAL_ORIGIN:
            self.origin.local(named)
        elif g is G.SHIFT:
            lost = [a for k, a in enumerate("XYZ") if k in named and self.at[k] != self.at[k]]
            if lost and len(self.track):
                raise ValueError(f"G92 {lost[0]}{values[lost[0]]:g}, but where {lost[0]} is, is not known",
                                 "Move there in G90 first.")  # fmt: skip
            self.at = self.origin.declare(self.at, named)
        elif g is G.SHIFT_RESTORED:
            self.origin.restore()
        else:
            self.origin.drop(keep=g is G.SHIFT_SET_ASIDE)
        self.cycle.forget()

    def retract(self, g: G, values: Words, line: int, *, feeding: bool) -> str:
        """G28, G30, G53: a place of the machine, not of the work object; the words of the event.

        ``feeding``: G1 or its like stands in the block. Without it G53 is a rapid, as Fanuc has it.
        """
        name = g.word
        axes = [a for a in "XYZABC" if a in values]
        self.rotary.check(values)
        self.refuse_open(name)
        if feeding or not values.keys().isdisjoint("IJKR") or (g is G.MACHINE_PLACE and not axes):
            raise ValueError(f"{name}: read only as a rapid retract", f"Write G53 G0 Z.. or {name} G91 Z0.")
        if g is not G.MACHINE_PLACE and axes and not (self.relative and all(values[a] == 0 for a in axes)):
            self._go_by_way(name, values, line)
        x, y, z = (math.nan if a in (axes or "XYZ") else v for a, v in zip("XYZ", self.at, strict=True))
        self.at = x, y, z
        self.rotary.lose(axes)
        return " ".join([name, *(f"{a}{values[a]:g}" for a in axes)])

    def _go_by_way(self, name: str, values: Words, line: int) -> None:
        """The point that G28 and G30 pass on their way, at a rapid."""
        if not values.keys().isdisjoint("ABC"):
            raise ValueError(f"{name} by way of a point with rotary axes", f"Write {name} G91 and zeros.")
        end = self._target(values)
        if all(v == v for v in end) and not self.rotary.lost():
            self.place(self.rapid(end, line))
        self.at = end

    def move(self, values: Words, line: int) -> None:
        """One block with G0, G1, G2, G3 or a canned cycle in force."""
        motion = self.motion
        if motion is None:
            raise ValueError("coordinates, but no G0, G1, G2 or G3 is in force", "Is the head of the file missing?")
        if motion is not G.RAPID and not len(self.track):
            self._begin(line)
        first = len(self.track)
        if motion in CYCLES:
            self.drill(motion, values, line)
        else:
            self._go(motion, values, line)
        if self.trace is not None:
            self.trace.append(MovedBlock(
                line=line, first=first, last=len(self.track), motion=motion, unit=self.scale(),
                relative=self.relative, shift=self.origin.shift,
                inverse=self.feed.mode is G.INVERSE_TIME, vectors=self.tip and not self.rotary.used, end=self.at,
            ))  # fmt: skip

    def _begin(self, line: int) -> None:
        """The file begins with a cut: where the tool stands before it is a pose, if that is known."""
        if all(v == v for v in self.at) and not self.rotary.lost():
            self.place(self.rapid(self.at, line))

    def _go(self, motion: G, values: Words, line: int) -> None:
        move = self.rapid(self._target(values), line)
        feed = time = math.nan
        if motion is not G.RAPID:
            feed = self.feed.rate(self.scale(), "F" in values, motion)
            move = replace(move, mark=CUT_MARK)
        start, end, length = move.start, move.end, -1.0
        before = self.rotary.angles
        if motion in ARCS:
            move, length = self._arc(motion, values, move)
        elif not values.keys().isdisjoint("IJKRABC"):
            self._point_tool(motion, values)
        if motion is not G.RAPID and (self.rotary.used or self.feed.mode is G.INVERSE_TIME):
            length = math.dist(start, end) if length < 0 else length
            feed, time = self._timed(feed, length, before)
        if self.axis is not UP and not self.tip and self.axis != UP:
            raise ValueError("a move while the tool stands tilted and G43.4 is off: where its tip is depends on the "
                             "machine", "Move only in G43.4, or retract with G53 or G28.")  # fmt: skip
        self.at = end
        move = self.round_corner(replace(move, feed=feed))
        if self.keep_corner(move, values):
            return
        if end[0] == end[0] and end[1] == end[1] and end[2] == end[2] and not self.rotary.lost():
            self.place(move, time)
        else:
            if motion is not G.RAPID:
                self._feed_from_nowhere(values, line)
            self.track.event(f"{_words(values)}, before the position is known", line)

    def _feed_from_nowhere(self, values: Words, line: int) -> None:
        """A cut is never left out: where it runs has to be known; a feed to a clearance height is no cut."""
        names = [a for a, v in zip("XYZ", self.at, strict=True) if v != v]
        known = "after the retract" if len(self.track) else "from the lines before it"
        problem = f"a cutting move, but where {', '.join(names) or 'a rotary axis'} is, is not known {known}"
        remedy = "Approach with a rapid that names all axes."
        if names and not len(self.track):
            remedy = f"{remedy[:-1]}, or say where the tool starts: [machine] start = [x, y, z] in the cell."
        found = Clearance(self.at[2], line, f"{_words(values)}: {problem}", remedy)
        if len(self.track) or _words(values)[:1] != "Z":
            raise ValueError(found.problem, remedy)
        self.clearances.append(found)

    def _target(self, values: Words) -> Vector:
        unit = self.unit or self.scale()
        x, y, z = self.at
        if self.relative:
            for letter, value in zip("XYZ", self.at, strict=True):
                if letter in values and value != value:
                    problem = f"{letter}{values[letter]:g} in G91, but where {letter} starts is not known"
                    raise ValueError(problem, "Move there in G90 first.")
            get = values.get
            return x + get("X", 0.0) * unit, y + get("Y", 0.0) * unit, z + get("Z", 0.0) * unit
        dx, dy, dz = self.shift_in_force()
        return (
            values["X"] * unit + dx if "X" in values else x,
            values["Y"] * unit + dy if "Y" in values else y,
            values["Z"] * unit + dz if "Z" in values else z,
        )

    def _arc(self, motion: G, values: Words, move: ProgrammedMove) -> tuple[ProgrammedMove, float]:
        """The move as an arc, and its length, m."""
        start, end = move.start, move.end
        if any(v != v for v in start) or not len(self.track):
            unknown = "".join(letter for letter, v in zip("XYZ", start, strict=True) if v != v)
            problem = f"an arc, but where it starts is not known ({unknown})"
            raise ValueError(problem, "Name X, Y and Z in G0 or G1 first.")
        if not values.keys().isdisjoint("ABC"):
            raise ValueError("rotary words in an arc", "Post lines instead.")
        unit = self.scale()
        words = {k: v * unit for k, v in values.items() if k in "IJKR"}
        try:
            words = self._centre(words, start)
            turns = _turns(values)
            center, sweep = arc_geometry(words, start, end, self.normal, clockwise=motion is G.ARC_CLOCKWISE)
        except ValueError as problem:
            raise ValueError(str(problem), "Check the arc, or post lines instead.") from None
        sweep += math.copysign((turns - 1) * math.tau, sweep)
        first = (self.normal + 1) % 3
        radius = math.hypot(start[first] - center[first], start[first - 2] - center[first - 2])
        length = math.hypot(radius * sweep, end[self.normal] - start[self.normal])
        return replace(move, center=center, normal=NORMALS[self.normal], sweep=sweep), length

    def _centre(self, words: Words, start: Vector) -> Words:
        """Centre words as offsets from the start, whichever of G90.1 and G91.1 is on."""
        if not self.absolute_centre or "R" in words or words.keys().isdisjoint("IJK"):
            return words
        plane = [k for k in range(3) if k != self.normal]
        missing = ["IJK"[k] for k in plane if "IJK"[k] not in words]
        if missing:
            raise ValueError(f"an arc without {missing[0]}: with G90.1 both centre words are needed")
        shift = self.shift_in_force()
        return {letter: words[letter] + shift[k] - start[k] for k, letter in enumerate("IJK") if letter in words}

    def _point_tool(self, motion: G, values: Words) -> None:
        """I, J, K as tool vector under G43.4, and A, B, C."""
        letters = values.keys()
        if not letters.isdisjoint("IJKR"):
            if "R" in letters or not self.tip or self.rotary.used:
                remedy = "They belong to G2 and G3" + (
                    ", and I J K to G43.4 in files without A B C." if self.tip else "."
                )
                raise ValueError(f"I, J, K or R with {motion.word}", remedy)
            i, j, k = (values.get(c, 0.0) for c in "IJK")  # Fanuc: what is left out beside another is 0
            length = math.sqrt(i * i + j * j + k * k)
            if length < 1e-6:
                raise ValueError("the tool vector I J K has no length")
            self.axis = i / length, j / length, k / length
        if not letters.isdisjoint("ABC"):
            self.rotary.go(values, self.relative, self.tip)

    def _timed(self, rate: float, length: float, before: tuple[float, ...]) -> tuple[float, float]:
        """Feed m/s, and time s where the feed of the tip follows from it."""
        turn = sum(abs(a - b) for a, b in zip(self.rotary.angles, before, strict=True))
        inverse = self.feed.mode is G.INVERSE_TIME
        if not turn > 0:
            return (self.feed.over(length, rate) if inverse else rate), math.nan
        if inverse:
            return rate, 1.0 / rate
        if length > 0:
            return rate, math.nan if self.tip else length / rate
        # F counts degrees a minute when only rotary axes move
        return rate, math.degrees(turn) * 60.0 / (self.feed.word or 1.0)


def _words(values: Words) -> str:
    """The coordinates of a block."""
    return " ".join(f"{a}{values[a]:g}" for a in "XYZABC" if a in values)


def _turns(values: Words) -> int:
    """P of G2 and G3: how many turns are begun."""
    turns = values.get("P", 1.0)
    if turns != math.floor(turns) or not 1 <= turns <= MOST_TURNS:
        raise ValueError(f"P{turns:g}: a whole number of turns from 1 to {MOST_TURNS} is expected")
    return int(turns)
