"""Filter in place: a program comes back byte by byte, but for the poses of its cutting moves.

Every language has a module ``toolpaths.languages.<language>.filter`` with
``rewrite(source, program, row, path) -> Rewritten``.
"""

from __future__ import annotations

import importlib
import importlib.util
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, cast

from toolpaths.errors import ReadError
from toolpaths.writing.program import WARNING, Finding, Floats, Program

#: The words of the one comment that a rewritten program carries near its top.
MARKER = "compensated by toolpath-compensator"

_MARKED = re.compile(rb"compensated by toolpath-compensator|^[ \t]*[!;]\s*Compensated program ", re.M)

#: A correction below these, m and rad, is none: the numbers stay as they are printed.
SAME_PLACE = 5e-8
SAME_TURN = 2e-8


@dataclass(frozen=True, repr=False)
class Rewritten:
    """A program with other poses.

    Attributes:
        text: the whole file.
        changes: what else than pose numbers changed (poses put in, targets split, arcs made lines), as warnings.
        beside: other files that changed, by suffix: ``((".dat", bytes),)`` for KRL.
    """

    text: bytes
    changes: tuple[Finding, ...] = ()
    beside: tuple[tuple[str, bytes], ...] = ()

    def __repr__(self) -> str:
        return f"Rewritten({len(self.text)} bytes, {len(self.changes)} changes)"


@dataclass(frozen=True)
class Edit:
    """``text[start:end]`` becomes ``new``; with ``start == end`` it is put in."""

    start: int
    end: int
    new: str


class Filter(Protocol):
    """What the module ``<language>_filter`` offers.

    A module may also have ``check(source, path)``, which raises a WriteError before the solve where the file holds
    what cannot be kept, and ``says_turns(source)``: whether the file has words for the orientation of the tool.
    """

    def rewrite(self, source: bytes, program: Program, row: Floats, path: Path) -> Rewritten:
        """The file ``source`` (read from ``path``) with the poses of ``program``; ``row`` is theirs in Toolpath.row.

        Raises:
            WriteError: names the line where a pose cannot be put in place.
        """
        ...


def filter_of(language: str) -> Filter | None:
    """The module that rewrites programs of a language; None where there is none."""
    name = f"toolpaths.languages.{language}.filter"
    if importlib.util.find_spec(name) is None:
        return None
    return cast(Filter, importlib.import_module(name))


def check(language: Filter, source: bytes, path: Path) -> None:
    """Refuse what the filter cannot keep, as far as the file alone shows it."""
    if own := getattr(language, "check", None):
        own(source, path)


def says_turns(language: Filter, source: bytes) -> bool:
    """Whether the file has words for the orientation of the tool."""
    own = getattr(language, "says_turns", None)
    return own is None or bool(own(source))


def refuse_compensated(data: bytes, source: str) -> None:
    """Refuse a program that this product wrote: compensated twice is wrong.

    Raises:
        ReadError: names the line of the marker.
    """
    if found := _MARKED.search(data):
        line = data.count(b"\n", 0, found.start()) + 1
        raise ReadError(source, line, "this program is compensated already", "Give the program as it was before that.")


def calls_elsewhere(elsewhere: Mapping[str, int]) -> Iterator[Finding]:
    """Warnings for calls (name -> line) of what is not in the file."""
    for name, line in elsewhere.items():
        what = f"{name} is not in this file: it is taken to leave the arm where it is"
        yield Finding(WARNING, f"line {line}", what, "its moves are not compensated, if it has any")


def edited(text: str, edits: Iterable[Edit]) -> str:
    """The text with edits made; of edits at one place the first given comes first."""
    pieces, at = [], 0
    for e in sorted(edits, key=lambda e: e.start):
        if e.start < at:
            raise ValueError(f"edits overlap at {e.start}")
        pieces += [text[at : e.start], e.new]
        at = e.end
    return "".join([*pieces, text[at:]])
