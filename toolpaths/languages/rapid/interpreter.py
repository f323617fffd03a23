"""Executes the routines of a RAPID module as far as everything is constant, and collects the moves."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.interpreting.expressions import ExpressionError, Runtime
from toolpaths.languages.rapid.calls import (
    HARMLESS,
    SETTING,
    STEERING,
    given_names,
    idle,
    routines_beside,
    without_poses,
)
from toolpaths.languages.rapid.expressions import Expression, component, item
from toolpaths.languages.rapid.moves import Mover
from toolpaths.languages.rapid.scan import CALL, CHOICE, COMMENT, DATA, LOOP, Declaration, Scanner, Statement
from toolpaths.languages.rapid.values import PREDEFINED, RECORDS, Value, fits
from toolpaths.reading.source_text import comment_word, plain_text

_SET = re.compile(r"\s*(?::=|[.{][^;]*?:=)")
_PART = re.compile(r"\s*(?:\.\s*(\w+)|\{([^}]*)\})")
MOVES = {"movel", "movej", "movec", "moveabsj"}
_DEEPEST = 20


class _FinishedError(Exception):
    """EXIT was met."""


@dataclass(slots=True)
class Variable:
    """A declared name; ``declaration`` is None once the value is not that of the declaration any more."""

    type: str
    value: Value
    declaration: Declaration | None


class Run(Scanner):
    """One module, executed from main.

    Attributes:
        track: the moves.
        names: name (lower case) -> Variable of the module.
        elsewhere: name -> line of the first call of routines that are not in this file.
    """

    def __init__(self, text: str, source: str) -> None:
        super().__init__(text, source)
        if text.startswith("\xef\xbb\xbf"):
            self.at = 3
        self.scan()
        self.names: dict[str, Variable] = {}
        for key, d in self.module.data.items():
            if not key.isdigit():  # those of routines are declared when they are entered
                self.names[key] = Variable(d.type, None, d)
        self.local: dict[str, Variable] = {}
        self.elsewhere: dict[str, int] = {}
        self._beside: dict[str, tuple[str, bool]] | None = None
        self.mover = Mover(self)
        self.track = self.mover.track
        self._left = 100_000 + len(text)
        self._here = 0
        self._depth = 0

    def main(self) -> None:
        """Run the routine that everything starts from.

        Raises:
            ReadError: there is none, or more than one.
        """
        try:
            self._call(self._entry())
        except _FinishedError:
            pass
        except ExpressionError as e:
            self.refuse(self._here, str(e))

    def _entry(self) -> str:
        routines = self.module.routines
        if "main" in routines:
            return "main"
        called = {s.word.lower() for body in routines.values() for s in body if s.kind == CALL}
        first = [name for name in routines if name not in called]
        if len(first) == 1:
            return first[0]
        what = "several: " + ", ".join(self.module.shown[n] for n in first) if first else "no PROC without arguments"
        raise ReadError(
            self.source, None, f"no PROC main() in the module, and {what}", "Call the one to run main.",
        )  # fmt: skip

    def look_up(self, name: str) -> tuple[str, Value]:
        """Type and value of a name, for expressions."""
        variable = self.variable(name)
        if variable is None:
            if name.lower() in PREDEFINED:
                return PREDEFINED[name.lower()]
            return "", Runtime(f"{name}, which is not declared in this file")
        if variable.value is None:
            variable.value = self._first_value(name, variable)
        return variable.type, variable.value

    def variable(self, name: str) -> Variable | None:
        """A declared name: of the routine, else of the module."""
        lower = name.lower()
        return self.local.get(lower) or self.names.get(lower)

    def _first_value(self, name: str, variable: Variable) -> Value:
        d = variable.declaration
        if d is None or d.value[0] < 0:
            return Runtime(f"{name}, which has no value")
        variable.value = Runtime(f"{name}, which is declared by itself")
        try:
            value = Expression(self.text[slice(*d.value)], self).whole()
        except ExpressionError as e:
            self.refuse(d.start, f"{d.name}: {e}")
        if not d.array and not isinstance(value, Runtime) and not fits(d.type, value):
            shape = ", ".join(n for n, _ in RECORDS.get(d.type, ())) or d.type
            self.refuse(d.start, f"{d.name} is no {d.type}", f"Its parts are {shape}.")
        return value

    def _call(self, name: str) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            self.refuse(self._here, f"routines call each other more than {_DEEPEST} deep")
        outer, self.local = self.local, {}
        self.mover.forget()
        self._body(self.module.routines[name])
        self.local = outer
        self.mover.forget()
        self._depth -= 1

    def _body(self, body: list[Statement]) -> bool:
        """Run statements; True where RETURN was met."""
        for s in body:
            self._here = s.start
            self._left -= 1
            if self._left < 0:
                self.refuse(s.start, "the program runs too many instructions for its length")
            if s.kind == CALL:
                if self._instruction(s):
                    return True
            elif s.kind == COMMENT:
                self.track.event(comment_word(plain_text(s.word)), self.line(s.start))
            elif s.kind == DATA:
                d = self.module.data[s.word]
                self.local[d.name.lower()] = Variable(d.type, None, d)
                self.mover.forget()
            elif s.kind == LOOP:
                if self._run_loop(s):
                    return True
            elif s.kind == CHOICE and self._run_choice(s):
                return True
        return False

    def _instruction(self, s: Statement) -> bool:
        word = s.word.lower()
        if word in MOVES:
            self.mover.move(word, s)
            return False
        rest = self.text[s.start + len(s.word) : s.end - 1]
        if _SET.match(rest):
            self._assign(s, rest)
        elif word in self.module.routines and not rest.strip():
            self._call(word)
        elif word in ("exit", "exitcycle"):
            raise _FinishedError
        elif word == "return":
            return True
        else:
            self._other(s, word, rest)
        return False

    def _other(self, s: Statement, word: str, rest: str) -> None:
        if word not in HARMLESS and not self._idle_routine(word):
            if STEERING.match(word):
                self.refuse(s.start, f"{s.word} moves the arm in a way that only the controller knows", _REMEDY)
            if word in self.module.functions or word in self.module.with_arguments:
                remedy = "Write its moves out, with numbers."
                self.refuse(s.start, f"{s.word} is a routine with arguments that moves the arm or sets values", remedy)
            if not without_poses(rest, self):
                remedy = f"{_REMEDY} If it moves nothing, call it by a routine without arguments."
                self.refuse(s.start, f"instruction {s.word} is not known", remedy)
            if s.word not in self.elsewhere:
                self._refuse_moves_beside(s)
                self.elsewhere[s.word] = self.line(s.start)
            self._may_set(s, rest)
        elif word in SETTING:
            self._may_set(s, rest)
        self.track.event(comment_word(plain_text(self.text[s.start : s.end])), self.line(s.start))

    def _may_set(self, s: Statement, rest: str) -> None:
        for name in given_names(rest):
            variable = self.variable(name)
            if variable and not (variable.declaration and variable.declaration.storage == "CONST"):
                self._set(name, Runtime(f"{name}, which {s.word} may set (line {self.line(s.start)})"))

    def _idle_routine(self, word: str) -> bool:
        body = self.module.with_arguments.get(word)
        return body is not None and idle(body)

    def _refuse_moves_beside(self, s: Statement) -> None:
        """A program in parts: the moves of the other files would be missing."""
        if self._beside is None:
            self._beside = routines_beside(Path(self.source))
        beside = self._beside.get(s.word.lower())
        if re.fullmatch(r"\w+_run_\d{3,}", s.word):  # as this product writes it
            beside = ("another file", True) if beside is None else beside
        if beside is not None and beside[1]:
            problem = f"{s.word} stands in {beside[0]} and moves the arm"
            self.refuse(s.start, problem, "Give a program of one file: put the routine into this module.")

    def _assign(self, s: Statement, rest: str) -> None:
        target, _, text = rest.partition(":=")
        variable = self.variable(s.word)
        try:
            value = Expression(text, self).whole()
            if variable is None:
                return
            path = _path(target, self)
            if path is None:
                value = Runtime(f"an element of {s.word} that is chosen at run time")
                path = []
            if isinstance(value, Runtime):
                value = Runtime(f"{value.reason} (line {self.line(s.start)})"[:200])
            self._put(s, variable, path, value)
        except ExpressionError as e:
            self.refuse(s.start, f"{s.word}: {e}")

    def _put(self, s: Statement, variable: Variable, path: list[str | float], value: Value) -> None:
        kind, old = self.look_up(s.word)
        if not path:
            if not isinstance(value, Runtime) and not fits(kind, value) and not isinstance(old, list):
                raise ExpressionError(f"the value is no {kind}")
            variable.value = value
        elif isinstance(old, Runtime) or isinstance(value, Runtime):
            variable.value = value if isinstance(value, Runtime) else old
        else:
            variable.value = _changed(kind, old, path, value, s.word)
        variable.declaration = None
        self.mover.forget()

    def _set(self, name: str, value: Value) -> None:
        variable = self.variable(name)
        if variable:
            variable.value, variable.declaration = value, None
        self.mover.forget()

    def _run_loop(self, s: Statement) -> bool:
        name = s.terms[0]
        terms = [self._number(t, s) for t in (s.terms[1:] if s.terms[3] else s.terms[1:3])]
        step = terms[2] if len(terms) > 2 else math.copysign(1.0, terms[1] - terms[0])
        if step == 0.0:
            self.refuse(s.start, "FOR with STEP 0 never ends")
        outer, value = self.local.get(name.lower()), terms[0]
        while (terms[1] - value) * step >= 0.0:
            self.local[name.lower()] = Variable("num", value, None)
            self.mover.forget()
            self._left -= 1
            if self._body(s.body):
                return True
            if self._left < 0:
                self.refuse(s.start, "the program runs too many instructions for its length")
            value += step
        self.local.pop(name.lower())
        if outer:
            self.local[name.lower()] = outer
        return False

    def _number(self, text: str, s: Statement) -> float:
        value = Expression(text, self).whole()
        if isinstance(value, Runtime):
            self.refuse(s.start, f"the loop runs from or to {value.reason}: known only at run time", _REMEDY)
        if not isinstance(value, float) or not math.isfinite(value):
            self.refuse(s.start, f"{text.strip()[:40]!r} is no number")
        return value

    def _run_choice(self, s: Statement) -> bool:
        for branch in s.body:
            value = Expression(branch.terms[0], self).whole()
            if isinstance(value, Runtime):
                if all(idle(b.body) for b in s.body):
                    self.track.event("IF " + comment_word(plain_text(branch.terms[0])), self.line(s.start))
                    return False
                self.refuse(s.start, f"what runs depends on {value.reason}: known only at run time", _REMEDY)
            if not isinstance(value, bool):
                self.refuse(s.start, "the condition of IF is not TRUE or FALSE")
            if value:
                return self._body(branch.body)
        return False


_REMEDY = "Post the program with plain MoveL, MoveC, MoveJ and MoveAbsJ."


def _path(text: str, run: Run) -> list[str | float] | None:
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
                index = Expression(piece, run).whole()
                if isinstance(index, Runtime):
                    return None
                path.append(index)
        at = match.end()
    return path


def _changed(kind: str, old: Value, path: list[str | float], value: Value, name: str) -> Value:
    """``old`` with the part at ``path`` replaced; a new list, others may share the old one."""
    if not path:
        if not fits(kind, value) and not isinstance(old, list):
            raise ExpressionError(f"the value is no {kind}")
        return value
    first = path[0]
    if isinstance(first, float):
        item(old, first, name)
        place, inner = int(first) - 1, kind
    else:
        place, inner = component(kind, str(first))
    out = list(old)
    out[place] = _changed(inner, old[place], path[1:], value, name)
    return out
