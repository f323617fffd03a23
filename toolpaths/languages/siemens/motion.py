"""SiemensMotion: where the blocks of a SINUMERIK program move the tool: G0 to G3, CIP, CT, polar, vectors, corners.

Source: NC programming, Fundamentals (motion commands), Job planning (five-axis transformation).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from toolpaths.frame import Vector
from toolpaths.languages.siemens.arc import ArcStart, SiemensArc
from toolpaths.languages.siemens.block import Given
from toolpaths.languages.siemens.frames import FrameShifts, FrameState, SiemensFrames
from toolpaths.machine import Machine
from toolpaths.reading.cnc_feed import INVERSE_TIME, CncFeed
from toolpaths.reading.cnc_motion import CHAMFER, CHAMFER_LENGTH, ROUND, CncMotion, Corner
from toolpaths.reading.plain_frame import PlainFrame
from toolpaths.reading.source_text import comment_word
from toolpaths.reading.track import CUT_MARK, RAPID_MARK

MM, INCH = 1e-3, 25.4e-3
TIP_WORD = "TRAORI", "TRAORI A3= B3= C3="
CORNERS = {"RND": ROUND, "CHR": CHAMFER, "CHF": CHAMFER_LENGTH}
AXES = frozenset("XYZ")
ROTARY = frozenset("ABC")
VECTORS = ("A3", "B3", "C3")
TURNED = ("A2", "B2", "C2")  # Euler or RPY angles
#: What makes a block one that moves.
MOVING = AXES | ROTARY | frozenset((*VECTORS, *TURNED, "AP", "RP", "AR", "I", "J", "K", "CR", "I1", "J1", "K1"))
_ANGLES = {"ORIRPY": (2, 1, 0), "ORIEULER": (2, 0, 2), "ORIRPY2": (0, 1, 2)}
ORIENTATIONS = frozenset((*_ANGLES, "ORIWKS", "ORIMKS", "ORIAXPOS"))


class SiemensModes(NamedTuple):
    """Modal words; see SiemensMotion."""

    motion: int | str | None
    relative: bool
    normal: int
    feed: str
    frames: FrameState


class SiemensMotion(CncMotion):
    """The tool of one file.

    Attributes:
        motion: G0 to G3 as 0 to 3, CIP or CT; None before the first.
        unit: m of a length; None before G71 or its like.
        relative: G91.
        frames: in force.
    """

    def __init__(self, source: str, machine: Machine | None) -> None:
        super().__init__(source, "siemens", machine, TIP_WORD)
        self.motion: int | str | None = None
        self.unit: float | None = None
        self.relative = False
        self.feed = CncFeed()
        self.frames = SiemensFrames(machine.systems if machine else {})
        self.angles = "ORIAXPOS"
        self.in_machine = False  # ORIMKS
        self.pole: tuple[float, float] = (0.0, 0.0)
        self.polar: tuple[float, float] | None = None  # the last AP (deg) and RP (m)
        self.shifts = FrameShifts()

    def scale(self) -> float:
        """m of a length unit of the file."""
        if self.unit is None:
            remedy = "Add G710 (mm) or G700 (inch) on top."
            raise ValueError("no units: neither G71, G710 nor G700 before it", remedy)
        return self.unit

    def move(self, values: Mapping[str, Given], line: int) -> None:
        """One block that moves."""
        motion = self.motion
        if motion is None:
            raise ValueError("coordinates, but no G0, G1, G2 or G3 is in force", "Is the head of the program missing?")
        unit = self.unit or self.scale()
        end = self._target(values, unit)
        feed = math.nan if motion == 0 else self._rate(values)
        if motion in (0, 1):
            self._straight(values, end, feed, line)
        else:
            if not values.keys().isdisjoint((*ROTARY, *VECTORS, *TURNED)):
                raise ValueError("the tool turns along an arc", "Post lines instead.")
            arc = SiemensArc(self._arc_start(), values, unit, end)
            found = arc.found()
            if self.feed.mode == INVERSE_TIME:
                feed = self.feed.over(arc.length(found))
            if found is None:
                self.go(CUT_MARK, arc.end, feed, line)
            else:
                self.sweep(found, arc.end, feed, line)
        self._corner(values, unit, line)

    def _arc_start(self) -> ArcStart:
        heading = self.heading(self.normal) if self.motion == "CT" else None
        return ArcStart(
            at=self.at, normal=self.normal, pole=self.pole, motion=self.motion, relative=self.relative,
            heading=heading,
        )  # fmt: skip

    def put_frame(self) -> None:
        """The frames changed."""
        self.set_frame(self.frames.total())

    def set_frame(self, frame: PlainFrame) -> None:
        """Coordinates count from another frame."""
        before = self.at
        super().set_frame(frame)
        self.shifts.changed(before, self.at)

    def modes(self) -> SiemensModes:
        """The modal words in force, for a subprogram that leaves them as it found them."""
        return SiemensModes(
            motion=self.motion, relative=self.relative, normal=self.normal, feed=self.feed.mode,
            frames=self.frames.state(),
        )  # fmt: skip

    def restore(self, modes: SiemensModes) -> None:
        """Modal words as they were."""
        self.motion, self.relative, self.normal = modes.motion, modes.relative, modes.normal
        self.feed.choose(modes.feed)
        self.frames.put_back(modes.frames)
        self.put_frame()

    def choose_pole(self, g: int, values: Mapping[str, Given]) -> None:
        """G110 (from the last position), G111 (from the origin), G112 (from the last pole)."""
        u, v = (self.normal + 1) % 3, (self.normal + 2) % 3
        base = {110: (self.at[u], self.at[v]), 111: (0.0, 0.0)}.get(g, self.pole)
        if any(b != b for b in base):
            raise ValueError(f"G{g}, but where the tool is, is not known")
        if "AP" in values or "RP" in values:
            angle, radius = math.radians(plain(values, "AP")), plain(values, "RP") * self.scale()
            self.pole = base[0] + radius * math.cos(angle), base[1] + radius * math.sin(angle)
            return
        du, dv = (plain(values, "XYZ"[k]) * self.scale() if "XYZ"[k] in values else 0.0 for k in (u, v))
        self.pole = base[0] + du, base[1] + dv

    def turn_to(self, values: Mapping[str, Given], *, alone: bool) -> None:
        """A, B, C: positions of rotary axes, absolute, relative or with the way round."""
        self.turn_axes({c: self._angle(c, values[c]) for c in "ABC" if c in values}, alone=alone)

    def _straight(self, values: Mapping[str, Given], end: Vector, feed: float, line: int) -> None:
        if not values.keys().isdisjoint(("I", "J", "K", "CR", "AR", "TURN", "I1", "J1", "K1")):
            raise ValueError("words of an arc in G0 or G1", "They belong to G2, G3 and CIP.")
        before = self.rotary.angles
        moves = not values.keys().isdisjoint(AXES) or "AP" in values or "RP" in values
        if not values.keys().isdisjoint(ROTARY):
            self.turn_to(values, alone=not moves)
        if not values.keys().isdisjoint((*VECTORS, *TURNED)):
            self._point(values)
        time = math.nan
        if self.motion and (self.rotary.used or self.feed.mode == INVERSE_TIME):
            feed, time = self._timed(feed, math.dist(self.at, end), before)
        if moves or not values.keys().isdisjoint((*VECTORS, *TURNED)) or self.rotary.used:
            self.go(RAPID_MARK if self.motion == 0 else CUT_MARK, end, feed, line, time=time)
        elif self.motion:
            raise ValueError(
                "rotary axes turn at a feed, and the machine is not known", "Declare [machine] in the cell."
            )
        else:
            self.track.event(comment_word(self.text), line)

    def _rate(self, values: Mapping[str, Given]) -> float:
        """m/s; NaN where F counts the time of a block."""
        if self.feed.mode == INVERSE_TIME:
            if "F" not in values:
                raise ValueError("a feed F is needed in every block under G93", "Add an F word above 0.")
            return math.nan
        if "FB" in values:
            rate = plain(values, "FB")
            if not rate > 0:
                raise ValueError(f"FB={rate:g}: a feed above 0 is expected")
            return rate * self.feed_unit / 60.0
        return self.feed.rate(self.feed_unit)

    @property
    def feed_unit(self) -> float:
        """m of the length in F: G700 has inch; G71 and G710 mm."""
        return INCH if self.unit == INCH else MM

    def _timed(self, rate: float, length: float, before: tuple[float, ...]) -> tuple[float, float]:
        """Feed m/s, and time s where the feed of the tip follows from it."""
        if self.feed.mode != INVERSE_TIME:
            return rate, self.turning_time(rate, length, before, self.feed.word)
        turns = self.rotary.angles != before and not self.given
        return self.feed.over(length), 60.0 / self.feed.word if turns else math.nan

    def _target(self, values: Mapping[str, Given], unit: float) -> Vector:
        """Where the block leads in the frame in force, m."""
        x, y, z = self.at
        if "X" in values:
            x = self._coordinate(values["X"], x, unit, "X")
        if "Y" in values:
            y = self._coordinate(values["Y"], y, unit, "Y")
        if "Z" in values:
            z = self._coordinate(values["Z"], z, unit, "Z")
        if "AP" in values or "RP" in values:
            return self._polar_end(values, unit, (x, y, z))
        return x, y, z

    def _coordinate(self, given: Given, at: float, unit: float, name: str) -> float:
        if given.__class__ is float and not self.relative:
            self.shifts.named(name)
            return given * unit
        mode, value = given if isinstance(given, tuple) else ("IC" if self.relative else "AC", given)
        if mode not in ("AC", "IC") or isinstance(value, str):
            raise ValueError(f"{name}={mode}(...): AC or IC is expected")
        if mode == "AC":
            self.shifts.named(name)
            return value * unit
        self.shifts.check(name)
        if at != at:
            raise ValueError(f"{name} counts from where the tool is, and that is not known", "Move there in G90 first.")
        return at + value * unit

    def _polar_end(self, values: Mapping[str, Given], unit: float, end: Vector) -> Vector:
        u, v = (self.normal + 1) % 3, (self.normal + 2) % 3
        if "XYZ"[u] in values or "XYZ"[v] in values:
            raise ValueError("AP, RP and X, Y or Z of the plane in one block")
        old = self.polar or (math.nan, math.nan)
        if self.relative and isinstance(values.get("AP"), float):
            raise ValueError("AP under G91", "Write AP=IC(...) or AP=AC(...).")
        angle = self._coordinate(values["AP"], old[0], 1.0, "AP") if "AP" in values else old[0]
        radius = plain(values, "RP") * unit if "RP" in values else old[1]
        if angle != angle or radius != radius:
            raise ValueError("polar words, but AP or RP is not known", "Write both AP= and RP=.")
        self.polar = angle, radius
        self.shifts.named("XYZ"[u])
        self.shifts.named("XYZ"[v])
        place = [*end]
        place[u] = self.pole[0] + radius * math.cos(math.radians(angle))
        place[v] = self.pole[1] + radius * math.sin(math.radians(angle))
        return place[0], place[1], place[2]

    def _angle(self, letter: str, given: Given) -> float:
        """deg that a rotary word leads to; the short way with DC, one way with ACP and ACN."""
        mode, value = given if isinstance(given, tuple) else ("IC" if self.relative else "AC", given)
        if isinstance(value, str):
            raise ValueError(f"{letter}: a number is expected")
        at = self._turned.get(letter, math.nan)
        if mode == "AC":
            return value
        if mode == "IC":
            if at != at:
                raise ValueError(f"{letter} counts from where the axis is, and that is not known")
            return at + value
        if at != at:
            return value
        off = (value - at) % 360.0
        if mode == "ACN":
            return at + off - 360.0 if off else at
        return at + (off - 360.0 if mode == "DC" and off > 180.0 else off)

    def _point(self, values: Mapping[str, Given]) -> None:
        """A3, B3, C3 as vector from the tip to the spindle, or A2, B2, C2 as angles, under TRAORI."""
        if not self.tip:
            raise ValueError("a tool orientation (A3= B3= C3= or A2= B2= C2=) without TRAORI")
        if self.in_machine:
            raise ValueError(
                "a tool orientation under ORIMKS: the axes of the machine are not known", "Post it with ORIWKS."
            )
        if not values.keys().isdisjoint(ROTARY):
            raise ValueError("rotary words and a tool orientation in one block")
        if not values.keys().isdisjoint(VECTORS):
            i, j, k = (plain(values, name) if name in values else 0.0 for name in VECTORS)
            self.point(self.frame.along((i, j, k)))
            return
        if self.angles not in _ANGLES:
            remedy = "Write ORIRPY or ORIEULER before it, or post A3= B3= C3=."
            raise ValueError("A2= B2= C2=: as which angles, is in the machine's data", remedy)
        given = [math.radians(plain(values, name)) if name in values else 0.0 for name in TURNED]
        angles = given if self.angles == "ORIEULER" else given[::-1] if self.angles == "ORIRPY" else given
        turned = PlainFrame.turned(list(zip(_ANGLES[self.angles], angles, strict=True)))
        self.point(self.frame.along(turned.z))

    def _corner(self, values: Mapping[str, Given], unit: float, line: int) -> None:
        for name, kind in CORNERS.items():
            if name in values and (size := plain(values, name)):
                rate = plain(values, "FRC") * self.feed_unit / 60.0 if "FRC" in values else math.nan
                if rate <= 0:
                    raise ValueError("FRC: a feed above 0 is expected")
                self.put_corner(Corner(kind, size * unit, rate, line))


def plain(values: Mapping[str, Given], name: str) -> float:
    """The number of an address that has no mode.

    Raises:
        ValueError: it has one, or is a text.
    """
    value = values.get(name, 0.0)
    if not isinstance(value, float):
        raise ValueError(f"{name}: a plain number is expected")
    return value
