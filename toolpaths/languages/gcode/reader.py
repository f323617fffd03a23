"""G-code (RS-274, Fanuc dialect): lines, arcs, drilling cycles, shifts of the origin, tool vectors, rotary axes."""

from __future__ import annotations

import re
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.languages.gcode.block_checks import (
    LENGTHS,
    MOVING,
    check_groups,
    check_letters,
    check_lone,
    check_zeros,
    cut_off,
    tool_number,
)
from toolpaths.languages.gcode.codes import (
    COMPENSATIONS,
    FEED_MODES,
    MOTIONS,
    RETRACTS,
    RETURNS,
    SINGLE,
    SYSTEMS,
    G,
)
from toolpaths.languages.gcode.machine_words import SENSES, SPINDLE_STOPS, commands
from toolpaths.languages.gcode.motion import GcodeMotion
from toolpaths.languages.gcode.retract import Retract, check_clearances, check_retracts
from toolpaths.languages.gcode.subprograms import CALL, SubprogramCall, Subprograms, called_by
from toolpaths.languages.gcode.variables import Variables, has_variables
from toolpaths.languages.gcode.words import (
    M_CALL,
    M_END,
    M_RETURN,
    Words,
    flows,
    prints_refused,
    split_block,
    stands_in,
    strip_comments,
)
from toolpaths.machine import Machine
from toolpaths.reading.source_text import comment_word, load_lines
from toolpaths.toolpath import MachineCommand, Toolpath

MM, INCH = 1e-3, 25.4e-3
PLANES = {G.PLANE_XY: 2, G.PLANE_ZX: 1, G.PLANE_YZ: 0}  # index of the axis normal to the plane
ALLOWED = frozenset("XYZIJKRFSTNHPQOLABCDE") | {",R", ",C"}
TOOL_CHANGE = re.compile(r"[Mm]\s*0*6(?![0-9.])")
COLON = re.compile(r"^\s*:(?=\s*\d)")  # the number of a program in ISO code
TILTED = re.compile(r"[Gg]\s*0*68\.20*(?![\d.])")
ROTARY = re.compile(r"[ABCabc]\s*[-+.\d]")
FEEDS = MOTIONS - {G.RAPID}
WORDY = frozenset((G.TILTED_PLANE, G.OFFSETS_SET))


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
        self.tilts = False  # does a G68.2 stand in the file? then A B C only go with it
        self.changes = False  # does an M6 stand in the file? then T only selects
        self.retracts: list[Retract] = []
        self.variables = Variables()
        self.programs = Subprograms([], source, calls=False)
        self.depth = 0  # of calls

    def read(self, lines: list[str]) -> None:
        """Read every block."""
        self.changes = stands_in(TOOL_CHANGE, lines)
        self.tilts = not self.state.rotary.letters and stands_in(TILTED, lines)
        if self.state.rotary.letters and stands_in(ROTARY, lines):
            self.state.rotary.use()
        self.programs = Subprograms(lines, self.source, calls=stands_in(CALL, lines))
        for line, text in self.programs.main():
            if text and not text.isspace():
                self._line(text, line)
        self.programs.check()
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
        text = text.upper().rstrip()
        try:
            if has_variables(text) and not flows(text):
                text = self.variables.block(text)
            values, gs, ms = split_block(text, self.source, line)
            if not (values or gs or ms):
                return
            if self.ended:
                raise ValueError("words after the end of the program", "Two programs in one file? Give one file each.")
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
            check_groups(gs)
            for g in gs:
                if g in FEED_MODES:
                    state.feed.choose(g)
        if "F" in values:
            state.feed.say(values["F"])
        called = called_by(values, line, self.programs) if M_CALL in ms else None
        if ms or not values.keys().isdisjoint("STO"):
            self._events(values, ms, line)
        if gs:
            single = self._modes(gs, values)
            check_lone(gs, values)
        if self.tilts and not values.keys().isdisjoint("ABC"):
            self.track.event(state.stand(values, home=single in RETRACTS), line)
            single = None if single in RETRACTS and values.keys().isdisjoint("XYZ") else single
        check_letters(values, gs, single, state.motion or G.RAPID)
        if single is not None:
            self._single(single, values, line, feeding=not FEEDS.isdisjoint(gs))
        elif not values.keys().isdisjoint(MOVING) and G.SMOOTHING not in gs:
            state.move(values, line)
        if called is not None:
            self._call(called)
        if any(m in M_END for m in ms):
            self._end(next(m for m in ms if m in M_END), values, line)

    def _end(self, m: int, values: Words, line: int) -> None:
        """M2, M30, M99."""
        self.state.refuse_corner(f"M{m}")
        if m == M_RETURN and not values.keys().isdisjoint("PL"):
            raise ValueError("M99 with P or L: it goes on elsewhere in the program that called")
        if self.depth and m != M_RETURN:
            raise ValueError(f"M{m} in a program that another one calls: M99 is its end")
        if not self.depth:
            self.track.event(f"M{m}", line)
        self.ended = True

    def _call(self, call: SubprogramCall) -> None:
        """M98: the blocks of the program that it names."""
        self.track.event(f"M98 P{call.number}" + (f" L{call.repeats}" if call.repeats > 1 else ""), call.line)
        self.depth += 1
        for _ in range(call.repeats):
            last, self.ended = call.line, False
            self.variables.enter()
            for line, text in self.programs.body(call):
                if text.strip() not in ("", "%"):
                    self._line(text, last := line)
            if not self.ended:
                raise self._error(last, f"program O{call.number} ends without M99")
            self.programs.leave()
            self.variables.leave()
        self.depth -= 1
        self.ended = False

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
            elif g in COMPENSATIONS:
                state.compensate(g, values)
            elif g is G.ROTATION_OFF:
                state.untilt()
            elif g in SINGLE:
                single = g
        return single

    def _single(self, single: G, values: Words, line: int, *, feeding: bool) -> None:
        """A word that counts in its block only."""
        if single is G.DWELL:
            if "P" in values and not values.keys().isdisjoint(MOVING):
                raise ValueError("G4 with P and coordinates; put the dwell into a block of its own")
            if not values.keys().isdisjoint(MOVING - {"X"}):
                raise ValueError("G4 with coordinates; put the dwell into a block of its own")
            dwell = values.get("P", values.get("X", 0.0))
            self.track.event(f"G4 P{dwell:g}", line, MachineCommand("G4", {"P": dwell}))
        elif single in RETRACTS:
            words = self.state.retract(single, values, line, feeding=feeding)
            self.track.event(words, line)
            self.retracts.append(Retract(len(self.track), line, words))
        else:
            if single is G.TILTED_PLANE:
                self.state.tilt(values)
            elif single is G.TOOL_INTO_PLANE:
                self.state.turn_tool()
            elif single is G.OFFSETS_SET:
                check_zeros(values)
            else:
                self.state.shift(single, values)
            axes = [f"{a}{values[a]:g}" for a in ("LPXYZIJK" if single in WORDY else "XYZ") if a in values]
            self.track.event(" ".join([single.word, *axes]), line)

    def _events(self, values: Words, ms: list[int], line: int) -> None:
        words = []
        if "O" in values:
            if len(self.track) or self.state.unit:
                raise ValueError(f"O{values['O']:g}: a second program", "Give one file each.")
            words.append(f"O{values['O']:g}")
        if "T" in values:
            self.selected = tool_number(values["T"])
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
        words += [f"M{m}" for m in ms if m not in M_END and m != M_CALL]
        if words:
            spindle, speed = self.track.spindle, self.state.feed.speed
            asked = commands(values, ms, spindle=spindle, speed=speed, tool=self.selected, changes=self.changes)
            self.track.event(" ".join(words), line, *asked)

    def _check_end(self, lines: list[str]) -> None:
        why = "" if self.ended else cut_off(self.percent, self.track.spindle.turns, lines[-1])
        if why:
            problem = f"the file looks cut off: {why}"
            raise self._error(len(lines), problem, "Add M30 if it is complete.")

    def _error(self, line: int, problem: str, remedy: str = "") -> ReadError:
        return ReadError(self.source, line, problem, remedy)
