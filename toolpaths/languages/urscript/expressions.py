"""Values of URScript expressions that are known before a program runs: numbers, poses, lists, simple arithmetic.

Source: Universal Robots, The URScript Programming Language (expressions, pose_trans, pose_add, pose_inv, d2r).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from toolpaths.interpreting.values import Runtime
from toolpaths.rotation import matrix_from_ur, ur_from_matrix
from toolpaths.toolpath import Floats

_TOKEN = re.compile(
    r'\s*(?:((?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?)|(p\[)|([A-Za-z_]\w*+)|("[^"]*+")|(==|!=|<=|>=|[-+*/%()\[\],=<>]))'
)
_N = r"\s*+(-?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?)\s*+"
_SIX = re.compile(",".join([_N] * 6) + r"\]")  # what stands in most poses
_DEEPEST = 30
LARGEST = 1e9


class _UnknownError(Exception):
    """The value is not known before the program runs; the message names the part that is not."""


@dataclass(frozen=True, eq=False)
class UrPose:
    """Position m and rotation vector rad, in ``frame`` (4, 4) base -> frame, or in the base where that is None.

    ``start`` and ``end`` are the place of its ``p[...]`` in the text, -1 where it was computed.
    """

    numbers: tuple[float, ...]
    start: int = -1
    end: int = -1
    frame: Floats | None = None

    def matrix(self) -> Floats:
        """(4, 4) base -> pose."""
        out = _matrix(self.numbers)
        return out if self.frame is None else np.asarray(self.frame @ out)


@lru_cache(maxsize=256)
def _matrix(numbers: tuple[float, ...]) -> Floats:
    out = np.eye(4)
    out[:3, 3] = numbers[:3]
    out[:3, :3] = matrix_from_ur(np.array(numbers[3:]))
    out.setflags(write=False)
    return out


Value = float | bool | str | UrPose | list["Value"]


class UrExpression:
    """Evaluates a piece of text; what is not known in it makes the whole of it unknown.

    Args:
        text: the whole file.
        start, end: the piece.
        values: what names stand for.
    """

    def __init__(self, text: str, start: int, end: int, values: dict[str, Value | Runtime]) -> None:
        self._text, self._end, self._values = text, end, values
        self.at, self._depth = start, 0

    def _peek(self) -> str:
        """The next token; '' at the end."""
        m = _TOKEN.match(self._text, self.at, self._end)
        return m[0].strip() if m else ""

    def _take(self, expected: str = "") -> str:
        """The next token, which has to be ``expected``."""
        m = _TOKEN.match(self._text, self.at, self._end)
        token = m[0].strip() if m else ""
        if m is None or (expected and token != expected):
            found = self._text[self.at : self._end].strip()[:20]
            raise _UnknownError(f"{found!r} where {expected or 'a value'!r} was expected")
        self.at = m.end()
        return token

    def whole(self) -> Value | Runtime:
        """The value of all of the piece."""
        try:
            value = self._value()
        except _UnknownError as why:
            return Runtime(str(why))
        if rest := self._text[self.at : self._end].strip():
            return Runtime(f"{rest[:20]!r} is computed while the program runs")
        return value

    def arguments(self) -> list[tuple[str, Value]] | Runtime:
        """Arguments of a call behind its bracket: (name or '', value)."""
        try:
            return self._arguments()
        except _UnknownError as why:
            return Runtime(str(why))

    def _value(self) -> Value:
        """A sum."""
        left = self._product()
        while (sign := self._peek()) in ("+", "-"):
            self._take()
            right = self._product()
            left = _number(left) + (1 if sign == "+" else -1) * _number(right)
        return left

    def _arguments(self) -> list[tuple[str, Value]]:
        out: list[tuple[str, Value]] = []
        while self._peek() != ")":
            if out:
                self._take(",")
            at = self.at
            name = self._take()
            if self._peek() == "=":
                self._take()
            else:
                self.at, name = at, ""
            out.append((name, self._value()))
        self._take(")")
        return out

    def _product(self) -> Value:
        left = self._unary()
        while (sign := self._peek()) in ("*", "/"):
            self._take()
            right = _number(self._unary())
            if sign == "/" and right == 0.0:
                raise _UnknownError("a division by 0")
            left = _number(left) * right if sign == "*" else _number(left) / right
        return left

    def _unary(self) -> Value:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise _UnknownError("brackets or signs nested too deep")
        if self._peek() == "-":
            self._take()
            value: Value = -_number(self._unary())
        else:
            value = self._atom()
        self._depth -= 1
        return value

    def _atom(self) -> Value:
        token = self._take()
        if token == "p[":
            return self._pose(self.at - 2)
        if token == "(":
            value = self._value()
            self._take(")")
            return value
        if token == "[":
            return self._list()
        if token[0] == '"':
            return token[1:-1]
        if token[0].isdigit() or token[0] == ".":
            number = float(token)
            if not number <= LARGEST:
                raise _UnknownError(f"{token[:20]!r} is too large")
            return number
        if token[0].isalpha() or token[0] == "_":
            return self._name(token)
        raise _UnknownError(f"{token!r} where a value was expected")

    def _list(self) -> list[Value]:
        out: list[Value] = []
        while self._peek() != "]":
            if out:
                self._take(",")
            out.append(self._value())
        self._take("]")
        return out

    def _pose(self, start: int) -> UrPose:
        if six := _SIX.match(self._text, self.at, self._end):
            self.at = six.end()
            numbers = tuple(_number(float(v)) for v in six.groups())
        else:
            numbers = tuple(_number(v) for v in self._list())
        if len(numbers) != 6:
            raise _UnknownError(f"a pose of {len(numbers)} numbers, 6 expected")
        return UrPose(numbers, start, self.at)

    def _name(self, name: str) -> Value:
        if name in ("True", "False"):
            return name == "True"
        if self._peek() == "(":
            self._take("(")
            return _called(name, [v for _, v in self._arguments()])
        value = self._values.get(name)
        if value is None:
            raise _UnknownError(f"{name} has no value yet")
        if isinstance(value, Runtime):
            raise _UnknownError(f"{name}: {value.reason}")
        while self._peek() == "[":
            value = self._element(name, value)
        return value

    def _element(self, name: str, value: Value) -> Value:
        """``P[2]``: a number of a pose, counted from 0, or an element of a list."""
        self._take("[")
        at = _number(self._value())
        self._take("]")
        if isinstance(value, UrPose) and value.frame is None:
            value = list(value.numbers)
        if not isinstance(value, list) or not 0 <= at < len(value) or at != int(at):
            raise _UnknownError(f"{name} has no element {at:g}")
        return value[int(at)]


def _called(name: str, given: list[Value]) -> Value:
    frame, inner = (given[0], given[1]) if len(given) == 2 else (None, None)
    if name == "pose_trans" and isinstance(frame, UrPose) and isinstance(inner, UrPose):
        if inner.frame is None:
            return UrPose(inner.numbers, inner.start, inner.end, frame.matrix())
        placed = frame.matrix() @ inner.matrix()
        return _computed(placed[:3, :3], placed[:3, 3])
    if name == "pose_add" and isinstance(frame, UrPose) and isinstance(inner, UrPose):
        first, second = frame.matrix(), inner.matrix()
        return _computed(first[:3, :3] @ second[:3, :3], first[:3, 3] + second[:3, 3])
    if name == "pose_inv" and len(given) == 1 and isinstance(given[0], UrPose):
        inverse: Floats = np.linalg.inv(given[0].matrix()).astype(np.float64)
        return _computed(inverse[:3, :3], inverse[:3, 3])
    if name == "get_inverse_kin" and given and isinstance(given[0], UrPose):
        return given[0]
    if name in ("d2r", "r2d") and len(given) == 1:
        return _number(given[0]) * (math.pi / 180.0 if name == "d2r" else 180.0 / math.pi)
    raise _UnknownError(f"{name}() is computed while the program runs")


def _computed(rotation: Floats, position: Floats) -> UrPose:
    return UrPose((*position.tolist(), *ur_from_matrix(rotation).tolist()))


def _number(value: Value) -> float:
    if isinstance(value, bool) or not isinstance(value, float):
        raise _UnknownError("a number was expected")
    if not abs(value) <= LARGEST:
        raise _UnknownError("a number that is too large")
    return value
