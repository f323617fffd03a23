"""DrilledHoles: blocks of canned cycles as moves, with what the spindle does in the hole."""

from __future__ import annotations

from dataclasses import replace

from toolpaths.languages.gcode.codes import SPINDLE_CYCLES, G
from toolpaths.languages.gcode.machine_words import SENSES, turning
from toolpaths.languages.gcode.modal_state import UP
from toolpaths.languages.gcode.placed_moves import PlacedMoves
from toolpaths.languages.gcode.words import Words
from toolpaths.reading.track import CUT_MARK
from toolpaths.toolpath import MachineCommand

_DWELLING = SPINDLE_CYCLES | {G.DRILLING_WITH_DWELL}
_TURNED = frozenset((G.TAPPING, G.BORING_WITH_STOP))


class DrilledHoles(PlacedMoves):
    """The moves of one file, those of cycles included."""

    def drill(self, key: G, values: Words, line: int) -> None:
        """A block of a canned cycle."""
        self.refuse_open("a canned cycle")
        if values.keys().isdisjoint("XYZ"):
            raise ValueError("words of a canned cycle, but no X, Y or Z")
        if not values.keys().isdisjoint("IJABC") or self.axis != UP or any(self.rotary.angles):
            raise ValueError("a canned cycle with rotary axes, tool vectors, I or J", "Post it expanded.")
        if any(v != v for v in self.at):
            raise ValueError("a canned cycle, but where it starts is not known", "Name X, Y and Z in G0 first.")
        if self.feed.mode is G.INVERSE_TIME:
            raise ValueError("a canned cycle in G93", "Post it with G94.")
        unit, shift = self.scale(), self.shift_in_force()
        offset = dict(zip("XYZ", (0.0, 0.0, 0.0) if self.relative else shift, strict=True))
        offset["R"] = offset["XYZ"[self.normal]]
        words = {c: v * (1.0 if c in "KLP" else unit) + offset.get(c, 0.0) for c, v in values.items()}
        steps = self.cycle.steps(key, words, at=self.at, normal=self.normal, relative=self.relative, back=self.back)
        feed = self.feed.rate(unit, True, G.LINE)
        sense = next((m for m, turned in SENSES.items() if turned == self.track.spindle.sense), 3)
        inside = False
        for kind, place in steps:
            if place != self.at:
                move = self.rapid(place, line)
                self.place(replace(move, mark=kind, feed=feed) if kind == CUT_MARK else move)
                self.at = place
            if key in _DWELLING:
                inside = self._in_hole(key, line, sense=sense, cut=kind == CUT_MARK, inside=inside)

    def _in_hole(self, key: G, line: int, *, sense: int, cut: bool, inside: bool) -> bool:
        """What the cycle asks of the machine behind a move; whether the tool is at the bottom now.

        ``sense``: 3 or 4, as M has it: how the spindle turns outside the hole; 3 where the file does not say.
        """
        if inside and key in _TURNED:
            self._turn(sense, line)
        if inside or not cut:
            return False
        if dwell := self.cycle.dwell:
            self.track.event(f"G4 P{dwell:g}", line, MachineCommand("G4", {"P": dwell}))
        if key is G.TAPPING:
            self._turn(7 - sense, line)
        elif key is G.BORING_WITH_STOP:
            self.track.spindle.stop(len(self.track))
            self.track.event("M5", line, MachineCommand("M5"))
        return True

    def _turn(self, m: int, line: int) -> None:
        self.track.spindle.turn(SENSES[m], len(self.track))
        self.track.event(f"M{m}", line, turning(m, self.feed.speed))
