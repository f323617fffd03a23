"""Executes the routines of a RAPID module as far as everything is constant, and collects the moves."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable

from toolpaths.errors import ReadError
from toolpaths.interpreting.interpreter import Interpreter, ReturnedError
from toolpaths.interpreting.program_text import PLAIN, Statement
from toolpaths.interpreting.statements import Statements
from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.interpreting.variables import Variable
from toolpaths.languages.rapid.calls import (
    HARMLESS,
    QUIET,
    SETTING,
    STEERING,
    given_names,
    idle,
    without_poses,
)
from toolpaths.languages.rapid.moves import RapidMover
from toolpaths.languages.rapid.names import RapidNames
from toolpaths.languages.rapid.program import RapidProgram
from toolpaths.languages.rapid.values import Value

_SET = re.compile(r"\s*(?::=|[.{][^;]*?:=)")
_PART = re.compile(r"\s*(?:\.\s*(\w+)|\{([^}]*)\})")
_MOVES = {"movel", "movej", "movec", "moveabsj"}


class _FinishedError(Exception):
    """EXIT was met."""


class RapidInterpreter(Interpreter):
    """One program, executed from main.

    Attributes:
        names: what names mean.
        mover: what makes moves of move instructions.
        elsewhere: name -> line of the first call of routines that are in no file.
    """

    program: RapidProgram
    lines, routines = "instructions", "routines"
    remedy = "Post the program with plain MoveL, MoveC, MoveJ and MoveAbsJ."

    def __init__(self, program: RapidProgram) -> None:
        self.names = RapidNames(program)
        self.mover = RapidMover(program, self.names)
        super().__init__(program, self.mover.track)
        self.elsewhere: dict[str, int] = {}

    def main(self) -> None:
        """Run the routine that everything starts from.

        Raises:
            ReadError: there is none, or more than one.
        """
        try:
            with contextlib.suppress(_FinishedError):
                self._call(self.program.modules[0].routines[self._entry()], 0)
        except ExpressionError as e:
            self.program.refuse(self.here, str(e))

    def _entry(self) -> str:
        main = self.program.modules[0]
        routines = main.routines
        if "main" in routines:
            return "main"
        called = {s.word.lower() for body in routines.values() for s in body if s.kind == PLAIN}
        first = [name for name in routines if name not in called]
        if len(first) == 1:
            return first[0]
        shown = main.shown
        what = "several: " + ", ".join(shown[n] for n in first) if first else "no PROC without arguments"
        problem = f"no PROC main() in the module, and {what}"
        raise ReadError(self.program.source, None, problem, "Call the one to run main.")

    def _call(self, body: Iterable[Statement], module: int) -> None:
        outer = self.names.local, self.names.module
        self._in_scope({}, module)
        self.routine(body)
        self._in_scope(*outer)

    def _in_scope(self, local: dict[str, Variable], module: int) -> None:
        self.names.enter(local, module)
        self.mover.forget()

    def value(self, text: str) -> Value:
        """The value of an expression."""
        return self.names.value(text)

    def idle(self, body: Iterable[Statement]) -> bool:
        """Whether statements neither move nor set anything."""
        return idle(body)

    def declare(self, s: Statement) -> None:
        """CONST, PERS or VAR in a routine."""
        d = self.program.inner[s.start]
        self.names.declare(d.name, Variable(None, d, d.type))
        self.mover.forget()

    def line(self, s: Statement) -> None:
        """A move, an assignment, a call, or what neither moves nor sets anything."""
        word = s.word.lower()
        if word in _MOVES:
            self.mover.move(word, s)
            return
        rest = self.program.piece(s.start + len(s.word), s.end - 1)
        if _SET.match(rest):
            self._assign(s, rest)
        elif not rest.strip() and (called := self._routine(word)):
            self._call(*called)
        elif word in ("exit", "exitcycle"):
            raise _FinishedError
        elif word == "return":
            raise ReturnedError
        else:
            self._other(s, word, rest)

    def _routine(self, word: str) -> tuple[Statements, int] | None:
        """A routine without arguments, be it in a module beside."""
        found = self.program.routine(word, self.names.module)
        if found is None and word not in HARMLESS and self.program.find(word):
            found = self.program.routine(word, self.names.module)
        return found

    def _other(self, s: Statement, word: str, rest: str) -> None:
        if word not in HARMLESS and not self._idle_routine(word):
            if STEERING.match(word):
                problem = f"{s.word} moves the arm in a way that only the controller knows"
                self.program.refuse(s.start, problem, self.remedy)
            if self.program.is_function(word) or self._with_arguments(word) is not None:
                problem = f"{s.word} is a routine with arguments that moves the arm or sets values"
                self.program.refuse(s.start, problem, "Write its moves out, with numbers.")
            if not without_poses(rest, self.names):
                remedy = f"{self.remedy} If it moves nothing, call it by a routine without arguments."
                self.program.refuse(s.start, f"instruction {s.word} is not known", remedy)
            if s.word not in self.elsewhere:
                self._refuse_moves_elsewhere(s)
                self.elsewhere[s.word] = self.program.line(s.start)
            self._may_set(s, rest)
        elif word in SETTING:
            self._may_set(s, rest)
        self.remark(s, self.program.piece(s.start, s.end), "" if word in QUIET else word)

    def _may_set(self, s: Statement, rest: str) -> None:
        for name in given_names(rest):
            variable = self.names.variable(name)
            if variable and not (variable.declaration and variable.declaration.storage == "CONST"):
                self._set(name, Runtime(f"{name}, which {s.word} may set (line {self.program.line(s.start)})"))

    def _with_arguments(self, word: str) -> Statements | None:
        body = self.program.with_arguments(word, self.names.module)
        if body is None and not STEERING.match(word) and self.program.find(word):
            body = self.program.with_arguments(word, self.names.module)
        return body

    def _idle_routine(self, word: str) -> bool:
        body = self._with_arguments(word)
        return body is not None and idle(body)

    def _refuse_moves_elsewhere(self, s: Statement) -> None:
        """A part of a program that is not there, or cannot be read: its moves would be missing."""
        if why := self.program.moves_beside(s.word):
            self.program.refuse(s.start, f"{s.word} moves the arm, and its file cannot be read: {why}")
        if re.fullmatch(r"\w+_run_\d{3,}", s.word):  # as this product writes it
            problem = f"{s.word} moves the arm, and its module is not there"
            self.program.refuse(s.start, problem, "Put it beside this one, or name all files of the program.")

    def _assign(self, s: Statement, rest: str) -> None:
        target, _, text = rest.partition(":=")
        variable = self.names.variable(s.word)
        try:
            value = self.value(text)
            if variable is None:
                return
            path = _path(target, self.names)
            if path is None:
                value = Runtime(f"an element of {s.word} that is chosen at run time")
                path = []
            if isinstance(value, Runtime):
                value = Runtime(f"{value.reason} (line {self.program.line(s.start)})"[:200])
            self.names.put_part(s.word, path, value)
            self.mover.forget()
        except ExpressionError as e:
            self.program.refuse(s.start, f"{s.word}: {e}")

    def _set(self, name: str, value: Value) -> None:
        self.names.put(name, value)
        self.mover.forget()

    def bounds(self, s: Statement) -> tuple[float, float, float]:
        """FROM, TO and STEP of FOR."""
        first, last, *more = (self._number(t, s) for t in (s.terms[1:] if s.terms[3] else s.terms[1:3]))
        return first, last, more[0] if more else math.copysign(1.0, last - first)

    def loop(self, s: Statement) -> None:
        """FOR, whose variable hides another one of its name."""
        name = s.terms[0].lower()
        outer = self.names.local.get(name)
        super().loop(s)
        self.names.declare(name, outer)

    def count(self, name: str, value: float) -> None:
        """The variable of FOR gets its next value."""
        self.names.declare(name, Variable(value, None, "num"))
        self.mover.forget()

    def _number(self, text: str, s: Statement) -> float:
        value = self.value(text)
        if isinstance(value, Runtime):
            problem = f"the loop runs from or to {value.reason}: known only at run time"
            self.program.refuse(s.start, problem, self.remedy)
        if not isinstance(value, float) or not math.isfinite(value):
            self.program.refuse(s.start, f"{text.strip()[:40]!r} is no number")
        return value


def _path(text: str, names: RapidNames) -> list[str | float] | None:
    """Components and indices behind a name; None where an index is not constant."""
    path: list[str | float] = []
    at = 0
    while text[at:].strip():
        match = _PART.match(text, at)
        if not match:
            raise ExpressionError(f"{text.strip()[:30]!r} is no place for a value")
        if match[1]:
            path.append(match[1].lower())
        else:
            for piece in match[2].split(","):
                index = names.value(piece)
                if isinstance(index, Runtime):
                    return None
                path.append(index)
        at = match.end()
    return path
