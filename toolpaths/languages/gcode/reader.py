"""G-code (RS-274, Fanuc dialect): lines, arcs, drilling cycles, shifts of the origin, tool vectors, rotary axes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.languages.gcode.codes import (
    ARCS,
    CYCLES,
    FEED_MODES,
    GROUP,
    LONE,
    MOTIONS,
    RETRACTS,
    RETURNS,
    SINGLE,
    SYSTEMS,
    TIP_CONTROLS,
    G,
)
from toolpaths.languages.gcode.motion import GcodeMotion
from toolpaths.languages.gcode.retract import Retract, check_clearances, check_retracts
from toolpaths.languages.gcode.words import M_END, Words, prints_refused, split_block, strip_comments
from toolpaths.machine import Machine
from toolpaths.reading.source_text import comment_word, load_lines
from toolpaths.toolpath import CLOCKWISE, COUNTERCLOCKWISE, MachineCommand, Toolpath

MM, INCH = 1e-3, 25.4e-3
PLANES = {G.PLANE_XY: 2, G.PLANE_ZX: 1, G.PLANE_YZ: 0}  # index of the axis normal to the plane
MOVING = frozenset("XYZIJKRABC")
ALLOWED = frozenset("XYZIJKRFSTNHPQOLABC")
TOOL_CHANGE = re.compile(r"[Mm]\s*0*6(?![0-9.])")
COLON = re.compile(r"^\s*:(?=\s*\d)")  # the number of a program in ISO code
ROTARY = re.compile(r"[ABCabc]\s*[-+.\d]")
LENGTHS = TIP_CONTROLS | {G.TOOL_LENGTH, G.TOOL_LENGTH_OFF}
WITH_P = frozenset((G.BLENDING, G.SYSTEM_MORE, G.SMOOTHING_LEVEL, G.LOOK_AHEAD, G.ACCURACY))
WITH_Q = frozenset((G.BLENDING, G.SMOOTHING))
SENSES = {3: int(CLOCKWISE), 4: int(COUNTERCLOCKWISE)}
SPINDLE_STOPS = frozenset((5, 6, 19))  # it stands for a tool change and where it is oriented, too, as LinuxCNC has it


def read(path: Path, source: str, chord: float, machine: Machine | None = None) -> Toolpath:
    """Poses of a G-code file in its coordinate system.

    Args:
        path: the file.
        source: its name in messages.
        chord: m, how far chords may lie from arcs.
        machine: what a file with rotary words (A, B, C), or with several coordinate systems, was posted for.

    Raises:
        ReadError: a line is refused.
    """
    return parse(load_lines(path, source), source, machine).toolpath(chord)


def parse(lines: list[str], source: str, machine: Machine | None = None, *, trace: bool = False) -> BlockReader:
    """The blocks of a file, read."""
    blocks = BlockReader(source, machine, trace=trace)
    with prints_refused(lines, source):
        blocks.read(lines)
    return blocks


class BlockReader:
    """Reads the blocks of one file, one after the other."""

    def __init__(self, source: str, machine: Machine | None, *, trace: bool = False) -> None:
        self.source = source
        self.state = GcodeMotion(source, machine, trace=trace)
        self.track, self.start = self.state.track, self.state.at
        self.percent = self.ended = False
        self.selected = 0
        self.changes = False  # does an M6 stand in the file? then T only selects
        self.retracts: list[Retract] = []

    def read(self, lines: list[str]) -> None:
        """Read every block."""
        self.changes = _stands_in(TOOL_CHANGE, lines)
        if self.state.rotary.letters and _stands_in(ROTARY, lines):
            self.state.rotary.use()
        for line, text in enumerate(lines, 1):
            if text and not text.isspace():
                self._line(text, line)
        self._check_end(lines)

    def toolpath(self, chord: float) -> Toolpath:
        """The poses."""
        path = self.state.toolpath(chord)
        check_retracts(path, self.retracts)
        check_clearances(path, self.state.clearances)
        return path

    def _line(self, text: str, line: int) -> None:
        if "(" in text or ";" in text:
            text, comments = strip_comments(text)
            for comment in comments:
                self.track.event(comment_word(comment), line)
        if text.strip() == "%":
            self._percent(line)
            return
        if ":" in text:
            text = COLON.sub("O", text)
        values, gs, ms = split_block(text.upper().rstrip(), self.source, line)
        if not (values or gs or ms):
            return
        if self.ended:
            problem = "words after the end of the program"
            raise self._error(line, problem, "Two programs in one file? Give one file each.")
        try:
            self._block(values, gs, ms, line)
        except ValueError as problem:
            raise self._error(line, *map(str, problem.args[:2])) from None

    def _percent(self, line: int) -> None:
        if self.percent or self.ended:
            self.ended = True
        elif len(self.track) or self.state.unit:
            raise self._error(line, "'%' in the middle of the program", "Is the head of the file missing?")
        self.percent = True

    def _block(self, values: Words, gs: list[G], ms: list[int], line: int) -> None:
        state = self.state
        if not values.keys() <= ALLOWED:
            letter = next(c for c in values if c not in ALLOWED)
            raise ValueError(f"{letter}{values[letter]:g}: this reader does not know it")
        single = None
        if gs:
            _check_groups(gs)
            for g in gs:
                if g in FEED_MODES:
                    state.feed.choose(g)
        if "F" in values:
            state.feed.say(values["F"])
        if ms or not values.keys().isdisjoint("STO"):
            self._events(values, ms, line)
        if gs:
            single = self._modes(gs, values)
            _check_lone(gs, values)
        _check_letters(values, gs, single, state.motion or G.RAPID)
        if single is not None:
            self._single(single, values, line)
        elif not values.keys().isdisjoint(MOVING):
            state.move(values, line)
        if any(m in M_END for m in ms):
            self.track.event(f"M{next(m for m in ms if m in M_END)}", line)
            self.ended = True

    def _modes(self, gs: list[G], values: Words) -> G | None:
        """Take over the modal words; the non-modal one is returned."""
        state, single = self.state, None
        if G.CYCLE_OFF in gs:
            state.choose_motion(None)
        for g in gs:
            if g in MOTIONS:
                state.choose_motion(g)
            elif g in PLANES:
                state.choose_plane(PLANES[g])
            elif g is G.INCH or g is G.MM:
                state.choose_units(INCH if g is G.INCH else MM, "F" in values)
            elif g is G.ABSOLUTE or g is G.RELATIVE:
                state.choose_distance(relative=g is G.RELATIVE)
            elif g is G.ABSOLUTE_CENTRE or g is G.RELATIVE_CENTRE:
                state.choose_centre(absolute=g is G.ABSOLUTE_CENTRE)
            elif g in RETURNS:
                state.choose_return(to_start=g is G.RETURN_TO_START)
            elif g in SYSTEMS:
                state.choose_system(f"{g.word} P{values.get('P', 1):g}" if g is G.SYSTEM_MORE else g.word)
            elif g in LENGTHS:
                state.choose_length(g)
            elif g in SINGLE:
                single = g
        return single

    def _single(self, single: G, values: Words, line: int) -> None:
        """A word that counts in its block only."""
        if single is G.DWELL:
            if "P" in values and not values.keys().isdisjoint(MOVING):
                raise ValueError("G4 with P and coordinates; put the dwell into a block of its own")
            if not values.keys().isdisjoint(MOVING - {"X"}):
                raise ValueError("G4 with coordinates; put the dwell into a block of its own")
            dwell = values.get("P", values.get("X", 0.0))
            self.track.event(f"G4 P{dwell:g}", line, MachineCommand("G4", {"P": dwell}))
        elif single in RETRACTS:
            words = self.state.retract(single, values)
            self.track.event(words, line)
            self.retracts.append(Retract(len(self.track), line, words))
        else:
            self.state.shift(single, values)
            axes = [f"{a}{values[a]:g}" for a in "XYZ" if a in values]
            self.track.event(" ".join([single.word, *axes]), line)

    def _events(self, values: Words, ms: list[int], line: int) -> None:
        words = []
        if "O" in values:
            if len(self.track) or self.state.unit:
                raise ValueError(f"O{values['O']:g}: a second program", "Give one file each.")
            words.append(f"O{values['O']:g}")
        if "T" in values:
            self.selected = _tool_number(values["T"])
            words.append(f"T{self.selected}")
            if not self.changes:
                self.state.choose_tool(self.selected)
        if "S" in values:
            self.state.feed.turn(values["S"])
            self.track.spindle.say(values["S"], len(self.track))
            words.append(f"S{values['S']:g}")
        if 6 in ms:
            self.state.choose_tool(self.selected)
        if not SPINDLE_STOPS.isdisjoint(ms):
            self.track.spindle.stop(len(self.track))
        for m in SENSES.keys() & ms:
            self.track.spindle.turn(SENSES[m], len(self.track))
        words += [f"M{m}" for m in ms if m not in M_END]
        if words:
            self.track.event(" ".join(words), line, *self._commands(values, ms))

    def _commands(self, values: Words, ms: list[int]) -> Iterator[MachineCommand]:
        """What the words of a block ask of the machine, in the order of RS-274: tool, spindle, the rest, halts."""
        spindle = self.track.spindle
        if "T" in values or 6 in ms:
            mounted = 6 in ms or not self.changes
            yield MachineCommand("M6" if mounted else "T", {"T": float(self.selected)})
        turning = [m for m in ms if m in SENSES] or [m for m, sense in SENSES.items() if sense == spindle.sense]
        if turning and (not SENSES.keys().isdisjoint(ms) or ("S" in values and spindle.turns)):
            speed = self.state.feed.speed
            yield MachineCommand(f"M{turning[0]}", {} if speed is None else {"S": speed})
        rest = [m for m in ms if m not in (*M_END, 6, *SENSES)]
        yield from (MachineCommand(f"M{m}") for m in sorted(rest, key=lambda m: m in (0, 1)))

    def _check_end(self, lines: list[str]) -> None:
        if self.ended:
            return
        why = ""
        if self.percent:
            why = "it begins with '%' but does not end with one"
        elif self.track.spindle.turns:
            why = "it ends without M2, M30 or M5 while the spindle turns"
        elif lines[-1].strip():
            why = "it ends without M2 or M30, and without a line end"
        if why:
            problem = f"the file looks cut off: {why}"
            raise self._error(len(lines), problem, "Add M30 if it is complete.")

    def _error(self, line: int, problem: str, remedy: str = "") -> ReadError:
        return ReadError(self.source, line, problem, remedy)


def _stands_in(word: re.Pattern[str], lines: list[str]) -> bool:
    """Whether a word stands in a line outside comments."""
    return any(word.search(strip_comments(s)[0]) for s in lines if word.search(s))


def _check_groups(gs: list[G]) -> None:
    names = [GROUP[g] for g in gs]
    for name in names:
        if names.count(name) > 1:
            words = " ".join(g.word for g in gs if GROUP[g] == name)
            raise ValueError(f"{words}: two words for {name} in one block")


def _check_lone(gs: list[G], values: Words) -> None:
    """Words that stand without coordinates."""
    for g in set(gs).intersection(LONE):
        if not values.keys().isdisjoint(MOVING) or (g is G.SMOOTHING_LEVEL and "P" not in values):
            why = "a spline; post arcs or lines" if g is G.SMOOTHING_LEVEL else "with coordinates it is not read"
            raise ValueError(f"{g.word}: {why}")


def _check_letters(values: Words, gs: list[G], single: G | None, motion: G) -> None:
    """Letters that mean something only beside another word."""
    keys = values.keys()
    if keys.isdisjoint("HPQL"):
        if G.SMOOTHING in gs:
            raise ValueError("G5.1: a spline; post arcs or lines")
        return
    if "H" in keys and not LENGTHS.intersection(gs):
        raise ValueError(f"H{values['H']:g} without G43")
    cycle = motion in CYCLES and single is None
    turns = motion in ARCS and single is None
    if "P" in keys and not (single is G.DWELL or cycle or turns or WITH_P.intersection(gs)):
        raise ValueError(f"P{values['P']:g}: read only with G2, G3, G4, G54.1, G64 and canned cycles")
    if "Q" in keys and not (cycle or WITH_Q.intersection(gs)):
        raise ValueError(f"Q{values['Q']:g}: read only with G64, G5.1, G73 and G83")
    if "L" in keys and not cycle:
        raise ValueError(f"L{values['L']:g}: read only with canned cycles")
    if G.SMOOTHING in gs and ("Q" not in keys or not keys.isdisjoint(MOVING)):
        raise ValueError("G5.1: a spline; post arcs or lines")


def _tool_number(value: float) -> int:
    if not 0 <= value < 1e9 or value != math.floor(value):
        raise ValueError(f"T{value:g}: a whole number from 0 on is expected")
    return int(value)
