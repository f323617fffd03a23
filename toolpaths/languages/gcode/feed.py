"""F words: per minute (G94), per revolution (G95), or the inverse of the time of a block (G93)."""

from __future__ import annotations

from toolpaths.languages.gcode.codes import G

REMEDY = "Add an F word above 0."


class GcodeFeed:
    """F and S as written, and how F is meant.

    Attributes:
        mode: G93, G94 or G95.
        word: the F in force; None where none is.
        speed: the S in force, 1/min.
    """

    def __init__(self) -> None:
        self.mode = G.PER_MINUTE
        self.word: float | None = None
        self.speed: float | None = None
        self._last = 0.0

    def choose(self, mode: G) -> None:
        """Take over G93, G94 or G95; an F from before means something else then."""
        if mode != self.mode:
            self.mode, self.word = mode, None

    def say(self, word: float) -> None:
        """An F."""
        self.word = word

    def forget(self) -> None:
        """What the F in force means is not known any more."""
        self.word = None

    def turn(self, speed: float) -> None:
        """An S."""
        self.speed = speed

    def rate(self, unit: float, given: bool, motion: G) -> float:
        """What the F stands for: m/s, or in G93 the share of the way per second.

        Args:
            unit: m of one length unit of the file.
            given: whether the F stands in this block.
            motion: for messages.

        Raises:
            ValueError: F is missing or not above 0, or S is, under G95.
        """
        word = self.word
        if self.mode is G.INVERSE_TIME and not given:
            raise ValueError(f"{motion.word} needs a feed in every block under G93, none is given", REMEDY)
        if word is None or word <= 0:
            shown = "none is given" if word is None else f"it is F{word:g}"
            raise ValueError(f"{motion.word} needs a feed, {shown}", REMEDY)
        if self.mode is G.INVERSE_TIME:
            return word / 60.0
        if self.mode is G.PER_TURN:
            if not self.speed or self.speed < 0:
                raise ValueError(f"{motion.word} needs an S above 0: its feed is per revolution (G95)")
            return word * unit * self.speed / 60.0
        return word * unit / 60.0

    def over(self, length: float, rate: float) -> float:
        """m/s of a G93 block of this length, m; where it stands still the speed of the last one."""
        self._last = length * rate or self._last or 1e-3
        return self._last
