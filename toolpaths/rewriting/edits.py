"""Edits: numbers and lines of a program's text, changed with as little trace as can be."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

Places = npt.NDArray[np.integer[Any]]


@dataclass(frozen=True)
class Edit:
    """``text[start:end]`` becomes ``new``; with ``start == end`` it is put in."""

    start: int
    end: int
    new: str


def edited(text: str, edits: Iterable[Edit]) -> str:
    """The text with edits made; of edits at one place the first given comes first."""
    pieces, at = [], 0
    for e in sorted(edits, key=lambda e: e.start):
        if e.start < at:
            raise ValueError(f"edits overlap at {e.start}")
        pieces += [text[at : e.start], e.new]
        at = e.end
    return "".join([*pieces, text[at:]])


def edited_parts(texts: Sequence[str], begins: Sequence[int], edits: Iterable[Edit]) -> list[str]:
    """The texts of a program's files, which stand one behind the other from ``begins`` on, each with its edits made."""
    own: list[list[Edit]] = [[] for _ in texts]
    for e in edits:
        k = bisect_right(begins, e.start) - 1
        own[k].append(Edit(e.start - begins[k], e.end - begins[k], e.new))
    return [edited(text, mine) for text, mine in zip(texts, own, strict=True)]


def parts_to_write(begins: Sequence[int], places: Places, edits: Iterable[Edit]) -> list[int]:
    """Parts of a program that hold one of ``places`` (of moves), or an edit; the first in any case."""
    moving = np.unique(np.searchsorted(begins, places, side="right") - 1).tolist()
    return sorted({0, *moving, *(bisect_right(begins, e.start) - 1 for e in edits)})


class MadeFiles(Sequence[tuple[str, bytes]]):
    """Names and contents of files that are made when they are asked for: one at a time is held.

    Args:
        names: of the files.
        make: number -> content.
    """

    def __init__(self, names: Sequence[str], make: Callable[[int], bytes]) -> None:
        self._names, self._make = tuple(names), make

    def __repr__(self) -> str:
        return f"MadeFiles({len(self)})"

    def __len__(self) -> int:
        return len(self._names)

    @overload
    def __getitem__(self, k: int) -> tuple[str, bytes]: ...
    @overload
    def __getitem__(self, k: slice) -> Sequence[tuple[str, bytes]]: ...
    def __getitem__(self, k: int | slice) -> tuple[str, bytes] | Sequence[tuple[str, bytes]]:
        if isinstance(k, slice):
            return [self[number] for number in range(*k.indices(len(self)))]
        return self._names[k], self._make(k)


def respelled(match: re.Match[str], values: Sequence[float], decimals: Sequence[int], first: int = 1) -> str:
    """A literal with the numbers of groups ``first``, ... replaced, those that print the same left as they are."""
    literal, start = match[0], match.start()
    pieces, at = [], 0
    for group, (value, least) in enumerate(zip(values, decimals, strict=True), start=first):
        old = match[group]
        digits = max(least, len(old.partition(".")[2]) if "e" not in old.lower() else 0)
        if abs(float(old) - value) < 0.5 * 10.0**-least:
            continue
        new = f"{value:.{digits}f}"
        new = new.lstrip("-") if float(new) == 0.0 else new
        pieces += [literal[at : match.start(group) - start], new]
        at = match.end(group) - start
    return "".join([*pieces, literal[at:]])


def newline_of(text: str) -> str:
    """The line end that a text uses first."""
    found = re.search(r"\r\n|\n|\r", text)
    return found[0] if found else "\n"


def line_end(text: str, at: int) -> int:
    """Where the line of a place ends, behind its line end."""
    found = re.compile(r"\r\n|\n|\r|$").search(text, at)
    return found.end() if found else len(text)
