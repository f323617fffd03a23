"""Canned drilling cycles G73, G81 to G86, G89 as the moves they stand for.

Order of the moves, sticky words and the chip clearance: LinuxCNC G-code reference, "Canned Cycles".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from toolpaths.frame import Vector
from toolpaths.languages.gcode.codes import G
from toolpaths.reading.track import CUT_MARK, RAPID_MARK

CLEARANCE = 0.254e-3  # m: how far G73 draws back, and how near G83 comes back to the bottom at a rapid
MOST_STEPS = 2000  # moves of one block: more is a mistake, and would fill the memory
CycleMove = tuple[int, Vector]  # kind, place


class CannedCycle:
    """The cycle in force, its sticky words, and the level where the series of holes began."""

    def __init__(self) -> None:
        self.key: G | None = None
        self._words: dict[str, float] = {}
        self._level = 0.0
        self._normal = 2

    @property
    def dwell(self) -> float | None:
        """P of a cycle that waits at the bottom of each hole, as the file has it."""
        return self._words.get("P")

    def end(self) -> None:
        """Another motion word ends the series."""
        self.key = None

    def forget(self) -> None:
        """Units or distance mode changed: depth and retract plane have to be named again."""
        self._words.clear()

    def steps(
        self, key: G, words: Mapping[str, float], at: Vector, normal: int, relative: bool, back: bool
    ) -> Iterator[CycleMove]:
        """The moves of one block.

        Args:
            key: the word of the cycle.
            words: X, Y, Z, R, Q in m, P, and L or K (repetitions).
            at: where the tool is, m.
            normal: 0, 1, 2: the axis that it drills along.
            relative: G91.
            back: G98, retract to the level where the series began; else to R.

        Raises:
            ValueError: a word is missing or makes no sense.
        """
        if self.key is None:
            self._level, self._normal = at[normal], normal
        elif self._normal != normal:
            raise ValueError("the plane changes inside a canned cycle; end it with G80 first")
        if key != self.key:
            self.key = key
            self._words.clear()
        self._words.update({k: words[k] for k in ("XYZ"[normal], "R", "Q", "P") if k in words})
        r, bottom = self._needed("R"), self._needed("XYZ"[normal])
        if relative:
            r += self._level
            bottom += r
        if r < bottom:
            raise ValueError(f"R lies below the bottom of the hole ({r * 1e3:g} and {bottom * 1e3:g} mm)")
        hole = list(self._hole(r, bottom))
        repeats = self._repeats(words, len(hole) + 4)
        return self._all(
            words, at=at, heights=(self._level, r), hole=hole, repeats=repeats, relative=relative, back=back
        )

    def _needed(self, letter: str) -> float:
        if letter not in self._words:
            raise ValueError(
                f"the canned cycle needs {letter}; name it again after another cycle word, G20/21 or G90/91"
            )
        return self._words[letter]

    def _repeats(self, words: Mapping[str, float], moves: int) -> int:
        if "L" in words and "K" in words:
            raise ValueError("both L and K repeat the cycle")
        repeats = words.get("L", words.get("K", 1.0))
        if repeats != int(repeats) or repeats < 1:
            raise ValueError(f"{repeats:g} repetitions: a whole number from 1 on is expected")
        if repeats * moves > MOST_STEPS:
            raise ValueError(f"one block makes {repeats * moves:g} moves, at most {MOST_STEPS}")
        return int(repeats)

    def _hole(self, r: float, bottom: float) -> Iterator[tuple[int, float]]:
        """Kind and height of the moves inside one hole."""
        if self.key in (G.CHIP_BREAKING, G.PECKING):
            peck = self._needed("Q")
            if peck <= 0 or (r - bottom) / peck > MOST_STEPS:
                raise ValueError(f"Q{peck * 1e3:g} mm for a hole of {(r - bottom) * 1e3:g} mm")
            depth = r - peck
            while depth > bottom:
                yield CUT_MARK, depth
                if self.key is G.PECKING:
                    yield RAPID_MARK, r
                yield RAPID_MARK, depth + CLEARANCE
                depth -= peck
        yield CUT_MARK, bottom

    def _all(
        self,
        words: Mapping[str, float],
        at: Vector,
        heights: tuple[float, float],
        hole: list[tuple[int, float]],
        repeats: int,
        relative: bool,
        back: bool,
    ) -> Iterator[CycleMove]:
        normal, here = self._normal, list(at)
        initial, r = heights
        # the level of the way to the hole: as it is where that is above R
        level = here[normal] if here[normal] > r else initial if back else r
        if initial < r:
            level = here[normal] = r
            yield RAPID_MARK, (here[0], here[1], here[2])
        clear = max(initial, r) if back else r
        out = [(CUT_MARK, r)] if self.key in (G.BORING, G.TAPPING, G.BORING_WITH_DWELL) else []
        for _ in range(repeats):
            for k in ((normal + 1) % 3, (normal + 2) % 3):
                value = words.get("XYZ"[k], 0.0 if relative else here[k])
                here[k] = here[k] + value if relative else value
            for kind, height in ((RAPID_MARK, level), (RAPID_MARK, r), *hole, *out, (RAPID_MARK, clear)):
                here[normal] = height
                yield kind, (here[0], here[1], here[2])
            level = clear
