"""Expressions of RAPID, worked out where they consist of constants."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from toolpaths.interpreting.expressions import Tokens
from toolpaths.interpreting.values import ExpressionError, Runtime, first_runtime
from toolpaths.languages.rapid.values import FUNCTIONS, RECORDS, Value, fits

_TOKEN = re.compile(
    r'(?P<space>[\s\x1a]++|![^\n\r]*+)|(?P<number>(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d++)?)'
    r'|(?P<name>[A-Za-z_]\w*+)|(?P<string>"(?:[^"\n\r]|"")*+")|(?P<mark>:=|<=|>=|<>|[-+*/=<>,()\[\]{}.\\])'
)
_COMPARED = ("=", "<>", "<", ">", "<=", ">=")


class RapidExpression(Tokens):
    """A piece of text, worked out from left to right.

    Args:
        look_up: type and value of a name.
    """

    def __init__(self, text: str, look_up: Callable[[str], tuple[str, Value]]) -> None:
        super().__init__(text, _TOKEN)
        self._look_up = look_up

    def value(self) -> Value:
        """OR, XOR, AND, NOT, comparison, sum."""
        self.deeper()
        value = self.chained(self._all, ("OR", "XOR"), _logic)
        self.higher()
        return value

    def _all(self) -> Value:
        return self.chained(self._not, ("AND",), _logic)

    def _not(self) -> Value:
        if self.peek() != "NOT":
            return self._comparison()
        self.take()
        value = self._comparison()
        return value if isinstance(value, Runtime) else not _truth(value)

    def _comparison(self) -> Value:
        return self.compared(self._sum, _COMPARED)

    def _sum(self) -> Value:
        return self.chained(self._product, ("+", "-"), _sum)

    def _product(self) -> Value:
        return self.chained(self._signed, ("*", "/", "DIV", "MOD"), _product)

    def _signed(self) -> Value:
        return self.signed(self._primary, lambda v: _product("*", -1.0, v))

    def _primary(self) -> Value:
        if self.at >= len(self.tokens):
            raise ExpressionError("a value is missing")
        kind, word = self.tokens[self.at]
        if kind == "number":
            self.at += 1
            return float(word)
        if kind == "string":
            self.at += 1
            return word[1:-1]
        if kind == "name":
            return self._named()
        close = {"[": "]", "(": ")"}.get(word)
        if close is None:
            raise ExpressionError(f"{word!r} where a value is expected")
        self.at += 1
        values = [self.value()]
        while close == "]" and self.peek() == ",":
            self.at += 1
            values.append(self.value())
        self.take(close)
        return values if close == "]" else values[0]

    def _named(self) -> Value:
        name = self.take()
        if name.upper() in ("TRUE", "FALSE"):
            return name.upper() == "TRUE"
        if self.peek() == "(":
            return self._call(name)
        kind, value = self._look_up(name)
        while self.peek() in (".", "{"):
            kind, value = self._part(kind, value, name)
        return value

    def _part(self, kind: str, value: Value, name: str) -> tuple[str, Value]:
        if self.take() == "{":
            indices = [self.value()]
            while self.peek() == ",":
                self.take()
                indices.append(self.value())
            self.take("}")
            for index in indices:
                value = item(value, index, name)
            return kind, value
        part = self.take().lower()
        place, inner = component(kind, part)
        return inner, value if isinstance(value, Runtime) else value[place]

    def _call(self, name: str) -> Value:
        self.take("(")
        values: list[Value] = []
        options: dict[str, Value] = {}
        while self.peek() != ")":
            if self.peek() == ",":
                self.take()
            if self.peek() == "\\":
                self.take()
                option = self.take().lower()
                options[option] = self.value() if self.peek() == ":=" and self.take() else True
            elif self.peek() not in (")", ","):
                values.append(self.value())
        self.take(")")
        return _called(name, values, options)


def item(value: Value, index: Value, name: str) -> Value:
    """An element of an array, counted from 1."""
    if unknown := first_runtime(value, index):
        return unknown
    if not isinstance(value, list) or not isinstance(index, float) or not 1 <= index <= len(value) or index % 1:
        raise ExpressionError(f"{name} has no element {index}")
    return value[int(index) - 1]


def component(kind: str, part: str) -> tuple[int, str]:
    """Place and type of a component of a record type."""
    for place, (name, inner) in enumerate(RECORDS.get(kind, ())):
        if name == part:
            return place, inner
    raise ExpressionError(f"{kind} has no component {part}")


def _called(name: str, values: list[Value], options: dict[str, Value]) -> Value:
    if name.lower() not in FUNCTIONS:
        return Runtime(f"{name}(...)")
    if unknown := first_runtime(*values, *options.values()):
        return unknown
    function, kinds = FUNCTIONS[name.lower()]
    for k, value in enumerate(values):
        if not fits(kinds[k] if k < len(kinds) else "num", value):
            raise ExpressionError(f"{name}: argument {k + 1} is not of the right type")
    if not all(math.isfinite(v) for v in _floats([*values, *options.values()])):
        raise ExpressionError(f"{name}: a number that is not finite")
    try:
        return function(*values, **options)
    except (TypeError, ValueError, ArithmeticError) as e:
        raise ExpressionError(f"{name}: {e}") from None


def _floats(value: Value) -> list[float]:
    """Every number in a value."""
    if isinstance(value, list):
        return [number for part in value for number in _floats(part)]
    return [value] if isinstance(value, float) else []


def _truth(value: Value) -> bool:
    if not isinstance(value, bool):
        raise ExpressionError("TRUE or FALSE expected")
    return value


def _logic(word: str, left: Value, right: Value) -> Value:
    if unknown := first_runtime(left, right):
        return unknown
    a, b = _truth(left), _truth(right)
    return (a and b) if word == "AND" else (a or b) if word == "OR" else a != b


def _sum(word: str, left: Value, right: Value) -> Value:
    sign = 1.0 if word == "+" else -1.0
    if unknown := first_runtime(left, right):
        return unknown
    if isinstance(left, float) and isinstance(right, float):
        return left + sign * right
    if isinstance(left, str) and isinstance(right, str) and sign > 0:
        return left + right if len(left) + len(right) <= 1000 else Runtime("a long text")
    if fits("pos", left) and fits("pos", right):
        return [a + sign * b for a, b in zip(left, right, strict=True)]
    raise ExpressionError("+ or - between values that cannot be added")


def _product(word: str, left: Value, right: Value) -> Value:
    if unknown := first_runtime(left, right):
        return unknown
    if fits("pos", left):
        left, right = right, left
    if fits("pos", right) and isinstance(left, float) and word == "*":
        return [left * v for v in right]
    if not isinstance(left, float) or not isinstance(right, float):
        raise ExpressionError(f"{word} between values that are no numbers")
    try:
        if word == "*":
            return left * right
        return left / right if word == "/" else left // right if word == "DIV" else left % right
    except (ZeroDivisionError, OverflowError):
        raise ExpressionError("division by zero") from None
