"""Moves that a statement without its end swallows: what is kept as a remark or a setting must hold none.

A remark takes any text. Where the end of a statement is missing (';', a line of its own), or a continuation mark is
left over, the next statement becomes part of that text, and a cut would vanish without a word.
"""

from __future__ import annotations

import re
from typing import NamedTuple

_QUOTED = re.compile(r'"[^"\r\n]*+(?:"|$)')
_BRACKET = re.compile(r"[()]")
REMEDY = "Give each statement its own line"


class Swallowing(NamedTuple):
    """How a language's moves look in a text that is to hold none.

    Attributes:
        moves: the begin of a statement that moves the arm, or runs what may.
        remedy: how statements end.
    """

    moves: re.Pattern[str]
    remedy: str = f"{REMEDY}."

    def problem(self, text: str, at: int = 0) -> str:
        """What is wrong with a text that is kept as it is; empty where no move stands in it from ``at`` on.

        Texts in double quotes count as text.
        """
        if found := self.moves.search(without_quotes(text), at):
            return f"{shown(text)!r} holds the statement {shown(text[found.start() :], 30)!r}, which would be lost"
        return ""

    def refuse(self, text: str, at: int = 0) -> None:
        """Raise ValueError, with its remedy, where a move stands in a text that is kept as it is."""
        if problem := self.problem(text, at):
            raise ValueError(problem, self.remedy)


def without_quotes(text: str) -> str:
    """The text with blanks for what stands in double quotes: places stay what they are."""
    return _QUOTED.sub(lambda m: '"' + " " * (len(m[0]) - 1), text) if '"' in text else text


def behind_call(text: str) -> str:
    """What stands behind the bracket that closes the first one; empty where none is closed."""
    depth, plain = 0, without_quotes(text)
    for m in _BRACKET.finditer(plain):
        depth += 1 if m[0] == "(" else -1
        if depth <= 0:
            return text[m.end() :].strip()
    return ""


def shown(text: str, most: int = 50) -> str:
    """A text on one line, cut."""
    plain = " ".join(text.split())
    return plain if len(plain) <= most else f"{plain[: most - 3]}..."
