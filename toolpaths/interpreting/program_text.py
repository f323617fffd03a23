"""ProgramText: the text of a robot program, and the statements and declarations in it, each with its place.

A program of several files is one text, a LinkedText: its files one behind the other.
"""

from __future__ import annotations

import re
from array import array
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from toolpaths.columns import blocks
from toolpaths.errors import ReadError

_WORDS = re.compile(r"[A-Za-z_$][\w$]*")
_LINE_END = re.compile(r"[\r\n\f]|$")
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

    def move(self, by: int) -> None:
        """Count its places, and those of what is in it, from elsewhere."""
        self.start, self.end = self.start + by, self.end + by
        for s in self.body:
            s.move(by)


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

    def move(self, by: int) -> None:
        """Count its places from elsewhere."""
        self.start, self.end = self.start + by, self.end + by
        if self.value[0] >= 0:
            self.value = self.value[0] + by, self.value[1] + by


class ProgramText:
    """The text of a program.

    Args:
        text: one character a byte.
        source: the file as the user named it.
    """

    def __init__(self, text: str, source: str) -> None:
        self.text, self.source = text, source
        self._lines = array("I", (m.end() for m in re.finditer(r"\r\n|\n|\r|\f", text)))

    def forget_text(self) -> None:
        """Leave the text to the LinkedText that this is a part of; lines stay known."""
        self.text = ""

    def piece(self, start: int, end: int) -> str:
        """The text from one place to another."""
        return self.text[start:end]

    def line(self, at: int) -> int:
        """The line of a place, counted from 1."""
        return bisect_right(self._lines, at) + 1

    def refuse(self, at: int, problem: str, remedy: str = "") -> NoReturn:
        """Raise ReadError for a place in the text."""
        raise ReadError(self.source, self.line(at), problem, remedy)

    def file(self, at: int) -> str:
        """The name of the file that holds a place, in messages."""
        return self.source


class LinkedText(ProgramText):
    """The texts of the files of a program, one behind the other.

    Attributes:
        parts: what they are, the main one first; places in them count from their own beginning.
        begins: where each part begins in the whole.
    """

    def __init__(self, main: ProgramText) -> None:
        self.parts: tuple[ProgramText, ...] = (main,)
        self.source, self.text, self.begins = main.source, main.text, [0]

    def add(self, part: ProgramText) -> None:
        """One more file; places in the others stay what they are."""
        self.begins.append(len(self.text) + 1)
        self.parts = (*self.parts, part)
        whole, self.text = self.text, ""
        whole += "\n"  # a text that nobody else has grows where it is
        whole += part.text
        self.text = whole

    @property
    def length(self) -> int:
        """Of the whole."""
        return len(self.text)

    def around(self, at: int) -> tuple[str, int]:
        """A text that holds the whole part of a place, and where it begins."""
        return self.text, 0

    def pieces(self, start: int, end: int) -> Iterator[str]:
        """What stands from one place to another, file by file where it is long."""
        yield self.text[start:end]

    def line_before(self, at: int) -> str:
        """The line of a place, up to there."""
        text, begin = self.around(at)
        end = at - begin
        return text[max(text.rfind("\n", 0, end), text.rfind("\r", 0, end)) + 1 : end]

    def line_end(self, at: int) -> int:
        """Where the line of a place ends, before its line end."""
        text, begin = self.around(at)
        found = _LINE_END.search(text, at - begin)
        return begin + (found.start() if found else len(text))

    def words(self, start: int, end: int) -> Iterator[str]:
        """Words from one place to another, in capitals."""
        return (word.upper() for text in self.pieces(start, end) for word in _WORDS.findall(text))

    def text_of(self, k: int) -> str:
        """The text of a part."""
        return self.text[self.begins[k] : self.begins[k + 1] - 1 if k + 1 < len(self.begins) else None]

    def part(self, at: int) -> int:
        """Which part holds a place."""
        return bisect_right(self.begins, at) - 1 if at >= 0 else 0

    def parts_of(self, at: npt.NDArray[np.integer[Any]]) -> npt.NDArray[np.int32]:
        """(N,) which parts hold places (N,)."""
        out = np.empty(len(at), dtype=np.int32)
        for b in blocks(len(at)):
            out[b] = np.searchsorted(self.begins, at[b], side="right") - 1
        return out

    def line(self, at: int) -> int:
        """The line of a place in its file, counted from 1."""
        k = self.part(at)
        return self.parts[k].line(at - self.begins[k])

    def file(self, at: int) -> str:
        """The name of the file that holds a place, in messages."""
        k = self.part(at)
        return self.parts[k].file(at - self.begins[k])

    def refuse(self, at: int, problem: str, remedy: str = "") -> NoReturn:
        """Raise ReadError for a place in the whole."""
        k = self.part(at)
        self.parts[k].refuse(at - self.begins[k], problem, remedy)
