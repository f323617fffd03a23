"""Interpreter: runs the statements of a program as far as everything is constant, and collects its moves."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from typing import Any, NoReturn

from toolpaths.interpreting.program_text import CHOICE, COMMENT, DATA, LOOP, PLAIN, LinkedText, Statement
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import Runtime
from toolpaths.reading.source_text import comment_word, plain_text

_DEEPEST = 20
_LEAST_STEPS = 100_000  # that a program may run, however short it is


class ReturnedError(Exception):
    """The routine ends here."""


class Interpreter:
    """One program, run from its first routine.

    Attributes:
        program: its text.
        track: its moves.
        here: place of the statement that runs.
        lines, routines: what the language calls them, for messages.
        remedy: what to do about what is known only at run time.
    """

    lines, routines, remedy = "lines", "routines", ""

    def __init__(self, program: LinkedText, track: RobotTrack) -> None:
        self.program, self.track = program, track
        self.here = 0
        self._run = 0
        self._depth = 0

    @property
    def _runs_on(self) -> bool:
        """Whether more has been run than can be meant; files that are called make a program longer as they are read."""
        return self._run > _LEAST_STEPS + self.program.length

    def line(self, s: Statement) -> None:
        """Run an instruction or an assignment."""
        raise NotImplementedError

    def declare(self, s: Statement) -> None:
        """A declaration inside a routine takes effect."""

    def value(self, text: str) -> Any:
        """The value of an expression."""
        raise NotImplementedError

    def idle(self, body: Iterable[Statement]) -> bool:
        """Whether statements neither move nor set anything that moves depend on."""
        raise NotImplementedError

    def bounds(self, s: Statement) -> tuple[float, float, float]:
        """From, to and step of a loop."""
        raise NotImplementedError

    def count(self, name: str, value: float) -> None:
        """The variable of a loop gets its next value."""
        raise NotImplementedError

    def routine(self, body: Iterable[Statement]) -> None:
        """Run a routine up to its end or RETURN."""
        self._depth += 1
        if self._depth > _DEEPEST:
            self.program.refuse(self.here, f"{self.routines} call each other more than {_DEEPEST} deep")
        with contextlib.suppress(ReturnedError):
            self.body(body)
        self._depth -= 1

    def body(self, body: Iterable[Statement]) -> None:
        """Run statements."""
        for s in body:
            self.here = s.start
            self._run += 1
            if self._runs_on:
                self._refuse_length(s)
            if s.kind == PLAIN:
                self.line(s)
            elif s.kind == COMMENT:
                self.remark(s, s.word)
            elif s.kind == DATA:
                self.declare(s)
            elif s.kind == LOOP:
                self.loop(s)
            elif s.kind == CHOICE:
                self._choice(s)

    def remark(self, s: Statement, text: str, instruction: str = "") -> None:
        """Keep a remark of the program for its next move; ``instruction``: what it is, if it acts on the machine."""
        file = self.program.part(s.start)
        self.track.event(comment_word(plain_text(text)), self.program.line(s.start), instruction, file)

    def loop(self, s: Statement) -> None:
        """FOR."""
        value, last, step = self.bounds(s)
        if step == 0.0:
            self.program.refuse(s.start, "FOR with STEP 0 never ends")
        while (last - value) * step >= 0.0:
            self.count(s.terms[0], value)
            self._run += 1
            self.body(s.body)
            if self._runs_on:
                self._refuse_length(s)
            value += step

    def _choice(self, s: Statement) -> None:
        for branch in s.body:
            value = self.value(branch.terms[0])
            if isinstance(value, Runtime):
                if all(self.idle(b.body) for b in s.body):
                    self.remark(s, "IF " + branch.terms[0])
                    return
                problem = f"what runs depends on {value.reason}: known only at run time"
                self.program.refuse(s.start, problem, self.remedy)
            if not isinstance(value, bool):
                self.program.refuse(s.start, "the condition of IF is not TRUE or FALSE")
            if value:
                self.body(branch.body)
                return

    def _refuse_length(self, s: Statement) -> NoReturn:
        self.program.refuse(s.start, f"the program runs too many {self.lines} for its length")
