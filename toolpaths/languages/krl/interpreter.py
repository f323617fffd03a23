"""Executes a KRL program as far as everything is constant, and collects the moves."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import replace

from toolpaths.interpreting.interpreter import Interpreter, ReturnedError
from toolpaths.interpreting.program_text import COMMENT, NOTHING, PLAIN, Statement
from toolpaths.interpreting.values import ExpressionError, Runtime, first_runtime
from toolpaths.languages.krl.expressions import NULL, KrlExpression, Value
from toolpaths.languages.krl.moves import MOTION, KrlMover
from toolpaths.languages.krl.names import KrlNames
from toolpaths.languages.krl.program import KrlProgram
from toolpaths.languages.krl.remarks import HARMLESS, QUIET, RUNS, SWALLOWING, swallowed

_ASSIGN = re.compile(r"([$A-Za-z_][\w$]*)((?:\s*\[[^\]]*\])?)((?:\s*\.\s*\w+)*)\s*=(?!=)\s*(.*)$", re.S)
_CALL = re.compile(r"([A-Za-z_][\w$]*)\s*\((.*)\)\s*$", re.S)
_OUTPUT = re.compile(r"\$(OUT|ANOUT|PULSE|CYCFLAG|FLAG)(?![\w$])", re.I)
_STEERING = re.compile(r"(\$POS_CORR|\$VEL_EXT|\$TECH|\$ON_PATH)", re.I)
_BAS = re.compile(r"BAS\s*\(\s*#(\w+)\s*(?:,\s*(.*))?\)\s*$", re.I)
_NUMBERED = re.compile(r"(TOOL_DATA|BASE_DATA)\s*\[\s*(\d+)\s*\]\s*$", re.I)
_HARMLESS_CALLS = {"BAS", "IR_STOPM"}


class KrlInterpreter(Interpreter):
    """One program, executed from its first DEF.

    Attributes:
        names: what names mean.
        mover: what makes moves of motion lines.
        elsewhere: name -> line of the first call of subprograms that are in no file.
    """

    program: KrlProgram
    lines, routines, remedy = "lines", "subprograms", "Post the program with plain LIN, CIRC and PTP."

    def __init__(self, program: KrlProgram) -> None:
        self.names = KrlNames(program)
        self.mover = KrlMover(program, self.names)
        super().__init__(program, self.mover.track)
        self._called: set[tuple[int, str]] = set()
        self.elsewhere: dict[str, int] = {}

    def main(self) -> None:
        """Run the first DEF.

        Raises:
            ReadError: a line that is known only while the program runs.
        """
        first = self.program.first
        try:
            self._call(first, self.program.modules[0].routines[first], 0)
        except ExpressionError as e:
            self.program.refuse(self.here, str(e))
        for number, module in enumerate(self.program.modules):
            for name, body in module.routines.items():
                moving = [s for s in body if s.kind == PLAIN and MOTION.match(self.program.text, s.start, s.end)]
                if (number, name) not in self._called and moving:
                    what = f"DEF {name} moves the arm, and {first} does not call it: two programs in one file"
                    self.program.refuse(moving[0].start, what, "Give one of them.")

    def _call(self, name: str, body: list[Statement], module: int) -> None:
        self._called.add((module, name))
        outer = self.names.module
        self.names.enter(module)
        self.mover.tails.forget()
        self.routine(body)
        self.names.enter(outer)
        self.mover.tails.forget()

    def value(self, text: str) -> Value:
        """The value of an expression."""
        return self.names.value(text)

    def line(self, s: Statement) -> None:
        """A motion, an assignment, a call, or what neither moves nor sets anything."""
        if motion := MOTION.match(self.program.text, s.start, s.end):
            self.mover.move(motion, s)
            return
        text = self.program.text[s.start : s.end]
        if match := _BAS.match(text):
            self._refuse_swallowed(s, text)
            self._bas(s, match[1].upper(), match[2] or "")
        elif HARMLESS.match(text):
            self._refuse_swallowed(s, text)
            self._triggered(s, text)
        elif match := _ASSIGN.match(text):
            self._assign(s, match)
            if not _OUTPUT.match(text):
                return
        elif text.upper() == "RETURN":
            raise ReturnedError
        elif match := _CALL.match(text):
            found = self._routine(s, match[1])
            if found is not None and not match[2].strip():
                self._call(match[1].upper(), *found)
                return
            self._refuse_unknown_call(s, match, known=found is not None)
        else:
            self.program.refuse(s.start, f"{text[:40]!r} is no line of KRL that is known", self.remedy)
        self.remark(s, text, "" if QUIET.match(text) else text)

    def _refuse_swallowed(self, s: Statement, text: str) -> None:
        if problem := swallowed(text):
            self.program.refuse(s.start, problem, SWALLOWING.remedy)

    def _triggered(self, s: Statement, text: str) -> None:
        """What an interrupt or a trigger runs: it must not move the arm; where it is in no file, that is told."""
        match = RUNS.match(text)
        if not match or match[1].upper() in _HARMLESS_CALLS:
            return
        found = self._routine(s, match[1])
        if found is None:
            self.elsewhere.setdefault(match[1], self.program.line(s.start))
        elif self._moves(found[0]):
            problem = f"{match[1]}, which {text.split(None, 1)[0].upper()} runs on the way, moves the arm"
            self.program.refuse(s.start, problem, "Call it between the moves.")

    def _moves(self, body: list[Statement]) -> bool:
        """Whether a motion line stands in a body or in the blocks in it."""
        return any(
            (s.kind == PLAIN and MOTION.match(self.program.text, s.start, s.end)) or self._moves(s.body) for s in body
        )

    def _routine(self, s: Statement, name: str) -> tuple[list[Statement], int] | None:
        """A subprogram, be it in a file beside."""
        if len(name) > 100:  # more than a file may be called
            self.program.refuse(s.start, f"{name[:40]!r}... is no name of KRL", self.remedy)
        return None if name.upper() in _HARMLESS_CALLS else self.program.routine(name.upper(), self.names.module)

    def _refuse_unknown_call(self, s: Statement, match: re.Match[str], *, known: bool) -> None:
        name = match[1]
        if known or not self._without_poses(match[2]):
            self.program.refuse(s.start, f"{name}(...) is a subprogram with arguments", self.remedy)
        if name.upper() not in _HARMLESS_CALLS:
            self.elsewhere.setdefault(name, self.program.line(s.start))
            for given in match[2].upper().split(","):  # a parameter may be OUT
                if self.names.get(given.strip()):
                    unknown = Runtime(f"{given.strip()}, which {name} may set (line {self.program.line(s.start)})")
                    self.names.put(given.strip(), unknown)

    def _without_poses(self, rest: str) -> bool:
        """Whether arguments are numbers, texts and words only: of what else they are, one may be where the arm goes."""
        e = KrlExpression(rest, self.names.look_up)
        while e.peek():
            declared = self.names.declared(e.peek().upper())
            plain = declared is not None and declared.type in ("INT", "REAL", "BOOL", "CHAR")
            if not isinstance(e.value(), float | bool | str) and not plain:
                return False
            if e.peek():
                e.take(",")
        return True

    def _assign(self, s: Statement, match: re.Match[str]) -> None:
        name = match[1].upper()
        if match[2].strip():
            name += KrlExpression(match[2], self.names.look_up).index()
        if _STEERING.match(name):
            self.program.refuse(s.start, f"{name} corrects the path while it runs", self.remedy)
        value = self.value(match[4])
        if isinstance(value, Runtime) and "(line " not in value.reason:
            value = replace(value, reason=f"{value.reason} (line {self.program.line(s.start)})"[:200])
        parts = [p.strip().upper() for p in match[3].split(".")[1:]]
        if name == "$VEL" and parts == ["CP"]:
            self.mover.tails.check_speed(s.start, value)
        if parts and (not name.startswith("$") or name in ("$TOOL", "$BASE", "$LOAD")):
            self.names.put(name, _with(self.names.look_up(name), parts, value))
        else:
            self.names.put(".".join([name, *parts]), value)
            if name == "$VEL" and not parts:
                self.names.drop("$VEL.CP")
        if name in ("$TOOL", "$BASE", "$LOAD", "$VEL", "$APO", "$IPO_MODE"):
            if numbered := _NUMBERED.match(match[4]):
                self.mover.mounted.by_number(name, int(numbered[2]))
            elif name in ("$TOOL", "$BASE"):
                self.mover.mounted.by_number(name, None)
            self.mover.tails.forget()

    def _bas(self, s: Statement, what: str, rest: str) -> None:
        """What BAS.SRC does to speed, tool and base; the rest of it is of no concern."""
        if what in ("VEL_CP", "CP_PARAMS") and rest:
            value = self.value(rest.split(",")[0])
            self.names.put("$VEL.CP", value)
        if what in ("TOOL", "BASE"):
            self._mount("$" + what, self.value(rest))
        elif what in ("FRAMES", "CP_PARAMS", "PTP_PARAMS"):
            data = self.names.look_up("FDAT_ACT")
            if isinstance(data, dict):
                if data.get("IPO_FRAME", "#BASE") != "#BASE":
                    problem = f"IPO_FRAME {data['IPO_FRAME']}: a tool that stands still"
                    self.program.refuse(s.start, problem, self.remedy)
                self._mount("$TOOL", data.get("TOOL_NO", 0.0))
                self._mount("$BASE", data.get("BASE_NO", 0.0))
        self.mover.tails.forget()

    def _mount(self, name: str, number: Value) -> None:
        if not isinstance(number, float) or not 0 <= number < 1000:
            self.names.put(name, Runtime(f"{name} of a number that is not known"))
            self.mover.mounted.by_number(name, None)
            return
        value = dict(NULL) if number == 0 else self.names.look_up(f"{name[1:]}_DATA[{number:g}]")
        self.names.put(name, value)
        self.mover.mounted.by_number(name, int(number))

    def bounds(self, s: Statement) -> tuple[float, float, float]:
        """From, to and step of FOR."""
        values = [self.value(t) for t in (s.terms[1:] if s.terms[3] else s.terms[1:3])]
        for value in values:
            if isinstance(value, Runtime):
                problem = f"the loop runs from or to {value.reason}: known only at run time"
                self.program.refuse(s.start, problem, self.remedy)
            if not isinstance(value, float) or not math.isfinite(value):
                self.program.refuse(s.start, "FOR needs numbers")
        first, last, step = (*values, 1.0)[:3]
        return first, last, step

    def count(self, name: str, value: float) -> None:
        """The variable of FOR gets its next value."""
        self.names.put(name, value)

    def idle(self, body: Iterable[Statement]) -> bool:
        """Whether lines neither move nor set anything that moves depend on."""
        for s in body:
            text = self.program.text[s.start : s.end].upper()
            set_ = text.startswith(("$OUT", "$ANOUT", "$LOOP_MSG", "$LOOP_CONT"))
            free = set_ or (HARMLESS.match(text) and not swallowed(text))
            if s.kind not in (COMMENT, NOTHING) and not (s.kind == PLAIN and free):
                return False
        return True


def _with(old: Value, parts: list[str], value: Value) -> Value:
    """An aggregate with one component replaced. What is not constant makes the whole not constant."""
    if unknown := first_runtime(value, old):
        return unknown
    if not isinstance(old, dict):
        raise ExpressionError(f"it has no component {parts[0]}")
    inner = value if len(parts) == 1 else _with(old.get(parts[0], {}), parts[1:], value)
    return {**old, parts[0]: inner}
