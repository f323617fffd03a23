"""Subprograms in the file that calls them: M98 P, and O ... M99 behind the end of the main program."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from toolpaths.errors import ReadError
from toolpaths.languages.gcode.words import Words, strip_comments

CALL = re.compile(r"M\s*0*98(?![\d.])", re.I)
_NUMBER = re.compile(r"\s*(?:N\s*\d+\s*)?[O:]\s*(\d{1,8})\s*$", re.I)
_DEEPEST = 10
_MOST_REPEATS = 9999
_LEAST_BLOCKS = 100_000  # that a file may run, however short it is
_BLOCKS_A_LINE = 200


class SubprogramCall(NamedTuple):
    """M98: which program, how often, and the line of the call."""

    number: int
    repeats: int
    line: int


class Subprograms:
    """The blocks of a file in the order in which they run.

    Args:
        lines: of the file.
        source: its name, for messages.
        calls: whether it has an M98: only then are there subprograms.

    Raises:
        ReadError: two programs of one number, or one that nothing calls.
    """

    def __init__(self, lines: list[str], source: str, *, calls: bool) -> None:
        self.lines, self.source = lines, source
        self._left = _LEAST_BLOCKS + _BLOCKS_A_LINE * len(lines)
        self._depth = 0
        self._bodies: dict[int, tuple[int, int]] = {}  # first and last line, counted from 1; that of the O word is out
        self._called: set[int] = set()
        self.end = len(lines)  # of the main program
        if calls:
            self._find()

    def _find(self) -> None:
        texts = [strip_comments(text)[0] for text in self.lines]
        heads = [(k, int(m[1])) for k, text in enumerate(texts, 1) if (m := _NUMBER.match(text))]
        main = heads and not any(text.strip(" \t%") for text in texts[: heads[0][0] - 1])
        subs = heads[1:] if main else heads
        for (k, number), after in pairwise([*subs, (len(self.lines) + 1, 0)]):
            if number in self._bodies:
                problem = f"O{number} stands twice, first in line {self._bodies[number][0] - 1}"
                raise ReadError(self.source, k, problem, "Keep one of them.")
            self._bodies[number] = k + 1, after[0] - 1
        if subs:
            self.end = subs[0][0] - 1

    def main(self) -> Iterator[tuple[int, str]]:
        """Line and text of the main program."""
        return self._run(1, self.end)

    def _run(self, first: int, last: int) -> Iterator[tuple[int, str]]:
        for line in range(first, last + 1):
            self._left -= 1
            if self._left < 0:
                raise ReadError(self.source, line, "the calls run too many blocks for the length of the file")
            yield line, self.lines[line - 1]

    def body(self, call: SubprogramCall) -> Iterator[tuple[int, str]]:
        """Line and text of a called program, once.

        Raises:
            ReadError: it is not in the file, or calls go too deep.
        """
        if call.number not in self._bodies:
            problem = f"M98 P{call.number}: program O{call.number} is not in this file"
            remedy = "Post in one file, the subprograms behind the main program."
            raise ReadError(self.source, call.line, problem, remedy)
        self._called.add(call.number)
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ReadError(self.source, call.line, f"subprograms call each other more than {_DEEPEST} deep")
        yield from self._run(*self._bodies[call.number])

    def leave(self) -> None:
        """The program that was called last ends."""
        self._depth -= 1

    def number_of(self, value: float) -> tuple[int, int]:
        """Program and repetitions of P where no L stands: 51002 is five times 1002, if there is no program 51002.

        Raises:
            ValueError: it is no number of a program.
        """
        if value != int(value) or not 0 < value < 1e9:
            raise ValueError(f"M98 P{value:g}: the number of a program is expected")
        number = int(value)
        if number not in self._bodies and number > 9999:
            return number % 10000, number // 10000
        return number, 1

    def check(self) -> None:
        """Every program of the file has to be called.

        Raises:
            ReadError: names the one that is not.
        """
        for number, (first, _) in self._bodies.items():
            if number not in self._called:
                problem = f"O{number}: a second program, which the first does not call"
                raise ReadError(self.source, first - 1, problem, "Two programs in one file? Give one file each.")


def called_by(values: Words, line: int, programs: Subprograms) -> SubprogramCall:
    """The call of M98; its words are taken from the block."""
    if "P" not in values:
        raise ValueError("M98 without P")
    number, times = programs.number_of(values.pop("P"))
    repeats = times * values.pop("L", 1.0)
    if repeats != math.floor(repeats) or not 1 <= repeats <= _MOST_REPEATS:
        raise ValueError(f"M98 L{repeats:g}: a whole number from 1 to {_MOST_REPEATS} is expected")
    return SubprogramCall(number, int(repeats), line)
