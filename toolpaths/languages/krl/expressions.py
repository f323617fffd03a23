"""Expressions of KRL, worked out where they consist of constants; frames and the geometric operator.

Source: KUKA System Software 8.3, Operating and Programming Instructions for System Integrators; KR C2 Expert
Programming 5.2 (aggregates, geometric operator).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from toolpaths.interpreting.expressions import Tokens
from toolpaths.interpreting.values import ExpressionError, OnUnit, Runtime, first_runtime
from toolpaths.rotation import kuka_from_matrix, matrix_from_kuka
from toolpaths.toolpath import Floats

#: A number, a truth, a text, an aggregate (component in upper case -> value), or Runtime.
Value = Any
POSE = ("X", "Y", "Z", "A", "B", "C")
AXES = ("A1", "A2", "A3", "A4", "A5", "A6")
NULL: dict[str, Value] = dict.fromkeys(POSE, 0.0)

_TOKEN = re.compile(
    r"(?P<space>\s++)|(?P<number>(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d++)?)|(?P<name>[$#A-Za-z_][\w$]*+)"
    r'|(?P<string>"[^"]*+")|(?P<bits>\'[^\']*+\')|(?P<mark>==|<>|<=|>=|[-+*/=<>,()\[\]{}:.])'
)
_MACHINE = re.compile(r"MACHINE_DEF\[(\d+)\]", re.I)
_COMPARED = ("==", "<>", "<", ">", "<=", ">=")
_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "ABS": abs, "SQRT": math.sqrt, "SIN": lambda a: math.sin(math.radians(a)),
    "COS": lambda a: math.cos(math.radians(a)), "TAN": lambda a: math.tan(math.radians(a)),
    "ACOS": lambda a: math.degrees(math.acos(a)),
}  # fmt: skip


def frame(value: dict[str, Value]) -> Floats:
    """(4, 4), m, of an aggregate with X ... C (mm, deg); what is not given is 0."""
    numbers = [value.get(k, 0.0) for k in POSE]
    if not all(isinstance(v, float) and math.isfinite(v) for v in numbers):
        raise ExpressionError("a frame with something that is not a finite number")
    out = np.eye(4)
    out[:3, :3] = matrix_from_kuka(np.radians(numbers[3:]))
    out[:3, 3] = np.array(numbers[:3]) * 1e-3
    return out


def aggregate(pose: Floats) -> dict[str, Value]:
    """X ... C, mm and deg, of (4, 4) m."""
    angles = np.degrees(kuka_from_matrix(pose[:3, :3]))
    return dict(zip(POSE, [*(pose[:3, 3] * 1e3).tolist(), *angles.tolist()], strict=True))


class KrlExpression(Tokens):
    """A piece of a line, worked out from left to right.

    Args:
        look_up: the value of a name, upper case, as ``XP1``, ``TOOL_DATA[2]`` or ``$BASE``.
    """

    def __init__(self, text: str, look_up: Callable[[str], Value]) -> None:
        super().__init__(text, _TOKEN)
        self._look_up = look_up

    def value(self) -> Value:
        """OR, AND, NOT, comparison, sum."""
        self.deeper()
        value = self.chained(self._comparison, ("OR", "AND", "EXOR"), _logic)
        self.higher()
        return value

    def _comparison(self) -> Value:
        if self.peek() == "NOT":
            self.take()
            value = self._sum()
            return value if isinstance(value, Runtime) else not value
        return self.compared(self._sum, _COMPARED)

    def _sum(self) -> Value:
        return self.chained(self._product, ("+", "-"), _numbers)

    def _product(self) -> Value:
        return self.chained(self._frames, ("*", "/"), _numbers)

    def _frames(self) -> Value:
        return self.chained(self._signed, (":",), _geometric)

    def _signed(self) -> Value:
        return self.signed(self._primary, lambda v: _numbers("*", -1.0, v))

    def _primary(self) -> Value:
        if self.at >= len(self.tokens):
            raise ExpressionError("a value is missing")
        kind, word = self.tokens[self.at]
        if kind == "name":
            return self._named()
        self.at += 1
        if kind == "number":
            return float(word)
        if kind in ("string", "bits"):
            return word
        if word == "{":
            return self._aggregate()
        if word != "(":
            raise ExpressionError(f"{word!r} where a value is expected")
        value = self.value()
        self.take(")")
        return value

    def _aggregate(self) -> Value:
        self.deeper()
        if self.peek(1) == ":" and self.tokens[self.at][0] == "name":
            self.at += 2
        out: dict[str, Value] = {}
        while self.peek() != "}":
            name = self.take().upper()
            if self.peek() == "[":
                self.take()
                self.take("]")
            if name in out or not re.fullmatch(r"[A-Z_]\w*", name):
                raise ExpressionError(f"{name!r} in an aggregate, or given twice")
            out[name] = self._sum()
            if self.peek() != "}":
                self.take(",")
        self.take("}")
        self.higher()
        return next((v for v in out.values() if isinstance(v, Runtime)), out)

    def _named(self) -> Value:
        name = self.take().upper()
        if name in ("TRUE", "FALSE"):
            return name == "TRUE"
        if name.startswith("#"):
            return name
        if self.peek() == "(":
            return self._called(name)
        while self.peek() == "[":
            name += self.index()
        value = self._look_up(name)
        while self.peek() == ".":
            self.take()
            part = self.take().upper()
            if isinstance(value, Runtime):
                continue
            if not isinstance(value, dict) or part not in value:
                raise ExpressionError(f"{name} has no component {part}")
            value = value[part]
        return value

    def index(self) -> str:
        """An index in brackets as part of a name: ``[2]``."""
        self.take("[")
        if self.peek() == "]":
            self.take()
            return "[]"
        parts = [self.value()]
        while self.peek() == ",":
            self.take()
            parts.append(self.value())
        self.take("]")
        shown = ("?" if isinstance(p, Runtime) or not isinstance(p, float) else f"{p:g}" for p in parts)
        return "[" + ",".join(shown) + "]"

    def _called(self, name: str) -> Value:
        self.take("(")
        machine = _MACHINE.match("".join(word for _, word in self.tokens[self.at : self.at + 4]))
        values: list[Value] = []
        while self.peek() != ")":
            values += [] if self.peek() == "," else [self.value()]
            if self.peek() != ")":
                self.take(",")
        self.take(")")
        if name == "EK" and machine and len(values) == 3 and isinstance(values[2], dict):
            pose = tuple(map(tuple, frame(values[2]).tolist()))
            return OnUnit(f"EK(...) of MACHINE_DEF[{machine[1]}]", unit=int(machine[1]), pose=pose)
        if unknown := first_runtime(*values):
            return unknown
        if name not in _FUNCTIONS or len(values) != 1 or not isinstance(values[0], float):
            return Runtime(f"{name}(...)")
        try:
            return _FUNCTIONS[name](values[0])
        except ValueError as e:
            raise ExpressionError(f"{name}: {e}") from None


def _logic(word: str, left: Value, right: Value) -> Value:
    if unknown := first_runtime(left, right):
        return unknown
    if not isinstance(left, bool) or not isinstance(right, bool):
        raise ExpressionError("TRUE or FALSE expected")
    return (left or right) if word == "OR" else (left and right) if word == "AND" else left != right


def _geometric(_: str, left: Value, right: Value) -> Value:
    """The geometric operator: a frame given in another one."""
    if unknown := first_runtime(left, right):
        return unknown
    if not isinstance(left, dict) or not isinstance(right, dict):
        raise ExpressionError("':' stands between two frames")
    for part in (left, right):
        if missing := [k for k in POSE if k not in part]:
            raise ExpressionError(f"{', '.join(missing)} missing beside ':': all of X, Y, Z, A, B, C are needed")
    return {**right, **aggregate(frame(left) @ frame(right))}


def _numbers(sign: str, left: Value, right: Value) -> Value:
    if unknown := first_runtime(left, right):
        return unknown
    if not isinstance(left, float) or not isinstance(right, float):
        raise ExpressionError(f"{sign} between values that are no numbers")
    if sign == "/" and right == 0.0:
        raise ExpressionError("division by zero")
    return {"+": left + right, "-": left - right, "*": left * right, "/": left / (right or 1.0)}[sign]
