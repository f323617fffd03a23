"""docs/apt.md: its examples and its lists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.apt.drill_cycle import KINDS
from toolpaths.languages.apt.reader import AptReader
from toolpaths.languages.apt.words import EVENTS, PASSED, REFUSED
from toolpaths.languages.table import LANGUAGES

PAGE = (Path(__file__).parents[2] / "docs" / "apt.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^```(\w+) (?:(\d+) poses|refused in line (\d+))\n(.*?)^```$", PAGE, re.M | re.S)


@pytest.mark.parametrize(("suffix", "poses", "line", "text"), EXAMPLES)
def test_examples(tmp_path: Path, suffix: str, poses: str, line: str, text: str) -> None:
    file = tmp_path / f"part.{suffix}"
    file.write_text(text)
    if poses:
        assert len(read_toolpath(file)) == int(poses)
        return
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert caught.value.line == int(line)


def listed(begin: str) -> set[str]:
    """Words in capitals in the paragraph or item that begins so."""
    text = PAGE[PAGE.index(begin) + len(begin) :]
    text = re.split(r"\n\n|\n- ", re.sub(r"\([^)]*\)", "", text))[0]
    return set(re.findall(r"\b[A-Z][A-Z_]+\b", text))


def test_every_example_is_run_and_every_list_is_whole() -> None:
    assert PAGE.count("\n```") == 2 * len(EXAMPLES) and len(EXAMPLES) >= 7
    assert listed("Kept as events:") == EVENTS
    assert listed("Let pass, because") == PASSED
    assert listed("- **Words**:") == set(REFUSED)
    assert all(f"`{suffix}`" in PAGE for suffix in LANGUAGES["apt"].reads)
    table = PAGE[PAGE.index("## What is read") : PAGE.index("Kept as events")]
    acts = set(AptReader("").acts) - {"$$"}
    assert {word for word in acts if word not in table} == set()
    assert {kind for kind in KINDS if kind not in PAGE} == set()
