"""Q parameters and formulas of HEIDENHAIN Klartext, as far as they are constant.

Functions stand in front of their value without brackets (SIN Q3, SQRT +4); ^ binds before * and /, these before + -.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator

from toolpaths.interpreting.values import ExpressionError, Runtime, first_runtime

Value = float | str | Runtime
NUMBER = r"(?:\d+(?:[.,]\d*)?|[.,]\d+)"
PARAMETER = r"Q[LRS]?\d+"
_TOKEN = re.compile(rf'\s*(?:({PARAMETER})|({NUMBER})|("[^"]*")|([A-Z]+)|([-+*/^%()]))')
_LARGEST, _DEEPEST = 1e12, 40


def _frac(a: float) -> float:
    return a - math.trunc(a)


_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda a: math.sin(math.radians(a)), "COS": lambda a: math.cos(math.radians(a)),
    "TAN": lambda a: math.tan(math.radians(a)), "ASIN": lambda a: math.degrees(math.asin(a)),
    "ACOS": lambda a: math.degrees(math.acos(a)), "ATAN": lambda a: math.degrees(math.atan(a)),
    "SQRT": math.sqrt, "SQ": lambda a: a * a, "ABS": abs, "INT": lambda a: float(math.trunc(a)), "FRAC": _frac,
    "NEG": lambda a: -a, "SGN": lambda a: float((a > 0) - (a < 0)), "LN": math.log, "LOG": math.log10, "EXP": math.exp,
}  # fmt: skip
_PARTS: dict[str, Callable[[float, float], float]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "%": math.fmod, "^": math.pow,
}  # fmt: skip
_CALCULATIONS: dict[int, str] = {0: "", 1: "+", 2: "-", 3: "*", 4: "/"}
_SINGLE: dict[int, str] = {5: "SQRT", 6: "SIN", 7: "COS"}
_JUMPS: dict[str, Callable[[float, float], bool]] = {
    "EQU": operator.eq, "NE": operator.ne, "GT": operator.gt, "LT": operator.lt,
}  # fmt: skip
_OPERAND = rf"([-+]?\s*(?:{PARAMETER}|{NUMBER}))"
_TWO = re.compile(rf"({PARAMETER})\s*=\s*{_OPERAND}\s*(\+|-|\*|/|DIV|LEN|ANG)\s*{_OPERAND}$")
_ONE = re.compile(rf"({PARAMETER})\s*=\s*(?:SQRT|SIN|COS)?\s*{_OPERAND}$")
_JUMP = re.compile(rf'IF\s*{_OPERAND}\s*(EQU|NE|GT|LT)\s*{_OPERAND}\s*GOTO\s*LBL\s*("[^"]*"|\w+)$')
_ASSIGNED = re.compile(rf"({PARAMETER})\s*=\s*(.*)$")


class QParameters:
    """What Q parameters stand for in one program."""

    def __init__(self) -> None:
        self._values: dict[str, Value] = {}

    def look_up(self, name: str) -> Value:
        """The value of a parameter; Runtime where the program gives it none."""
        return self._values.get(_plain(name), Runtime(f"{name}, which has no value in the file"))

    def state(self) -> int:
        """A number that is the same where all parameters are."""
        return hash(tuple((n, v.reason if isinstance(v, Runtime) else v) for n, v in self._values.items()))

    def put(self, name: str, value: Value) -> None:
        """Assign."""
        self._values[_plain(name)] = value

    def forget(self, name: str, by: str) -> None:
        """A parameter gets a value that only the control knows."""
        self._values[_plain(name)] = Runtime(f"{name}, which {by} sets")

    def number(self, text: str) -> float:
        """A number or a parameter with its sign.

        Raises:
            ExpressionError: only the control knows it.
        """
        try:
            value = float(text)
        except ValueError:
            return as_number(self.operand(text))
        return _bounded(value)

    def operand(self, text: str) -> Value:
        """A number or a parameter with its sign."""
        text = text.replace(" ", "")
        if "Q" not in text:
            return _bounded(float(text.replace(",", ".")))
        value = self.look_up(text.lstrip("+-"))
        if isinstance(value, Runtime) or not text.startswith("-"):
            return value
        return -as_number(value)

    def assign(self, text: str) -> bool:
        """Q5 = formula; whether it is one.

        Raises:
            ExpressionError: it cannot be worked out.
        """
        match = _ASSIGNED.match(text)
        if not match:
            return False
        self.put(match[1], Formula(match[2], self.look_up).whole())
        return True

    def function(self, number: int, text: str) -> str | None:
        """FN 0 to FN 13; the label to go to, if it is a jump that is made.

        Raises:
            ExpressionError: another form, or a jump that only the control decides.
        """
        if 9 <= number <= 12:
            return self._jump(text)
        if number in _CALCULATIONS and (match := _TWO.match(text)):
            sign = {"DIV": "/"}.get(match[3], match[3])
            if number == 0 or sign != _CALCULATIONS[number]:
                raise ExpressionError(f"FN {number} with {match[3]}")
            self.put(match[1], _worked(sign, self.operand(match[2]), self.operand(match[4])))
        elif number in (8, 13) and (match := _TWO.match(text)):
            a, b = self.operand(match[2]), self.operand(match[4])
            self.put(match[1], first_runtime(a, b) or _triangle(number, as_number(a), as_number(b)))
        elif (number == 0 or number in _SINGLE) and (match := _ONE.match(text)):
            value = self.operand(match[2])
            self.put(match[1], _applied(_SINGLE[number], value) if number else value)
        else:
            raise ExpressionError(f"FN {number}: {text[:40]!r} is no form of it that is read")
        return None

    def _jump(self, text: str) -> str | None:
        match = _JUMP.match(text)
        if not match:
            raise ExpressionError(f"{text[:40]!r} is no jump that is read")
        a, b = self.operand(match[1]), self.operand(match[3])
        if unknown := first_runtime(a, b):
            raise ExpressionError(f"what runs depends on {unknown.reason}: known only at run time")
        return match[4] if _JUMPS[match[2]](as_number(a), as_number(b)) else None


class Formula:
    """A formula, worked out from left to right.

    Args:
        text: in capitals.
        look_up: the value of a parameter.
    """

    def __init__(self, text: str, look_up: Callable[[str], Value]) -> None:
        self._look_up, self._depth, self._at = look_up, 0, 0
        self._tokens = list(_tokens(text))

    def whole(self) -> Value:
        """Its value.

        Raises:
            ExpressionError: it is no formula, or has no value.
        """
        value = self._sum()
        if self._at < len(self._tokens):
            raise ExpressionError(f"{self._peek()!r} is not expected here")
        return value

    def _peek(self) -> str:
        return self._tokens[self._at] if self._at < len(self._tokens) else ""

    def _chain(self, part: Callable[[], Value], signs: str) -> Value:
        left = part()
        while self._peek() and self._peek() in signs:
            sign = self._take()
            left = _worked(sign, left, part())
        return left

    def _take(self) -> str:
        if self._at >= len(self._tokens):
            raise ExpressionError("a value is expected at the end")
        self._at += 1
        return self._tokens[self._at - 1]

    def _sum(self) -> Value:
        return self._chain(self._product, "+-")

    def _product(self) -> Value:
        return self._chain(self._power, "*/%")

    def _power(self) -> Value:
        return self._chain(self._signed, "^")

    def _signed(self) -> Value:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ExpressionError(f"brackets or signs more than {_DEEPEST} deep")
        word = self._take()
        if word == "-":
            value = _worked("-", 0.0, self._signed())
        elif word == "+":
            value = self._signed()
        elif word == "(":
            value = self._sum()
            if self._take() != ")":
                raise ExpressionError("a bracket is not closed")
        elif word in _FUNCTIONS:
            value = _applied(word, self._signed())
        elif word == "PI":
            value = math.pi
        elif word.startswith("Q"):
            value = self._look_up(word)
        elif word.startswith('"'):
            value = word[1:-1]
        elif word[0].isdigit() or word[0] in ".,":
            value = _bounded(float(word.replace(",", ".")))
        else:
            raise ExpressionError(f"{word!r} is not expected here")
        self._depth -= 1
        return value


def _tokens(text: str) -> Iterator[str]:
    at = 0
    while at < len(text.rstrip()):
        match = _TOKEN.match(text, at)
        if not match:
            raise ExpressionError(f"{text[at : at + 20].strip()!r} cannot be read")
        yield match[0].strip()
        at = match.end()


def _plain(name: str) -> str:
    """Q05 is Q5."""
    letters = name.rstrip("0123456789")
    return f"{letters}{int(name[len(letters) :])}"


def as_number(value: Value) -> float:
    """The number that a value is.

    Raises:
        ExpressionError: it is none, or only the control knows it.
    """
    if isinstance(value, Runtime):
        raise ExpressionError(f"it depends on {value.reason}: known only at run time")
    if isinstance(value, str):
        raise ExpressionError("a text where a number is expected")
    return value


def _bounded(value: float) -> float:
    if not abs(value) < _LARGEST:
        raise ExpressionError(f"a number beyond {_LARGEST:g}")
    return value


def _worked(sign: str, a: Value, b: Value) -> Value:
    if unknown := first_runtime(a, b):
        return unknown
    x, y = as_number(a), as_number(b)
    try:
        return _bounded(_PARTS[sign](x, y))
    except (ZeroDivisionError, ValueError, OverflowError):
        raise ExpressionError(f"{x:g} {sign} {y:g} has no value") from None


def _applied(function: str, value: Value) -> Value:
    if isinstance(value, Runtime):
        return value
    try:
        return _bounded(_FUNCTIONS[function](as_number(value)))
    except (ValueError, OverflowError):
        raise ExpressionError(f"{function} of {value} has no value") from None


def _triangle(number: int, a: float, b: float) -> float:
    """FN 8: the length of a right angle's long side; FN 13: the angle to the first of two sides, 0 to 360 deg."""
    return math.hypot(a, b) if number == 8 else math.degrees(math.atan2(a, b)) % 360.0
