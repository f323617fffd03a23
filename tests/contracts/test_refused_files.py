"""One suite over all readers: what is refused, each with the line and what stands there; and spellings that are not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.contracts.samples import READ, to_read
from tests.oracles.patience import not_hanging
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath

PRINTS = {  # G-code of 3D printers: by a word of its firmware, by the extruder, and named as another language
    "slicer": ";FLAVOR:Marlin\nM140 S60\nM104 S200\nG28 ;Home\nG1 Z15.0 F6000\nG1 X10 Y10 E0.5\nM84\n",
    "extruder": "G21\nG90\nG28\nG1 X10 Y10 Z0.2 F1200\nG1 X20 Y10 E0.5\n",
    "firmware": "G21\nG90\nM82\nG0 X0 Y0 Z1\nG1 X10 F1200\nM30\n",
}


def cases(field: str) -> list[Any]:
    """A case each of every sample, called by what is expected of it."""
    return [
        pytest.param(name, *case, id=f"{name}-{case[-1]}")
        for name, sample in READ.items()
        for case in getattr(sample, field)
    ]


def refused(tmp_path: Path, language: str, text: str | bytes) -> ReadError:
    file = to_read(tmp_path, language, text)
    with not_hanging(), pytest.raises(ReadError) as caught:
        read_toolpath(file)
    line = "" if caught.value.line is None else f":{caught.value.line}"
    assert str(caught.value).startswith(f"{file}{line}")
    return caught.value


@pytest.mark.parametrize(("language", "text", "line", "words"), cases("refused"))
def test_refused_by_line(tmp_path: Path, language: str, text: str, line: int | None, words: str) -> None:
    """What cannot be read or only the controller knows, values that may have changed, moves that would be lost."""
    caught = refused(tmp_path, language, text)
    assert caught.line == line and words in str(caught)


@pytest.mark.parametrize(("language", "text", "words"), cases("mistakes"))
def test_mistakes(tmp_path: Path, language: str, text: str | bytes, words: str) -> None:
    assert words in str(refused(tmp_path, language, text))


@pytest.mark.parametrize(("language", "text", "last"), cases("spelled"))
def test_spellings_of_real_posts_are_read(
    tmp_path: Path, language: str, text: str, last: tuple[float, float, float]
) -> None:
    path = read_toolpath(to_read(tmp_path, language, text))
    assert len(path) == 2
    np.testing.assert_allclose(path.position[-1] * 1e3, last, atol=1e-9)


@pytest.mark.parametrize("language", READ)
@pytest.mark.parametrize("kind", PRINTS)
def test_a_3d_print(tmp_path: Path, language: str, kind: str) -> None:
    caught = refused(tmp_path, language, PRINTS[kind])
    line, words = READ[language].printed.get(kind, (None, ""))
    assert words in str(caught) and (line is None or caught.line == line)


@pytest.mark.parametrize("language", READ)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("labels", [(" HEAD", " branch"), ("", "")])
def test_merge_conflict_markers(tmp_path: Path, language: str, end: str, labels: tuple[str, str]) -> None:
    """The line named is that of the first marker that git wrote; without labels that of the line between."""
    lines = READ[language].text.split("\n")
    at = len(lines) // 2
    mixed = [f"<<<<<<<{labels[0]}", lines[at], "=======", lines[at], f">>>>>>>{labels[1]}"]
    caught = refused(tmp_path, language, end.join([*lines[:at], *mixed, *lines[at + 1 :]]))
    assert "merge-conflict marker" in str(caught)
    assert caught.line == at + (1 if labels[0] else 3)


@pytest.mark.parametrize("language", [n for n, sample in READ.items() if sample.twice])
@pytest.mark.parametrize("between", ["", "\n\n"])
def test_two_programs_in_one_file(tmp_path: Path, language: str, between: str) -> None:
    text = READ[language].text
    caught = refused(tmp_path, language, text + between + text)
    assert READ[language].twice in str(caught)
    assert caught.line is not None and caught.line >= text.count("\n")


@pytest.mark.parametrize("language", READ)
def test_binary_inside_and_another_language(tmp_path: Path, language: str) -> None:
    text = READ[language].text
    assert "binary" in str(refused(tmp_path, language, text[:40].encode() + b"\0\1" + text[40:].encode()))
    caught = refused(tmp_path, language, text[:40].encode() + b"\x02" + text[40:].encode())
    assert "not a text file" in str(caught) and caught.line == text[:40].count("\n") + 1
    for other, sample in READ.items():
        if other != language:
            refused(tmp_path, language, sample.text)


@pytest.mark.parametrize("language", [n for n, sample in READ.items() if sample.end_word])
def test_the_first_lines_of_a_file(tmp_path: Path, language: str) -> None:
    """Cut off after every line but the last two: all these languages have a word for the end."""
    lines = READ[language].text.strip("\n").split("\n")
    for end in range(1, len(lines) - 1):
        refused(tmp_path, language, "\n".join(lines[:end]) + "\n")
