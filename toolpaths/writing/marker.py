"""The mark of programs that this project wrote or changed: they are compensated, and compensated twice is wrong."""

from __future__ import annotations

import re
from collections.abc import Sequence

from toolpaths.errors import ReadError

#: The words of the one comment that such a program carries near its top.
MARKER = "compensated by toolpath-compensator"



def marked(stamp: Sequence[str]) -> str:
    """The words of the comment of a program that was changed in place: the mark, and what it was made from."""
    return ", ".join((MARKER, *stamp))


_WORDS = (b"toolpath-compensator", b"Compensated program")  # every mark has one of them
_MARKED = re.compile(
    rb"compensated by toolpath-compensator|^[ \t]*(?:[!;']|//)[ \t]*Compensated program(?=[ \r\n])", re.M
)
_IN_REMARKS = re.compile(
    rb"![ \t]*+(?:Compensated program |compensated by[ \t]*+(?:;[ \t]*+[\r\n]*+[ \t]*+\d*+[ \t]*+:[ \t]*+!)?[ \t]*+"
    rb"toolpath-compensator)"
)


def refuse_compensated(data: bytes, source: str) -> None:
    """Refuse a program with the mark.

    Raises:
        ReadError: names the line of the marker.
    """
    _refuse(_MARKED, data, source)


def refuse_compensated_remarks(data: bytes, source: str) -> None:
    """The same where the marker takes two remarks of a TP program."""
    _refuse(_IN_REMARKS, data, source)


def is_compensated_in_remarks(data: bytes) -> bool:
    """Whether a TP program has the mark."""
    return _IN_REMARKS.search(data) is not None


def _refuse(marked: re.Pattern[bytes], data: bytes, source: str) -> None:
    if not any(words in data for words in _WORDS):  # a pattern takes thirty times as long to find that out
        return
    if found := marked.search(data):
        line = data.count(b"\n", 0, found.start()) + 1
        raise ReadError(source, line, "this program is compensated already", "Give the program as it was before that.")
