"""Findings: how they read, which lines they are about, repeats as one, errors refuse."""

from __future__ import annotations

import pytest

from toolpaths.errors import WriteError
from toolpaths.finding import ERROR, NOTE, WARNING, Finding, merged, refuse_errors


def test_how_a_finding_reads() -> None:
    """Level, place, what, remedy; a note has no level, and where it is about the whole run no place."""
    assert str(Finding(ERROR, "line 3", "a feed of 0", "give one")) == "error: line 3: a feed of 0. give one"
    more = Finding(WARNING, "line 3", "a feed of 0", count=4)
    assert str(more) == "warning: line 3 (and 3 more places): a feed of 0"
    assert str(Finding(NOTE, "gravity", "calibrated out")) == "gravity: calibrated out"
    assert str(Finding(NOTE, "", "nothing is known")) == "nothing is known"


@pytest.mark.parametrize(
    ("place", "lines"),
    [
        ("line 12", (12,)),
        ("a/part 7.nc:12", (12,)),
        ("part.nc:12 (pose 3)", (12,)),
        ("pose 3 (part.nc:12)", (12,)),
        ("tool 2", ()),
        ("part7.nc", ()),
        ("", ()),
    ],
)
def test_lines_of_a_place(place: str, lines: tuple[int, ...]) -> None:
    assert Finding(WARNING, place, "x").lines == lines


def test_repeats_are_one_finding_and_errors_refuse() -> None:
    """At the first place, with all lines; errors come first and are listed with the rest."""
    found = [Finding(WARNING, f"line {n}", "slow", "hurry") for n in (9, 4, 9)]
    (one,) = merged(found)
    assert (one.place, one.count, one.lines) == ("line 9", 3, (4, 9))
    assert refuse_errors("a.mod", found) == (one,)
    with pytest.raises(WriteError, match=r"^a\.mod: the program is refused:\n  error: tool 1: none\n  warning: line 9"):
        refuse_errors("a.mod", [*found, Finding(ERROR, "tool 1", "none")])
