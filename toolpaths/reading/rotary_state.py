"""Rotary words of a CNC program: where the axes stand, move by move."""

from __future__ import annotations

import math
from array import array
from collections.abc import Collection, Mapping

import numpy as np

from toolpaths.machine import Machine
from toolpaths.reading.rotary import RotaryTrace, in_work
from toolpaths.toolpath import Toolpath


class RotaryState:
    """The rotary axes of one file.

    Args:
        machine: what the file was posted for.
        tip_word: the word of the language for tool centre point control, and with vectors, for messages.

    Attributes:
        used: the file has rotary words.
        angles: rad, nan where not known.
    """

    def __init__(self, machine: Machine | None, tip_word: tuple[str, str] = ("G43.4", "G43.4 I J K")) -> None:
        self.machine, self._tip_word = machine, tip_word
        self.letters = machine.letters if machine else ""
        self.used = False
        self.angles: tuple[float, ...] = ()
        self._turns, self._tips, self._times = array("d"), array("b"), array("d")
        self._given = array("b")

    def use(self, moves: int = 0) -> None:
        """The file has rotary words: before the first, where the axes stand is not known; ``moves`` came before it."""
        self.used = True
        self.angles = (math.nan,) * len(self.letters)
        for _ in range(moves):
            self.note(False, math.nan, given=True)

    def check(self, values: Mapping[str, float]) -> None:
        """Rotary words need a machine that has the axis.

        Raises:
            ValueError: names the word.
        """
        for c in "ABC":
            if c in values and c not in self.letters:
                what = "the machine has no such axis" if self.letters else "the machine's kinematics is not known"
                remedy = f"Declare [machine] in the cell, or post tool vectors ({self._tip_word[1]}) or APT/CL."
                raise ValueError(f"{c}{values[c]:g}: a rotary axis: {what}", remedy)

    def go(self, values: Mapping[str, float], relative: bool, tip: bool) -> None:
        """Take over A, B, C (deg); ``tip``: tool centre point control is on.

        Raises:
            ValueError: the machine has no such axis, or too little of it is known.
        """
        self.check(values)
        self.angles = tuple(
            math.radians(values[c]) + (v if relative else 0.0) if c in values else v
            for c, v in zip(self.letters, self.angles, strict=True)
        )
        if not tip and self.machine and (missing := self.machine.missing()):
            word = self._tip_word[0]
            problem = f"rotary moves without {word}, and the {missing} of the machine is not known"
            raise ValueError(problem, f"Post with {word}, or complete [machine] in the cell.")

    def lose(self, axes: Collection[str]) -> None:
        """A retract moved these axes, or all where it names none, to a place of the machine."""
        if self.used:
            self.angles = tuple(
                math.nan if not axes or c in axes else v for c, v in zip(self.letters, self.angles, strict=True)
            )

    def zero(self) -> None:
        """All axes go back to 0."""
        self.angles = (0.0,) * len(self.letters) if self.used else ()

    def lost(self) -> bool:
        """Whether the file has rotary words, and where an axis stands is not known."""
        return self.used and any(v != v for v in self.angles)

    def note(self, tip: bool, time: float, given: bool = False) -> None:
        """A move ends here; see RotaryTrace."""
        self._turns.extend(self.angles)
        self._tips.append(tip)
        self._times.append(time)
        self._given.append(given)

    def in_work(self, path: Toolpath, chord: float) -> Toolpath:
        """The poses in the work object of those as programmed."""
        if not self.used or self.machine is None:
            return path
        turns = RotaryTrace(
            np.frombuffer(self._turns, dtype=np.float64).reshape(len(self._tips), -1),
            np.frombuffer(self._tips, dtype=np.int8).astype(np.bool_),
            np.frombuffer(self._times, dtype=np.float64),
            np.frombuffer(self._given, dtype=np.int8).astype(np.bool_),
        )
        return in_work(path, self.machine, turns, chord)
