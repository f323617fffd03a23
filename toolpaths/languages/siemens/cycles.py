"""SiemensCycles: frames, tilted planes, the five-axis transformation and drilling cycles of a SINUMERIK program."""

from __future__ import annotations

import math

from toolpaths.languages.siemens.block import Arguments, SiemensBlock
from toolpaths.languages.siemens.drilling import SiemensDrilling, drilling, holes
from toolpaths.languages.siemens.frames import swivel
from toolpaths.languages.siemens.motion import AXES, SiemensMotion, plain
from toolpaths.machine import Machine
from toolpaths.reading.cnc_feed import INVERSE_TIME
from toolpaths.reading.machine_words import stay
from toolpaths.reading.source_text import comment_word
from toolpaths.reading.track import RAPID_MARK


class SiemensCycles(SiemensMotion):
    """Cycles and frames of one file.

    Attributes:
        modal: the drilling cycle that every move calls (MCALL).
    """

    def __init__(self, source: str, machine: Machine | None) -> None:
        super().__init__(source, machine)
        self.modal: SiemensDrilling | None = None

    def _frame(self, word: str, block: SiemensBlock, line: int) -> None:
        if len(block.words) > 1 or block.calls or any(g <= 3 for g in block.gs):
            raise ValueError(f"{word} beside other words; it stands in a block of its own")
        scale = self.scale() if word.endswith("TRANS") else 1.0
        allowed = (*AXES, "RPL") if word.endswith("ROT") else tuple(AXES)
        if strange := block.values.keys() - {*allowed, "F", "S", "T", "D", "H"}:
            raise ValueError(f"{word} with {', '.join(sorted(strange))}")
        self.frames.program(
            word, {c: plain(block.values, c) * scale for c in allowed if c in block.values}, self.normal
        )
        self.put_frame()
        self.track.event(comment_word(self.text), line)

    def _transform(self, line: int) -> None:
        """TRAORI."""
        self.tip = True
        self.track.event("TRAORI", line)

    def _swivel(self, given: Arguments, line: int) -> None:
        to, words = swivel(given, self.unit or self.scale()), comment_word(self.text)
        if self.tip:
            raise ValueError("CYCLE800 under TRAORI", "Write TRAFOOF before it.")
        self.frames.swivel(to)
        frame = self.frames.total()
        if to.level:
            self.end_swivel(frame, words, line, turns=to.turns, keeps=to.follows)
        else:
            self.swivel(frame, words, line, turns=to.turns, keeps=to.follows)

    def cycle(self, name: str, given: Arguments) -> SiemensDrilling:
        """A drilling cycle, with the lengths in m."""
        return drilling(name, given, unit=self.scale(), feed_unit=self.feed_unit, normal=self.normal)

    def _drill(self, cycle: SiemensDrilling, line: int) -> None:
        """One hole where the tool is."""
        self.no_corner()
        if any(v != v for v in self.at):
            raise ValueError(f"{cycle.name}, but where the tool is, is not known", "Name X, Y and Z in G0 first.")
        if self.tip or self.feed.mode == INVERSE_TIME:
            raise ValueError(f"{cycle.name} under {'TRAORI' if self.tip else 'G93'}", "Post its moves.")
        feed = self.feed.rate(self.feed_unit)
        for step in cycle.steps(feed):
            if step.dwell:
                unit = "s" if step.dwell > 0 else "turns"
                self.track.event(f"dwell {abs(step.dwell):g} {unit}", line, stay(self._seconds(step.dwell)))
                continue
            place = [*self.at]
            place[self.normal] = step.height
            if place[self.normal] != self.at[self.normal]:
                rate = math.nan if step.mark == RAPID_MARK else feed if step.feed != step.feed else step.feed
                self.go(step.mark, (place[0], place[1], place[2]), rate, line)

    def _seconds(self, dwell: float) -> float:
        """s of a stay; below 0 it counts turns of the spindle."""
        turn = 60.0 / self.feed.speed if self.feed.speed > 0 else 0.0
        return dwell if dwell > 0 else -dwell * turn

    def _pattern(self, name: str, given: Arguments, line: int) -> None:
        if self.modal is None:
            raise ValueError(f"{name} without a drilling cycle called by MCALL")
        for u, v in holes(name, given, self.scale()):
            place = [*self.at]
            place[(self.normal + 1) % 3], place[(self.normal + 2) % 3] = u, v
            self.go(RAPID_MARK, (place[0], place[1], place[2]), math.nan, line)
            self._drill(self.modal, line)
