"""docs/apt.md: its lists of words."""

from __future__ import annotations

import re
from pathlib import Path

from toolpaths.languages.apt.drill_cycle import KINDS
from toolpaths.languages.apt.reader import AptReader
from toolpaths.languages.apt.words import EVENTS, PASSED, REFUSED

PAGE = (Path(__file__).parents[4] / "docs" / "apt.md").read_text(encoding="utf-8")


def listed(begin: str) -> set[str]:
    """Words in capitals in the paragraph or item that begins so."""
    text = PAGE[PAGE.index(begin) + len(begin) :]
    text = re.split(r"\n\n|\n- ", re.sub(r"\([^)]*\)", "", text))[0]
    return set(re.findall(r"\b[A-Z][A-Z_]+\b", text))


def test_every_list_is_whole() -> None:
    assert listed("Kept as events:") == EVENTS
    assert listed("Let pass, because") == PASSED
    assert listed("- **Words**:") == set(REFUSED)
    table = PAGE[PAGE.index("## What is read") : PAGE.index("Kept as events")]
    acts = set(AptReader("").acts) - {"$$"}
    assert {word for word in acts if word not in table} == set()
    assert {kind for kind in KINDS if kind not in PAGE} == set()
