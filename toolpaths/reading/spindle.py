"""SpindleTrack: how the spindle turns along the moves of one file, as its words leave it."""

from __future__ import annotations

import math
from array import array

import numpy as np

from toolpaths.toolpath import SENSE_OPEN, Floats, Senses


class SpindleTrack:
    """Speed and sense in force while a file is read; a word holds from the next move on.

    Attributes:
        speed: as the file last gave it, rad/s; NaN where it gives none.
        sense: as in ``Toolpath.sense``.
        stands: the file has stopped the spindle.
    """

    def __init__(self) -> None:
        self.speed = math.nan
        self.sense = int(SENSE_OPEN)
        self.stands = False
        self._from = array("q")
        self._speeds, self._senses = array("d", [math.nan]), array("b", [self.sense])

    @property
    def rpm(self) -> float:
        """The speed in 1/min, NaN where the file gives none."""
        return self.speed * 60.0 / math.tau

    @property
    def turns(self) -> bool:
        """Whether the file has it turning."""
        return self.sense != SENSE_OPEN and not self.stands

    def say(self, rpm: float, move: int) -> None:
        """A speed, 1/min, NaN where what the file gives is none; ``move``: how many moves stand before the word."""
        self.speed = rpm * math.tau / 60.0
        self._note(move)

    def turn(self, sense: int, move: int) -> None:
        """It turns in this sense."""
        self.sense, self.stands = sense, False
        self._note(move)

    def stop(self, move: int) -> None:
        """It stands; speed and sense stay what they were for when it turns again."""
        self.stands = True
        self._note(move)

    def columns(self, moves: int) -> tuple[Floats, Senses]:
        """``Toolpath.spindle`` and ``Toolpath.sense`` of so many moves."""
        row = np.searchsorted(np.frombuffer(self._from, dtype=np.int64), np.arange(moves), side="right")
        return np.array(self._speeds)[row], np.array(self._senses, dtype=np.int8)[row]

    def _note(self, move: int) -> None:
        self._from.append(move)
        self._speeds.append(0.0 if self.stands else self.speed)
        self._senses.append(self.sense)
