"""Executes a KRL program as far as everything is constant, and collects the moves."""

from __future__ import annotations

import contextlib
import math
import re
from dataclasses import dataclass
from pathlib import Path

from toolpaths.interpreting.expressions import ExpressionError, Runtime
from toolpaths.languages.krl.expressions import NULL, Expression, Value
from toolpaths.languages.krl.moves import MOTION, Mover
from toolpaths.languages.krl.scan import COMMENT, LOOP, PLAIN, Declaration, Scanner, Statement
from toolpaths.reading.source_text import comment_word, plain_text

_ASSIGN = re.compile(r"([$A-Za-z_][\w$]*)((?:\s*\[[^\]]*\])?)((?:\s*\.\s*\w+)*)\s*=(?!=)\s*(.*)$", re.S)
_CALL = re.compile(r"([A-Za-z_][\w$]*)\s*\((.*)\)\s*$", re.S)
_HARMLESS = re.compile(
    r"(WAIT|HALT|CONTINUE|(GLOBAL\s+)?INTERRUPT|EXT|EXTFCT|EXTFCTP|SIGNAL|PULSE|TRIGGER|BRAKE?|IMPORT|ANOUT|ANIN|"
    r"CONFIRM|RESUME|CWRITE|CLEAR)(?![\w$])", re.I,
)  # fmt: skip
_STEERING = re.compile(r"(\$POS_CORR|\$VEL_EXT|\$TECH|\$ON_PATH)", re.I)
_BAS = re.compile(r"BAS\s*\(\s*#(\w+)\s*(?:,\s*(.*))?\)\s*$", re.I)
_NUMBERED = re.compile(r"(TOOL_DATA|BASE_DATA)\s*\[\s*(\d+)\s*\]\s*$", re.I)
_HARMLESS_CALLS = {"BAS", "IR_STOPM"}
_REMEDY = "Post the program with plain LIN, CIRC and PTP."
_DEEPEST = 20


@dataclass(slots=True)
class Variable:
    """A name's value; ``declaration`` is None once the value is not that of the declaration any more."""

    value: Value
    declaration: Declaration | None


class _FinishedError(Exception):
    """RETURN was met."""


class Run(Scanner):
    """One program, executed from its first DEF.

    Attributes:
        track: the moves.
        names: name, upper case -> Variable.
        elsewhere: name -> line of the first call of subprograms that are not in this file.
    """

    def __init__(self, text: str, source: str, values: str, beside: str, path: Path) -> None:
        super().__init__(text, source, values, beside)
        self.path = path
        self.scan()
        self.names = {name: Variable(None, d) for name, d in self.declared.items()}
        self.names["$NULLFRAME"] = Variable(dict(NULL), None)
        self.mover = Mover(self)
        self.track = self.mover.track
        self._left = 100_000 + len(text)
        self._here = 0
        self._depth = 0
        self._called = {self.first}
        self.elsewhere: dict[str, int] = {}

    def main(self) -> None:
        """Run the first DEF.

        Raises:
            ReadError: a line that is known only while the program runs.
        """
        try:
            self._call(self.first)
        except ExpressionError as e:
            self.refuse(self._here, str(e))
        for name, body in self.routines.items():
            moving = [s for s in body if s.kind == PLAIN and MOTION.match(self.text, s.start, s.end)]
            if name not in self._called and moving:
                what = f"DEF {name} moves the arm, and {self.first} does not call it: two programs in one file"
                self.refuse(moving[0].start, what, "Give one of them.")

    def look_up(self, name: str) -> Value:
        """The value of a name, upper case."""
        variable = self.names.get(name)
        if variable is None:
            if name in ("$POS_ACT", "$AXIS_ACT", "$POS_FOR", "$AXIS_FOR", "$POS_ACT_MES", "$AXIS_ACT_MES"):
                return Runtime(f"{name}, where the arm stands")
            return Runtime(f"{name}, which is not in this file" + (f" or {self.beside}" if self.beside else ""))
        if variable.value is None and variable.declaration is not None:
            variable.value = self._first_value(name, variable.declaration)
        return variable.value

    def _first_value(self, name: str, d: Declaration) -> Value:
        if d.value[0] < 0:
            return Runtime(f"{name}, which has no value")
        self.names[name].value = Runtime(f"{name}, which is declared by itself")
        try:
            return Expression(self.text[slice(*d.value)], self).whole()
        except ExpressionError as e:
            self.refuse(d.start, f"{d.name}: {e}")

    def _call(self, name: str) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            self.refuse(self._here, f"subprograms call each other more than {_DEEPEST} deep")
        self._called.add(name)
        with contextlib.suppress(_FinishedError):
            self._body(self.routines[name])
        self._depth -= 1

    def _body(self, body: list[Statement]) -> None:
        for s in body:
            self._here = s.start
            self._left -= 1
            if self._left < 0:
                self.refuse(s.start, "the program runs too many lines for its length")
            if s.kind == PLAIN:
                self._line(s)
            elif s.kind == COMMENT:
                if s.end > s.start:
                    text = self.text[s.start + 1 : s.end].strip()
                    self.track.event(comment_word(plain_text(text)), self.line(s.start))
            elif s.kind == LOOP:
                self._run_loop(s)
            else:
                self._run_choice(s)

    def _line(self, s: Statement) -> None:
        if motion := MOTION.match(self.text, s.start, s.end):
            self.mover.move(motion, s)
            return
        text = self.text[s.start : s.end]
        if match := _BAS.match(text):
            self._bas(s, match[1].upper(), match[2] or "")
        elif _HARMLESS.match(text):
            pass
        elif match := _ASSIGN.match(text):
            self._assign(s, match)
            return
        elif text.upper() == "RETURN":
            raise _FinishedError
        elif match := _CALL.match(text):
            name = match[1].upper()
            if name in self.routines and not match[2].strip():
                self._call(name)
                return
            self._refuse_unknown_call(s, match)
        else:
            self.refuse(s.start, f"{text[:40]!r} is no line of KRL that is known", _REMEDY)
        self.track.event(comment_word(plain_text(text)), self.line(s.start))

    def _refuse_unknown_call(self, s: Statement, match: re.Match[str]) -> None:
        name = match[1]
        if name.upper() in self.routines or not self._without_poses(match[2]):
            self.refuse(s.start, f"{name}(...) is a subprogram with arguments", _REMEDY)
        if len(name) > 100:  # more than a file may be called
            self.refuse(s.start, f"{name[:40]!r}... is no name of KRL", _REMEDY)
        for suffix in (".src", ".SRC"):
            if (other := self.path.with_name(name + suffix)).is_file():
                self.refuse(s.start, f"{name}() stands in {other.name}", "Put its moves into this file.")
        if name.upper() not in _HARMLESS_CALLS:
            self.elsewhere.setdefault(name, self.line(s.start))
            for given in match[2].upper().split(","):  # a parameter may be OUT
                if given.strip() in self.names:
                    unknown = Runtime(f"{given.strip()}, which {name} may set (line {self.line(s.start)})")
                    self.names[given.strip()] = Variable(unknown, None)

    def _without_poses(self, rest: str) -> bool:
        """Whether arguments are numbers, texts and words only: of what else they are, one may be where the arm goes."""
        e = Expression(rest, self)
        while e.peek():
            declared = self.declared.get(e.peek().upper())
            plain = declared is not None and declared.type in ("INT", "REAL", "BOOL", "CHAR")
            if not isinstance(e.value(), float | bool | str) and not plain:
                return False
            if e.peek():
                e.take(",")
        return True

    def _assign(self, s: Statement, match: re.Match[str]) -> None:
        name = match[1].upper()
        if match[2].strip():
            name += Expression(match[2], self).index()
        if _STEERING.match(name):
            self.refuse(s.start, f"{name} corrects the path while it runs", _REMEDY)
        value = Expression(match[4], self).whole()
        if isinstance(value, Runtime) and "(line " not in value.reason:
            value = Runtime(f"{value.reason} (line {self.line(s.start)})"[:200])
        parts = [p.strip().upper() for p in match[3].split(".")[1:]]
        if name == "$VEL" and parts == ["CP"]:
            self.mover.check_speed(s.start, value)
        if parts and (not name.startswith("$") or name in ("$TOOL", "$BASE", "$LOAD")):
            self.names[name] = Variable(_with(self.look_up(name), parts, value), None)
        else:
            self.names[".".join([name, *parts])] = Variable(value, None)
            if name == "$VEL" and not parts:
                self.names.pop("$VEL.CP", None)
        if name in ("$TOOL", "$BASE", "$LOAD", "$VEL", "$APO", "$IPO_MODE"):
            if numbered := _NUMBERED.match(match[4]):
                self.mover.mounted.numbers[name] = int(numbered[2])
            elif name in ("$TOOL", "$BASE"):
                self.mover.mounted.numbers[name] = None
            self.mover.forget()

    def _bas(self, s: Statement, what: str, rest: str) -> None:
        """What BAS.SRC does to speed, tool and base; the rest of it is of no concern."""
        if what in ("VEL_CP", "CP_PARAMS") and rest:
            value = Expression(rest.split(",")[0], self).whole()
            self.names["$VEL.CP"] = Variable(value, None)
        if what in ("TOOL", "BASE"):
            self._mount("$" + what, Expression(rest, self).whole())
        elif what in ("FRAMES", "CP_PARAMS", "PTP_PARAMS"):
            data = self.look_up("FDAT_ACT")
            if isinstance(data, dict):
                if data.get("IPO_FRAME", "#BASE") != "#BASE":
                    self.refuse(s.start, f"IPO_FRAME {data['IPO_FRAME']}: a tool that stands still", _REMEDY)
                self._mount("$TOOL", data.get("TOOL_NO", 0.0))
                self._mount("$BASE", data.get("BASE_NO", 0.0))
        self.mover.forget()

    def _mount(self, name: str, number: Value) -> None:
        if not isinstance(number, float) or not 0 <= number < 1000:
            self.names[name] = Variable(Runtime(f"{name} of a number that is not known"), None)
            self.mover.mounted.numbers[name] = None
            return
        value = dict(NULL) if number == 0 else self.look_up(f"{name[1:]}_DATA[{number:g}]")
        self.names[name] = Variable(value, None)
        self.mover.mounted.numbers[name] = int(number)

    def _run_loop(self, s: Statement) -> None:
        values = [Expression(t, self).whole() for t in (s.terms[1:] if s.terms[3] else s.terms[1:3])]
        for value in values:
            if isinstance(value, Runtime):
                self.refuse(s.start, f"the loop runs from or to {value.reason}: known only at run time", _REMEDY)
            if not isinstance(value, float) or not math.isfinite(value):
                self.refuse(s.start, "FOR needs numbers")
        first, last, step = (*values, 1.0)[:3]
        if step == 0.0:
            self.refuse(s.start, "FOR with STEP 0 never ends")
        while (last - first) * step >= 0.0:
            self.names[s.terms[0]] = Variable(first, None)
            self._left -= 1
            self._body(s.body)
            if self._left < 0:
                self.refuse(s.start, "the program runs too many lines for its length")
            first += step

    def _run_choice(self, s: Statement) -> None:
        for branch in s.body:
            value = Expression(branch.terms[0], self).whole()
            if isinstance(value, Runtime):
                if all(self._idle(b.body) for b in s.body):
                    self.track.event("IF " + comment_word(plain_text(branch.terms[0])), self.line(s.start))
                    return
                self.refuse(s.start, f"what runs depends on {value.reason}: known only at run time", _REMEDY)
            if not isinstance(value, bool):
                self.refuse(s.start, "the condition of IF is not TRUE or FALSE")
            if value:
                self._body(branch.body)
                return

    def _idle(self, body: list[Statement]) -> bool:
        """Whether lines neither move nor set anything that moves depend on."""
        for s in body:
            text = self.text[s.start : s.end].upper()
            free = _HARMLESS.match(text) or text.startswith(("$OUT", "$ANOUT", "$LOOP_MSG", "$LOOP_CONT"))
            if s.kind != COMMENT and not (s.kind == PLAIN and free):
                return False
        return True


def _with(old: Value, parts: list[str], value: Value) -> Value:
    """An aggregate with one component replaced. What is not constant makes the whole not constant."""
    if isinstance(value, Runtime):
        return value
    if isinstance(old, Runtime):
        return old
    if not isinstance(old, dict):
        raise ExpressionError(f"it has no component {parts[0]}")
    inner = value if len(parts) == 1 else _with(old.get(parts[0], {}), parts[1:], value)
    return {**old, parts[0]: inner}
