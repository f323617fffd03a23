"""Where a rewritten G-code file has the tool, and the words that bring it elsewhere."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from toolpaths.languages.gcode.motion import MovedBlock
from toolpaths.languages.gcode.reader import INCH
from toolpaths.languages.gcode.spelling import VECTOR_DIGITS, GcodeSpelling, GcodeWord
from toolpaths.rewriting.filter import SAME_PLACE
from toolpaths.writing.program import Floats

TILT = 1e-6  # rad: tilts below it are none
UP = np.array([0.0, 0.0, 1.0])
NOTHING: Mapping[str, str] = MappingProxyType({})


class ToolPlace:
    """Place and vector of the tool as the lines written so far leave them.

    Attributes:
        at: x, y, z m in the work object, nan where not known; plain numbers, there is one for every line.
        vector: (3,) from the tip to the spindle.
    """

    def __init__(self, spelling: GcodeSpelling) -> None:
        self.spelling = spelling
        self.at: Sequence[float] = (math.nan, math.nan, math.nan)
        self.vector = UP

    def go(self, to: Sequence[float]) -> None:
        """The lines written so far lead there."""
        self.at = to

    def after(self, step: MovedBlock, words: list[GcodeWord], new: Mapping[str, str] = NOTHING) -> list[float]:
        """Where a line with these words, and ``new`` numbers for some, leads from where the rewritten file is."""
        out = list(self.at)
        for w in words:
            if (k := "XYZ".find(w.letter)) >= 0 and w.letter not in new:
                out[k] = w.value * step.unit + (self.at[k] if step.relative else step.shift[k])
        for letter, number in new.items():
            if (k := "XYZ".find(letter)) >= 0:
                out[k] = float(number) * step.unit + (self.at[k] if step.relative else step.shift[k])
        return out

    def coordinates(
        self, step: MovedBlock, now: Sequence[float], to: Sequence[float], *, at_least_one: bool = False
    ) -> dict[str, str]:
        """The numbers that bring the tool to ``to`` where the line alone brings it to ``now``."""
        inch = step.unit == INCH
        new = {}
        for k, letter in enumerate("XYZ"):
            if abs(now[k] - to[k]) <= SAME_PLACE:
                continue
            from_ = self.at[k] if step.relative else step.shift[k]
            text = self.spelling.number((to[k] - from_) / step.unit, inch)
            if not abs(float(text) * step.unit + from_ - now[k]) <= 1e-9:
                new[letter] = text
        if at_least_one and not new:
            k = next((k for k in range(3) if self.at[k] == self.at[k]), 0)
            value = 0.0 if step.relative else (to[k] - step.shift[k]) / step.unit
            new["XYZ"[k]] = self.spelling.number(value, inch)
        return new

    def named(
        self, words: list[GcodeWord], nominal: Sequence[float], shift: Sequence[float], unit: float
    ) -> dict[str, str]:
        """The numbers of a G92 that keep the origin: ``nominal`` is where the file has the tool.

        An axis whose place was not known is where G92 puts it, with ``shift`` as after it.
        """
        new, at = {}, list(self.at)
        for w in words:
            k = "XYZ".find(w.letter)
            if k < 0:
                continue
            off = self.at[k] - nominal[k]
            if off != off:
                at[k] = w.value * unit + shift[k]
            elif abs(off) > 1e-9:
                exact = w.value + off / unit
                texts = (self.spelling.number(exact, unit == INCH, digits) for digits in (None, 6, 7))
                new[w.letter] = next((t for t in texts if abs(float(t) - exact) * unit < 1e-9), f"{exact:.8f}")
        self.at = at
        return new

    def tool_vector(self, axis: Floats, words: list[GcodeWord]) -> dict[str, str]:
        """I, J, K of a tool vector, all three where they differ from what is in force or stands there."""
        self.turn(words)
        if np.abs(axis - self.vector).max() <= TILT:
            return {}
        self.vector = np.round(axis, VECTOR_DIGITS)
        return {c: self.spelling.number(float(v), False, VECTOR_DIGITS) for c, v in zip("IJK", axis, strict=True)}

    def turn(self, words: list[GcodeWord]) -> None:
        """Take over a tool vector as the reader does: what is left out beside another is 0."""
        given = {w.letter: w.value for w in words if w.letter in "IJK"}
        if given:
            vector = np.array([given.get(c, 0.0) for c in "IJK"])
            self.vector = vector / np.linalg.norm(vector)
