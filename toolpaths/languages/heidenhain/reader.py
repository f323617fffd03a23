"""HEIDENHAIN Klartext (.h): run as far as everything in it is constant, its moves collected."""

from __future__ import annotations

import re
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.interpreting.values import ExpressionError
from toolpaths.languages.heidenhain.actions import KlartextActions
from toolpaths.languages.heidenhain.block import SWALLOWING
from toolpaths.languages.heidenhain.program import KlartextUnit, program_beside, unit_of
from toolpaths.languages.heidenhain.words import FUNCTIONS_REFUSED, FUNCTIONS_SET, REFUSED, REMARKS
from toolpaths.machine import Machine
from toolpaths.reading.source_text import comment_word, load_lines
from toolpaths.toolpath import MachineCommand, Toolpath

_WORD = re.compile(r"([A-Z]+)(?![A-Z])\s*(.*)", re.S)
_CALL = re.compile(r'(LBL|PGM)\s*("[^"]*"|[^\s"]+)\s*(?:REP\s*([^\s/]+)(?:\s*/\s*\d+)?)?\s*$')
_NUMBERED = re.compile(r"(\d+)\s*:?\s*(.*)", re.S)
_HARMLESS = re.compile(r"(?:STOP\s*)?(?:L\s+)?(?:M\s*\d+\s*)+$|STOP\s*$|BLK\s|\*|$")
_HARMLESS_M = frozenset((0, 1, 2, 3, 4, 5, 7, 8, 9, 13, 14, 30))
_DECIDED = 13  # FN 0 to 13 are worked out
LEAST_STEPS, DEEPEST, MOST_REPEATS = 100_000, 20, 65_534


def read(path: Path, source: str, chord: float, machine: Machine | None = None) -> Toolpath:
    """Poses of a program in its coordinate system.

    Args:
        path: the file; what it calls may lie beside it.
        source: its name in messages.
        chord: m, how far chords may lie from arcs.
        machine: what a file with rotary words, or with several presets, was posted for.

    Raises:
        ReadError: a line is refused.
    """
    reader = KlartextReader(unit_of(load_lines(path, source), source), path, machine)
    reader.run_all()
    return reader.toolpath(chord)


class KlartextReader(KlartextActions):
    """Runs a program.

    Args:
        main: of the file.
        path: the file.
        machine: what it was posted for.
    """

    def __init__(self, main: KlartextUnit, path: Path, machine: Machine | None) -> None:
        super().__init__(main.source, machine)
        self.path, self.main, self.place = path, main, main
        self.ended_at = -1
        self._steps, self._depth, self._subprograms = LEAST_STEPS, 0, 0
        self._caller = 0  # line that poses carry where another program calls; 0: their own
        self._repeats: dict[tuple[str, int], int] = {}
        self._jumped: set[int] = set()  # jumps back, with what decides about the next ones
        self._beside: dict[str, KlartextUnit] = {}
        self._enter(main)

    def run_all(self) -> None:
        """Run the program.

        Raises:
            ReadError: a block is refused.
        """
        self.unit = self.main.unit
        self.run(self.main, self.main.begin)
        if (behind := self.main.moves_behind(self.ended_at)) is not None:
            raise ReadError(self.source, behind, "moves behind the end of the program", "Two programs in one file?")
        for label, line in self.main.not_called(self.ended_at):
            self.track.event(f"LBL {label} is not called", line)

    def run(self, unit: KlartextUnit, begin: int) -> None:
        """Run blocks, up to LBL 0 of a subprogram or the end.

        Raises:
            ReadError: a block is refused.
        """
        at, before, self.place = begin, self.place, unit
        outer, self._jumped = self._jumped, set()
        while at >= 0 and self.ended_at < 0:
            line, text, comment = unit.blocks[at]
            unit.ran[at] = 1
            self._steps -= 1
            try:
                if self._steps < 0:
                    raise ValueError("the program runs too many blocks for its length", "Post it without loops.")
                if comment:
                    self.track.event(comment_word(comment), self._caller or line)
                at = self._block(at, text, self._caller or line) if text else at + 1
            except ExpressionError as problem:
                raise ReadError(unit.source, line, f"{text[:60]}: {problem}", "Post it with numbers.") from None
            except ValueError as problem:
                raise ReadError(unit.source, line, *map(str, problem.args[:2])) from None
        self.place, self._jumped = before, outer

    def _enter(self, unit: KlartextUnit) -> None:
        """A program is read: how long it may run, and whether it turns axes."""
        self._steps += len(unit.blocks)
        if self.rotary.letters and not self.rotary.used and unit.turns():
            self.rotary.use(len(self.track))

    def _block(self, at: int, text: str, line: int) -> int:
        """Run one block; the one to go on with, below 0 to return."""
        self.text = text
        if text[0] == "/":
            return self._skipped(at, text[1:].strip(), line)
        match = _WORD.match(text)
        word = match[1] if match else ""
        if match and (act := self.acts.get(word)):
            act(match[2], line)
            return at + 1
        if text[0] == "*":
            self.track.event(comment_word(text.strip("* -")), line)
        elif word == "LBL":
            SWALLOWING.refuse(text)
            return -1 if text.replace(" ", "") == "LBL0" and self._subprograms else at + 1
        elif match and word == "CALL":
            return self._call_word(at, match[2], line)
        elif match and word == "FN":
            return self._numbered(at, match[2], line)
        elif word == "END":
            return self._end_of_unit(line)
        elif word == "BEGIN":
            raise ValueError("a second BEGIN PGM", "Two programs in one file? Give one file each.")
        elif word in REFUSED:
            raise ValueError(f"{word}: {REFUSED[word]}")
        elif word == "STOP":
            SWALLOWING.refuse(text)
            self.track.event(comment_word(text), line, MachineCommand("M0"))
        elif word in REMARKS:
            SWALLOWING.refuse(text)
            self.track.event(comment_word(text), line)
        elif not self.q.assign(text):
            raise ValueError(f"{text[:40]!r}: this reader does not know the block")
        return at + 1

    def _end_of_unit(self, line: int) -> int:
        """END PGM: the end, or the way back to the program that called."""
        if self._subprograms:
            raise ValueError("END PGM inside of a subprogram: its LBL 0 is missing")
        if not self._caller:
            self.end(line, "END PGM")
        return -1

    def end(self, line: int, word: str) -> None:
        """M2, M30 or END PGM.

        Raises:
            ValueError: in a program that another one calls.
        """
        if self._caller:
            raise ValueError(f"{word} in a program that is called", "Take it out; END PGM leads back.")
        self.no_corner()
        self.track.event(word, line)
        self.ended_at = max(k for k in range(len(self.main.blocks)) if self.main.blocks[k][0] <= line)

    def _skipped(self, at: int, text: str, line: int) -> int:
        """A block with '/': let pass where it makes no difference to moves whether it counts."""
        ms = {int(m) for m in re.findall(r"M\s*(\d+)", text)}
        if text.startswith("BLK"):
            SWALLOWING.refuse(text)
        if (
            not _HARMLESS.match(text)
            or not ms <= _HARMLESS_M
            or (ms & {2, 30} and self.place.moves_behind(at) is not None)
        ):
            problem = f"/{text[:40]}: whether the block counts is chosen at the machine"
            raise ValueError(problem, "Take out the '/', or the block.")
        self.track.event(comment_word(f"/{text}"), line)
        if ms & {2, 30}:
            self.end(line, "M30")
        return at + 1

    def _call_word(self, at: int, text: str, line: int) -> int:
        """CALL LBL 5, CALL LBL 5 REP 3, CALL PGM."""
        match = _CALL.match(text.strip())
        if not match:
            raise ValueError(f"CALL {text.strip()[:40]}: CALL LBL n, with or without REP, is expected")
        kind, name, times = match.groups()
        if kind == "LBL" and times is not None:
            return self._repeat(at, self.place.place(name), self._number(times))
        if self._depth >= DEEPEST:
            raise ValueError(f"programs call each other more than {DEEPEST} deep")
        outer, self._depth = self._subprograms, self._depth + 1
        if kind == "LBL":
            self._subprograms += 1
            self.run(self.place, self.place.place(name))
        else:
            self._subprograms = 0
            self._run_beside(name, line)
        self._subprograms, self._depth = outer, self._depth - 1
        return at + 1

    def _run_beside(self, name: str, line: int) -> None:
        """The program of another file."""
        if name not in self._beside:
            self._beside[name] = program_beside(name, self.path, self.source)
            self._enter(self._beside[name])
        unit, caller = self._beside[name], self._caller
        if unit.unit != self.unit:
            raise ValueError(f"CALL PGM {name[:60]}: a program in another unit (MM, INCH)", "Post both in one.")
        self._caller = line
        self.run(unit, unit.begin)
        self._caller = caller

    def _repeat(self, at: int, first: int, times: float) -> int:
        """The section from the label to here, so many times more."""
        if times != int(times) or not 0 <= times <= MOST_REPEATS:
            raise ValueError(f"REP {times:g}: a whole number up to {MOST_REPEATS} is expected")
        left = self._repeats.pop((self.place.source, at), int(times))
        if not left:
            return at + 1
        self._repeats[self.place.source, at] = left - 1
        return first

    def _jump(self, at: int, to: int) -> int:
        """Where a jump leads; back with all that decides as it was before, the program would run for ever."""
        if to <= at:
            state = hash((at, self.q.state(), frozenset(self._repeats.items())))
            if state in self._jumped:
                raise ValueError("a loop that never ends: it comes here again with the same Q parameters")
            self._jumped.add(state)
        return to

    def _number(self, text: str) -> float:
        try:
            return self.q.number(text)
        except ValueError:
            raise ValueError(f"{text[:20]!r}: a number is expected") from None

    def _numbered(self, at: int, text: str, line: int) -> int:
        """FN n."""
        match = _NUMBERED.match(text)
        if not match:
            raise ValueError(f"FN {text[:30]}: its number is missing")
        number, rest = int(match[1]), match[2].strip()
        if number <= _DECIDED:
            label = self.q.function(number, rest)
            return at + 1 if label is None else self._jump(at, self.place.place(label))
        if number in FUNCTIONS_REFUSED:
            raise ValueError(f"FN {number}: {FUNCTIONS_REFUSED[number]}")
        SWALLOWING.refuse(rest)
        for kind, first in re.findall(r"Q([LRS]?)(\d+)(?=\s*=)", rest):
            for k in range(FUNCTIONS_SET.get(number, 1)):
                self.q.forget(f"Q{kind}{int(first) + k}", f"FN {number} (line {line})")
        self.track.event(comment_word(self.text), line)
        return at + 1

