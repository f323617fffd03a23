"""APT/CL and Siemens NX CLSF: GOTO with the tool axis, feeds, units, frames; NX circles."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.readers.apt_words import (
    EVENTS,
    FEED_WORDS,
    PASSED,
    REFUSED,
    UNIT_WORDS,
    Statement,
    number,
    numbers,
    statements,
)
from toolpaths.readers.frame import Frame, frame_from_msys
from toolpaths.readers.gcode_arc import FULL_CIRCLE
from toolpaths.readers.text import comment_word, load_lines
from toolpaths.readers.track import CUT_MARK, RAPID_MARK, Track, Vector
from toolpaths.toolpath import Toolpath

UPRIGHT: Vector = (0.0, 0.0, 1.0)
UNIT_TOLERANCE = 1e-3
CIRCLE_TOLERANCE = 2e-3, 1e-3  # file units, share of the radius: by how much an end may miss the circle


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of an APT/CL or CLSF file in its first coordinate system."""
    reader = _Reader(source)
    for statement in statements(load_lines(path, source), source):
        reader.statement(statement)
    return reader.finish(chord)


class _Reader:
    """Modal state while the statements of one file are read; positions in the file's length unit."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.track = Track(source, "apt")
        self.unit: float | None = None  # m, as UNITS says
        self.feed_units: dict[float, int] = {}  # m, line: length units that feeds are given in
        self.axis, self.axis_stale = UPRIGHT, False
        self.at: Vector | None = None
        self.rapid = False
        self.feed, self.per_turn, self.rpm = math.nan, False, math.nan  # m/min or m/turn
        self.tool = 0
        self.first: Frame | None = None  # the first MSYS
        self.msys: Frame | None = None  # the one in force
        self.frame: Frame | None = None  # its pose in the first one, None where they are the same
        self.csys: list[float] | None = None
        self.circle: Statement | None = None
        self.open = self.ended = self.closed = False
        self.acts = {
            "GOTO": self._goto,
            "FROM": self._goto,
            "RAPID": self._rapid,
            "CIRCLE": self._circle,
            "FEDRAT": self._feedrate,
            "SPINDL": self._spindle,
            "UNITS": self._units,
            "UNIT": self._units,
            "MSYS": self._msys,
            "CSYS": self._csys,
            "TRNTYP": self._transformation,
            "TLAXIS": self._tool_axis,
            "MULTAX": self._multax,
            "LOAD": self._load,
            "LOADTL": self._load,
            "TOOLNO": self._load,
            "TOOL PATH": self._tool_path,
            "END-OF-PATH": self._end,
            "END": self._end,
            "FINI": self._end,
            "CUTCOM": self._only_off,
            "CYCLE": self._only_off,
        }

    def statement(self, s: Statement) -> None:
        """Act on one statement, or refuse it."""
        if s.word == "$$":
            self.track.event(comment_word(s.text), s.line)
            return
        if self.ended:
            raise self._error(s, "a statement after FINI", "Two programs in one file? Give one file each.")
        if act := self.acts.get(s.word):
            act(s)
        elif s.word in EVENTS:
            self.track.event(comment_word(str(s)), s.line)
        elif s.word not in PASSED:
            why = REFUSED.get(s.word, "this reader does not know the word")
            raise self._error(s, why)

    def finish(self, chord: float) -> Toolpath:
        """The poses, when all of the file is read."""
        if self.circle:
            raise self._error(self.circle, "no GOTO follows with the end of the circle")
        if not self.closed or self.open:
            missing = "END-OF-PATH" if self.open else "FINI or END-OF-PATH"
            problem = f"the file looks cut off: {missing} is missing"
            raise ReadError(self.source, None, problem, "Output it again.")
        return self.track.toolpath(chord, scale=self._scale())

    def _scale(self) -> float:
        if self.unit is not None:
            return self.unit
        if len(self.feed_units) == 1:
            return next(iter(self.feed_units))
        problem = "no units: neither UNITS/MM nor UNITS/INCHES, and no feed with MMPM or IPM that tells"
        if self.feed_units:
            problem = "no units: UNITS is missing, and feeds are in mm (MMPM) as well as in inch (IPM)"
        raise ReadError(self.source, None, problem, "Write UNITS/MM or UNITS/INCHES on the first line.")

    def _goto(self, s: Statement) -> None:
        values = numbers(s, (3, 6), self.source)
        if len(values) == 6:
            self._set_axis(s, values[3:])
        elif self.axis_stale:
            problem = "no tool axis, and the one from before belongs to another path or frame"
            raise self._error(s, problem, "Output i, j, k with the first GOTO of each path.")
        end, axis = (values[0], values[1], values[2]), self.axis
        if self.frame:
            end, axis = self.frame.point(end), self.frame.vector(axis)
        rapid = self.rapid or s.word == "FROM"
        if self.circle:
            self._arc(self.circle, end, axis, turned=len(values) == 6, rapid=rapid)
        self.track.moves.extend((*end, *axis, math.nan if rapid else self._feed_now(s)))
        self.track.marks.extend((RAPID_MARK if rapid else CUT_MARK, self.tool, s.line))
        self.at, self.rapid, self.circle = end, False, None

    def _set_axis(self, s: Statement, values: list[float]) -> None:
        norm = math.hypot(*values)
        if not abs(norm - 1.0) <= UNIT_TOLERANCE:
            raise self._error(s, f"the tool axis has length {norm:.6g}, 1 expected")
        self.axis, self.axis_stale = (values[0] / norm, values[1] / norm, values[2] / norm), False

    def _feed_now(self, s: Statement) -> float:
        """m/s"""
        if not self.per_turn:
            return self.feed / 60.0
        if not self.rpm > 0:
            problem = "the feed is per revolution, but no speed in RPM is in force"
            raise self._error(s, problem, "Add SPINDL/RPM,n.")
        return self.feed * self.rpm / 60.0

    def _rapid(self, s: Statement) -> None:
        if s.minor:
            raise self._error(s, "only the plain RAPID (for the next GOTO) is read")
        self.rapid = True

    def _circle(self, s: Statement) -> None:
        """NX: CIRCLE/x,y,z,i,j,k,r,t,f,d,e, which ends at the next GOTO. Source: NX help, CLSF Manager."""
        if "TIMES" in s.minor:
            raise self._error(s, "helices of several turns are not read yet", "Output GOTO points.")
        if len(s.minor) != 11:
            problem = f"{len(s.minor)} values; read is the form of NX with 11 (x,y,z,i,j,k,r,t,f,d,e)"
            raise self._error(s, problem, "Output GOTO points instead of circles.")
        numbers(s, (11,), self.source)
        if self.at is None:
            raise self._error(s, "a circle, but no GOTO before it says where it starts")
        self.circle = s

    def _arc(self, s: Statement, end: Vector, axis: Vector, *, turned: bool, rapid: bool) -> None:
        x, y, z, i, j, k, radius = numbers(s, (11,), self.source)[:7]
        center, normal = (x, y, z), (i, j, k)
        if self.frame:
            center, normal = self.frame.point(center), self.frame.vector(normal)
        if rapid:
            raise self._error(s, "RAPID between a circle and its end")
        if turned and math.dist(axis, tuple(self.track.moves[-4:-1])) > 1e-6:
            raise self._error(s, "the tool axis turns along a circle", "Output GOTO points.")
        a, b, n = (np.array(v) for v in (self.at, end, normal))
        if not abs((norm := float(np.linalg.norm(n))) - 1.0) <= UNIT_TOLERANCE:
            raise self._error(s, f"the axis of the circle has length {norm:.6g}, 1 expected")
        n = n / norm
        u, v = (w - np.dot(w, n) * n for w in (a - np.array(center), b - np.array(center)))
        self._check_radius(s, radius, (float(np.linalg.norm(u)), float(np.linalg.norm(v))))
        # NX means clockwise about i, j, k
        sweep = -math.atan2(np.dot(np.cross(u, v), n), np.dot(u, v)) % math.tau
        if sweep < FULL_CIRCLE:
            sweep += math.tau
        self.track.arc(center, (float(n[0]), float(n[1]), float(n[2])), -sweep)

    def _check_radius(self, s: Statement, radius: float, found: tuple[float, float]) -> None:
        most = max(CIRCLE_TOLERANCE[0], CIRCLE_TOLERANCE[1] * abs(radius))
        if not radius > 0 or any(abs(r - radius) > most for r in found):
            problem = f"radius {radius:g}, but the ends lie {found[0]:.6g} and {found[1]:.6g} from its centre"
            raise self._error(s, problem, "Output GOTO points.")

    def _feedrate(self, s: Statement) -> None:
        values = [v for v in map(number, s.minor) if v is not None]
        words = [m for m in s.minor if number(m) is None]
        if len(values) != 1 or len(words) > 1 or not all(w in FEED_WORDS for w in words):
            raise self._error(s, f"one number and one of {', '.join(FEED_WORDS)} are expected")
        if not 0 < values[0] < 1e9:
            raise self._error(s, "a feed above 0 is expected")
        if not words and self.per_turn:
            raise self._error(s, "no unit, after a feed per revolution", "Add MMPM, MMPR, IPM or IPR.")
        length, self.per_turn = FEED_WORDS[words[0]] if words else (None, False)
        if length is not None:
            self.feed_units.setdefault(length, s.line)
        elif (length := self.unit) is None:
            problem = "a feed without unit, and no UNITS before it"
            raise self._error(s, problem, "Write UNITS/MM or UNITS/INCHES on top.")
        self.feed = values[0] * length

    def _spindle(self, s: Statement) -> None:
        values = [v for v in map(number, s.minor) if v is not None]
        if "OFF" in s.minor or {"SFM", "SMM", "SURFACE"} & set(s.minor):
            self.rpm = math.nan
        elif values:
            self.rpm = values[0] if 0 < values[0] < 1e9 else math.nan
        self.track.event(comment_word(str(s)), s.line)

    def _units(self, s: Statement) -> None:
        unit = UNIT_WORDS.get(s.minor[0]) if len(s.minor) == 1 else None
        if unit is None:
            raise self._error(s, "MM or INCHES is expected")
        if self.unit not in (None, unit) or (self.unit is None and len(self.track)):
            raise self._error(s, "the unit changes within the file", "Give one unit, before the first GOTO.")
        self.unit = unit

    def _msys(self, s: Statement) -> None:
        try:
            here = frame_from_msys(numbers(s, (9,), self.source))
        except ValueError as problem:
            raise self._error(s, str(problem)) from None
        if self.msys is None and len(self.track):
            raise self._error(s, "the first MSYS comes after poses: their frame is not known")
        if self.msys is not None and not here.same(self.msys) and self.axis != UPRIGHT:
            self.axis_stale = True
        self.msys, self.first = here, self.first or here
        self.frame = None if here.same(self.first) else self.first.inverse().times(here)

    def _csys(self, s: Statement) -> None:
        values = numbers(s, (12,), self.source)
        if self.csys not in (None, values):
            raise self._error(s, "a second coordinate system is not read yet", "Output in one.")
        if self.csys is None and len(self.track):
            raise self._error(s, "the first CSYS comes after poses: their frame is not known")
        self.csys = values

    def _transformation(self, s: Statement) -> None:
        if s.minor[:1] != ["WORLD"] or any(number(m) != 0 for m in s.minor[1:]):
            raise self._error(s, "only TRNTYP/WORLD,0,0,0 is read")

    def _tool_axis(self, s: Statement) -> None:
        self._set_axis(s, numbers(s, (3,), self.source))

    def _multax(self, s: Statement) -> None:
        if s.minor not in ([], ["ON"], ["OFF"]):
            raise self._error(s, "MULTAX, MULTAX/ON or MULTAX/OFF is expected")
        if s.minor == ["OFF"] and self.axis != UPRIGHT:
            self.axis_stale = True

    def _load(self, s: Statement) -> None:
        minor = s.minor[1:] if s.word == "LOAD" and s.minor[:1] == ["TOOL"] else s.minor
        value = number(minor[0]) if minor and (s.word != "LOAD" or minor is not s.minor) else None
        if value is None or not 0 <= value < 1e9 or value != int(value):
            raise self._error(s, "a tool number is expected", "Write LOAD/TOOL,n or LOADTL/n.")
        self.tool = int(value)
        self.track.event(comment_word(str(s)), s.line)

    def _tool_path(self, s: Statement) -> None:
        if self.open:
            problem = "a path begins before END-OF-PATH of the last one"
            raise self._error(s, problem, "Is the file cut off or mixed?")
        self.open, self.axis_stale = True, self.axis != UPRIGHT
        self.track.event(comment_word(str(s)), s.line)

    def _end(self, s: Statement) -> None:
        self.closed, self.open = True, False
        self.ended = s.word == "FINI"

    def _only_off(self, s: Statement) -> None:
        if s.minor != ["OFF"]:
            raise self._error(s, REFUSED[s.word])

    def _error(self, s: Statement, problem: str, remedy: str = "") -> ReadError:
        return ReadError(self.source, s.line, f"{str(s)[:80]}: {problem}", remedy)
