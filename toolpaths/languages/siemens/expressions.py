"""Expressions of SINUMERIK programs: arithmetic with R parameters and variables, as far as they are constant.

Priorities as in the manual (Job planning, Arithmetic functions): comparisons bind weaker than AND and OR.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from typing import Any

from toolpaths.interpreting.expressions import Tokens
from toolpaths.interpreting.values import ExpressionError, Runtime, first_runtime

Value = float | bool | str | Runtime
#: A letter with its number is one token where no '=' or bracket follows; so is R with its number.
TOKEN = re.compile(
    r'(?P<space>\s+)|(?P<string>"[^"]*")|(?P<address>[A-Z](?:\d+\.?\d*|\.\d+)(?!\d*\s*(?:=(?!=)|[(\[]))(?![\d_]))|'
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:EX[-+]?\d+)?)|(?P<name>[A-Z_$][A-Z0-9_$]*)|(?P<sign><<|<>|<=|>=|==|[-+*/()\[\],=<>:])"
)
_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt, "<=": operator.le, ">=": operator.ge,
}  # fmt: skip
_LARGEST = 1e15


def _trunc_division(a: float, b: float) -> float:
    return float(math.trunc(a / b))


_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "DIV": _trunc_division,
    "MOD": math.fmod,
}  # fmt: skip
_LOGIC: dict[str, Callable[[bool, bool], bool]] = {"AND": operator.and_, "OR": operator.or_, "XOR": operator.xor}
_FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "SIN": (1, lambda a: math.sin(math.radians(a))),
    "COS": (1, lambda a: math.cos(math.radians(a))),
    "TAN": (1, lambda a: math.tan(math.radians(a))),
    "ASIN": (1, lambda a: math.degrees(math.asin(a))),
    "ACOS": (1, lambda a: math.degrees(math.acos(a))),
    "ATAN2": (2, lambda a, b: math.degrees(math.atan2(a, b))),
    "SQRT": (1, math.sqrt),
    "POT": (1, lambda a: a * a),
    "ABS": (1, abs),
    "TRUNC": (1, lambda a: float(math.trunc(a))),
    "ROUND": (1, lambda a: float(math.floor(a + 0.5))),
    "ROUNDUP": (1, lambda a: float(math.ceil(a))),
    "LN": (1, math.log),
    "EXP": (1, math.exp),
    "MINVAL": (2, min),
    "MAXVAL": (2, max),
    "BOUND": (3, lambda low, high, a: max(low, min(high, a))),
}


class SiemensExpression(Tokens):
    """A block, or a part of one, token by token; what is an expression in it is worked out.

    Args:
        text: in capitals, without comment.
        look_up: the value of a variable by its name; indices in brackets.
    """

    def __init__(self, text: str, look_up: Callable[[str], Value]) -> None:
        super().__init__(text, TOKEN)
        self._look_up = look_up

    def peek(self, further: int = 0) -> str:
        """A token, as it stands; empty at the end."""
        at = self.at + further
        return self.tokens[at][1] if at < len(self.tokens) else ""

    def kind(self, further: int = 0) -> str:
        """What a token is: string, address, number, name, sign; empty at the end."""
        at = self.at + further
        return self.tokens[at][0] if at < len(self.tokens) else ""

    def value(self) -> Value:
        """The value of what comes next."""
        if self.kind() == "number" and (self.kind(1) in ("", "address") or self.peek(1) in (",", ")")):
            return _literal(self.take())  # most values are plain numbers
        return self._comparison()

    def number(self) -> float:
        """A value that is a number.

        Raises:
            ExpressionError: it is none, or only the controller knows it.
        """
        return as_number(self.value())

    def name(self) -> str:
        """A name with its indices, as variables are stored."""
        name = self.take().upper()
        if self.peek() != "[":
            return name
        self.take("[")
        indices = [self._index()]
        while self.peek() == ",":
            self.take(",")
            indices.append(self._index())
        self.take("]")
        return f"{name}[{','.join(indices)}]"

    def _index(self) -> str:
        """One index: a number, or the name of an axis."""
        word, lone = self.peek(), self.kind() == "name" and self.peek(1) in ("]", ",")
        value = self.value()
        if isinstance(value, Runtime) and lone:
            return word
        return value if isinstance(value, str) else f"{as_number(value):g}"

    def skip_brackets(self) -> None:
        """The brackets of a length, as of STRING[32]: they do not matter."""
        self.take("[")
        while self.take() != "]":
            pass

    def _comparison(self) -> Value:
        left = self._joined()
        if self.peek() not in _COMPARE:
            return left
        sign, right = self.take(), self._joined()
        if self.peek() in _COMPARE:
            raise ExpressionError("two comparisons without brackets")
        if unknown := first_runtime(left, right):
            return unknown
        if isinstance(left, str) != isinstance(right, str):
            raise ExpressionError("values of different kinds are compared")
        return _COMPARE[sign](left, right)

    def _joined(self) -> Value:
        return self.chained(self._either, ("<<",), lambda _, a, b: Runtime("a text that is put together"))  # type: ignore[no-any-return]

    def _either(self) -> Value:
        return self.chained(self._xor, ("OR",), _logic)  # type: ignore[no-any-return]

    def _xor(self) -> Value:
        return self.chained(self._both, ("XOR",), _logic)  # type: ignore[no-any-return]

    def _both(self) -> Value:
        return self.chained(self._sum, ("AND",), _logic)  # type: ignore[no-any-return]

    def _sum(self) -> Value:
        return self.chained(self._product, ("+", "-"), _arithmetic)  # type: ignore[no-any-return]

    def _product(self) -> Value:
        return self.chained(self._signed, ("*", "/", "DIV", "MOD"), _arithmetic)  # type: ignore[no-any-return]

    def _signed(self) -> Value:
        if self.peek() == "NOT":
            self.take()
            inner = self._signed()
            if not isinstance(inner, bool | Runtime):
                raise ExpressionError("NOT of a number")
            return inner if isinstance(inner, Runtime) else not inner
        return self.signed(self._primary, lambda v: _arithmetic("-", 0.0, v))  # type: ignore[no-any-return]

    def _primary(self) -> Value:
        kind, word = self.kind(), self.peek()
        if word == "(":
            self.take()
            self.deeper()
            value = self.value()
            self.higher()
            self.take(")")
            return value
        if kind == "string":
            return self.take()[1:-1]
        if kind == "number":
            return _literal(self.take())
        if kind == "address" and word[0] == "R" and word[1:].isdigit():
            self.take()
            return self._look_up(f"R{int(word[1:])}")
        if kind != "name":
            raise ExpressionError(f"a value expected, found {word or 'the end'!r}")
        if word in ("TRUE", "FALSE"):
            self.take()
            return word == "TRUE"
        if word in _FUNCTIONS and self.peek(1) == "(":
            return self._function(self.take().upper())
        name = self.name()
        if self.peek() == "(":
            raise ExpressionError(f"{name}(...) is no function that is known")
        return math.pi if name == "$PI" else self._look_up(name)

    def _function(self, name: str) -> Value:
        count, work = _FUNCTIONS[name]
        self.take("(")
        self.deeper()
        given = [self.value()]
        while self.peek() == ",":
            self.take(",")
            given.append(self.value())
        self.higher()
        self.take(")")
        if len(given) != count:
            raise ExpressionError(f"{name} of {len(given)} values, {count} expected")
        if unknown := first_runtime(*given):
            return unknown
        try:
            return _bounded(work(*map(as_number, given)))
        except (ValueError, OverflowError):
            raise ExpressionError(f"{name} of {', '.join(map(str, given))} has no value") from None


def as_number(value: Value) -> float:
    """The number that a value is.

    Raises:
        ExpressionError: it is none, or only the controller knows it.
    """
    if isinstance(value, Runtime):
        raise ExpressionError(f"it depends on {value.reason}: known only at run time")
    if isinstance(value, str):
        raise ExpressionError("a text where a number is expected")
    return float(value)


def _literal(text: str) -> float:
    return _bounded(float(text.replace("EX", "E")))


def _bounded(value: float) -> float:
    if not abs(value) < _LARGEST:
        raise ExpressionError(f"a number beyond {_LARGEST:g}")
    return value


def _arithmetic(sign: str, a: Value, b: Value) -> Value:
    if unknown := first_runtime(a, b):
        return unknown
    try:
        return _bounded(_ARITHMETIC[sign](as_number(a), as_number(b)))
    except (ZeroDivisionError, ValueError, OverflowError):
        raise ExpressionError(f"{as_number(a):g} {sign} {as_number(b):g} has no value") from None


def _logic(sign: str, a: Value, b: Value) -> Value:
    if unknown := first_runtime(a, b):
        return unknown
    if not (isinstance(a, bool) and isinstance(b, bool)):
        raise ExpressionError(f"{sign} of numbers: comparisons beside it need brackets")
    return _LOGIC[sign](a, b)
