"""CncFeed: the feed of a CNC program: per minute, per turn of the spindle, or inverse to the time of a block."""

from __future__ import annotations

import math

PER_MINUTE, PER_TURN, INVERSE_TIME = "per minute", "per turn", "inverse time"


class CncFeed:
    """F and S in force.

    Attributes:
        mode: PER_MINUTE, PER_TURN or INVERSE_TIME.
        word: F; NaN where none is in force.
        speed: S, 1/min; NaN where none is.
    """

    def __init__(self) -> None:
        self.mode, self.word, self.speed = PER_MINUTE, math.nan, math.nan
        self._last = math.nan

    def give(self, word: float) -> None:
        """F."""
        self.word = word

    def spin(self, speed: float) -> None:
        """S, 1/min."""
        self.speed = speed

    def choose(self, mode: str) -> None:
        """Another way to count; an F from before means something else then."""
        if mode != self.mode:
            self.mode, self.word = mode, math.nan

    def rate(self, unit: float) -> float:
        """m/s of F, where it does not count the time of a block; ``unit``: m of its length unit.

        Raises:
            ValueError: F is missing or not above 0, or S is, where F counts by the turn.
        """
        if not self.word > 0:
            shown = "none is given" if self.word != self.word else f"it is F{self.word:g}"
            raise ValueError(f"a cutting move needs a feed, {shown}", "Add an F word above 0.")
        if self.mode == PER_TURN:
            if not self.speed > 0:
                raise ValueError("the feed is per turn, but no speed S above 0 is in force", "Add an S word.")
            return self.word * unit * self.speed / 60.0
        return self.word * unit / 60.0

    def over(self, length: float) -> float:
        """m/s of a block of ``length`` m that takes 1/F min; one that goes nowhere keeps the last.

        Raises:
            ValueError: F is missing or not above 0.
        """
        share = self.rate(1.0)
        self._last = length * share if length > 0 else self._last if self._last > 0 else 1e-3
        return self._last
