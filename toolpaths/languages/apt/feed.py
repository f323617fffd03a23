"""Length unit, feed and spindle speed of an APT/CL file: how fast the next cut is."""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpaths.errors import ReadError
from toolpaths.languages.apt.words import INCH, MM, UNIT_WORDS, AptStatement, number, refusal
from toolpaths.reading.spindle import SpindleTrack
from toolpaths.toolpath import CLOCKWISE, COUNTERCLOCKWISE

FEED_WORDS: dict[str, tuple[float | None, bool]] = {  # m of the length unit (None: of UNITS), per revolution?
    "MMPM": (MM, False),
    "MMPR": (MM, True),
    "IPM": (INCH, False),
    "IPR": (INCH, True),
    "PERMIN": (None, False),
    "PERREV": (None, True),
}
_SURFACE = {"SFM", "SMM", "SURFACE"}
_SENSES = {"CLW": int(CLOCKWISE), "CCLW": int(COUNTERCLOCKWISE)}
_STANDS = {"OFF", "LOCK", "ORIENT", "NEUTRL"}
_OTHER_NUMBERS = {"RANGE", "MAXRPM", "RADIUS"}  # words of SPINDL whose number is not the speed


class FeedRate(NamedTuple):
    """A feed: m/min, or m per revolution."""

    value: float
    per_turn: bool


class AptFeeds:
    """Units, feed and speed in force while a file is read."""

    def __init__(self, source: str, spindle: SpindleTrack) -> None:
        self.source, self._spindle = source, spindle
        self.unit: float | None = None  # m, from UNITS
        self.told: dict[float, int] = {}  # m, line: length units that feeds are given in
        self.rate = FeedRate(math.nan, False)

    def units(self, s: AptStatement, *, poses: bool) -> None:
        """UNITS/MM or UNITS/INCHES, once, before the first of the ``poses``."""
        unit = UNIT_WORDS.get(s.minor[0]) if len(s.minor) == 1 else None
        if unit is None:
            raise refusal(self.source, s, "MM or INCHES is expected")
        if self.unit not in (None, unit) or (self.unit is None and poses):
            raise refusal(self.source, s, "the unit changes within the file", "Give one unit, before the first GOTO.")
        self.unit = unit

    def scale(self) -> float:
        """m of the file's length unit, from UNITS or from what the feeds are given in."""
        if self.unit is not None:
            return self.unit
        if len(self.told) == 1:
            return next(iter(self.told))
        problem = "no units: neither UNITS/MM nor UNITS/INCHES, and no feed with MMPM or IPM that tells"
        if self.told:
            problem = "no units: UNITS is missing, and feeds are in mm (MMPM) as well as in inch (IPM)"
        raise ReadError(self.source, None, problem, "Write UNITS/MM or UNITS/INCHES on the first line.")

    def feedrate(self, s: AptStatement) -> None:
        """FEDRAT: a number and, before or after it, its unit."""
        values = [v for v in map(number, s.minor) if v is not None]
        words = [m for m in s.minor if number(m) is None]
        if len(values) != 1 or len(words) > 1 or not all(w in FEED_WORDS for w in words):
            raise refusal(self.source, s, f"one number and one of {', '.join(FEED_WORDS)} are expected")
        if not words and self.rate.per_turn:
            raise refusal(self.source, s, "no unit, after a feed per revolution", "Add MMPM, MMPR, IPM or IPR.")
        self.rate = self.rate_of(s, values[0], words[0] if words else "PERMIN")

    def rate_of(self, s: AptStatement, value: float, word: str) -> FeedRate:
        """The feed ``value`` in the unit ``word``."""
        if not 0 < value < 1e9:
            raise refusal(self.source, s, "a feed above 0 is expected")
        length, per_turn = FEED_WORDS[word]
        if length is not None:
            self.told.setdefault(length, s.line)
        elif (length := self.unit) is None:
            problem = "a feed without unit, and no UNITS before it"
            raise refusal(self.source, s, problem, "Write UNITS/MM or UNITS/INCHES on top.")
        return FeedRate(value * length, per_turn)

    def spindle(self, s: AptStatement, moves: int) -> None:
        """SPINDL with the speed in rev/min, its sense, ON, OFF; a cutting speed leaves the rev/min unknown.

        Args:
            moves: how many stand before it.
        """
        minor = s.minor
        values = [
            v for before, m in zip(["", *minor], minor, strict=False)
            if before not in _OTHER_NUMBERS and (v := number(m)) is not None
        ]  # fmt: skip
        if values or _SURFACE & set(minor):
            known = values and 0 < values[0] < 1e9 and not _SURFACE & set(minor)
            self._spindle.say(values[0] if known else math.nan, moves)
        senses = [sense for word, sense in _SENSES.items() if word in minor]
        if not _STANDS.isdisjoint(minor):
            self._spindle.stop(moves)
        else:
            self._spindle.turn(senses[0] if senses else self._spindle.sense, moves)

    def now(self, s: AptStatement, rate: FeedRate | None = None) -> float:
        """m/s of ``rate``, or of the feed in force; NaN where the file gave none."""
        value, per_turn = rate or self.rate
        if not per_turn:
            return value / 60.0
        speed = self._spindle.speed
        if self._spindle.stands or not speed > 0:
            problem = "the feed is per revolution, but no speed in RPM is in force"
            raise refusal(self.source, s, problem, "Add SPINDL/RPM,n.")
        return value * speed / math.tau
