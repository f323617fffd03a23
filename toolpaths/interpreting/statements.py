"""Statements: those of a routine, kept in columns, so that a program of a million moves fits into memory."""

from __future__ import annotations

from array import array
from collections.abc import Iterator

from toolpaths.interpreting.program_text import PLAIN, Statement


class Statements:
    """Statements in a row. Instructions are numbers and made again where they are asked for; others are kept."""

    def __init__(self) -> None:
        self._start, self._length, self._word = array("q"), array("i"), array("i")
        self._words: dict[str, int] = {}
        self._others: dict[int, Statement] = {}

    def __repr__(self) -> str:
        return f"Statements({len(self)})"

    def __len__(self) -> int:
        return len(self._start)

    def __iter__(self) -> Iterator[Statement]:
        words, others = list(self._words), self._others
        for k, (start, length, word) in enumerate(zip(self._start, self._length, self._word, strict=True)):
            yield Statement(PLAIN, start, start + length, words[word]) if word >= 0 else others[k]

    def append(self, s: Statement) -> None:
        """One more at the end."""
        plain = s.kind == PLAIN and not s.body and not s.terms
        if not plain:
            self._others[len(self)] = s
        self._start.append(s.start)
        self._length.append(s.end - s.start)
        self._word.append(self._words.setdefault(s.word, len(self._words)) if plain else -1)

    def move(self, by: int) -> None:
        """Count their places from elsewhere."""
        self._start = array("q", (start + by for start in self._start))
        for s in self._others.values():
            s.move(by)
