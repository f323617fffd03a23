"""Tokens: what expressions of KRL and RAPID share; an expression works them out from left to right."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import Any

from toolpaths.interpreting.values import ExpressionError, first_runtime

_DEEPEST = 40
_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq, "==": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt, "<=": operator.le,
    ">=": operator.ge,
}  # fmt: skip


class Tokens:
    """A piece of text, token by token.

    Args:
        text: the piece.
        pattern: a token; the group ``space`` is skipped.
    """

    def __init__(self, text: str, pattern: re.Pattern[str]) -> None:
        self.at, self._depth = 0, 0
        self.tokens: list[tuple[str, str]] = []
        at = 0
        while at < len(text):
            match = pattern.match(text, at)
            if not match:
                raise ExpressionError(f"{text[at : at + 20]!r} cannot be read")
            if match.lastgroup != "space":
                self.tokens.append((str(match.lastgroup), match[0]))
            at = match.end()

    def value(self) -> Any:
        """The value of what comes next."""
        raise NotImplementedError

    def whole(self) -> Any:
        """The value of the whole piece."""
        value = self.value()
        if self.at < len(self.tokens):
            raise ExpressionError(f"{self.peek()!r} is not expected here")
        return value

    def peek(self, further: int = 0) -> str:
        """A token, upper case; empty at the end."""
        at = self.at + further
        return self.tokens[at][1].upper() if at < len(self.tokens) else ""

    def take(self, expected: str = "") -> str:
        """The next token as written."""
        if self.at >= len(self.tokens) or (expected and self.peek() != expected):
            found = repr(self.tokens[self.at][1]) if self.at < len(self.tokens) else "the end"
            raise ExpressionError(f"{expected or 'a value'!r} expected, found {found}")
        self.at += 1
        return self.tokens[self.at - 1][1]

    def deeper(self) -> None:
        """One bracket more; refused where they are too many."""
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ExpressionError(f"brackets more than {_DEEPEST} deep")

    def higher(self) -> None:
        """One bracket less."""
        self._depth -= 1

    def signed(self, primary: Callable[[], Any], negative: Callable[[Any], Any]) -> Any:
        """A value with signs in front."""
        sign = 1
        while self.peek() in ("+", "-"):
            sign = -sign if self.take() == "-" else sign
        value = primary()
        return value if sign > 0 else negative(value)

    def chained(self, part: Callable[[], Any], signs: tuple[str, ...], combine: Callable[[str, Any, Any], Any]) -> Any:
        """Values with ``signs`` between them, combined from left to right."""
        left = part()
        while self.peek() in signs:
            sign = self.take().upper()
            left = combine(sign, left, part())
        return left

    def compared(self, part: Callable[[], Any], words: tuple[str, ...]) -> Any:
        """A value, or the truth of a comparison of two."""
        left = part()
        if self.peek() not in words:
            return left
        compare, right = _COMPARE[self.take()], part()
        if unknown := first_runtime(left, right):
            return unknown
        try:
            return compare(left, right)
        except TypeError:
            raise ExpressionError("values of different kinds are compared") from None
