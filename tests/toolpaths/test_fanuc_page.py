"""docs/fanuc.md: its examples."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.oracles.sample_programs import small
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath, write_program
from toolpaths.languages.table import LANGUAGES

LANGUAGE = "fanuc"
SUFFIX = LANGUAGES[LANGUAGE].writes
PAGE = (Path(__file__).parents[2] / "docs" / f"{LANGUAGE}.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^```(\w+) (?:(\d+) poses|refused in line (\d+))\n(.*?)^```$", PAGE, re.M | re.S)
WRITTEN = re.findall(rf"^```{LANGUAGE} written\n(.*?)^```$", PAGE, re.M | re.S)


@pytest.mark.parametrize(("suffix", "poses", "line", "text"), EXAMPLES)
def test_read_or_refused(tmp_path: Path, suffix: str, poses: str, line: str, text: str) -> None:
    file = tmp_path / f"part.{suffix}"
    file.write_text(text)
    if poses:
        assert len(read_toolpath(file)) == int(poses)
        return
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert caught.value.line == int(line)


def test_written(tmp_path: Path) -> None:
    write_program(small(), tmp_path / f"part1{SUFFIX}")
    assert WRITTEN and all(text in (tmp_path / f"part1{SUFFIX}").read_text() for text in WRITTEN)


def test_every_example_is_run() -> None:
    assert PAGE.count("\n```") == 2 * (len(EXAMPLES) + len(WRITTEN)) and len(EXAMPLES) >= 3
