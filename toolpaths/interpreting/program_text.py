"""ProgramText: the text of a robot program, and the statements and declarations in it, each with its place."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import NoReturn

from toolpaths.errors import ReadError

PLAIN, LOOP, CHOICE, COMMENT = "plain", "loop", "choice", "comment"
DATA = "data"  # a declaration inside a routine: it takes effect where it stands
NOTHING = "nothing"  # a label, a declaration that took effect before


@dataclass(slots=True)
class Statement:
    """One instruction, or a block with more inside.

    Attributes:
        kind: PLAIN (any instruction or assignment), LOOP, CHOICE, COMMENT, DATA or NOTHING.
        start, end: place in the text, without blanks and comment around it.
        word: of an instruction its first word, where the language begins with one; the text of a comment.
        body: inside of a loop; branches of a choice.
        terms: of a loop: variable, from, to, step; of a branch: the condition.
    """

    kind: str
    start: int
    end: int
    word: str = ""
    body: list[Statement] = field(default_factory=list)
    terms: tuple[str, ...] = ()


@dataclass(slots=True)
class Declaration:
    """A declared name.

    Attributes:
        type: in the case that the language's types have in this project.
        name: as written.
        start, end: place of the whole declaration.
        value: place of the initial value, (-1, -1) where there is none.
        storage: such as CONST, where the language has it.
        array: whether it has dimensions.
    """

    type: str
    name: str
    start: int
    end: int
    value: tuple[int, int]
    storage: str = ""
    array: bool = False


class ProgramText:
    """The text of a program.

    Args:
        text: one character a byte.
        source: the file as the user named it.
    """

    def __init__(self, text: str, source: str) -> None:
        self.text, self.source = text, source
        self._lines = [m.end() for m in re.finditer(r"\r\n|\n|\r|\f", text)]

    def line(self, at: int) -> int:
        """The line of a place, counted from 1."""
        return bisect_right(self._lines, at) + 1

    def refuse(self, at: int, problem: str, remedy: str = "") -> NoReturn:
        """Raise ReadError for a place in the text."""
        raise ReadError(self.source, self.line(at), problem, remedy)
