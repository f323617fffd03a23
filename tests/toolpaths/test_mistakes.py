"""What people give by mistake, in every language: each is refused with what it is, and where."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.contracts.test_readers import SAMPLES
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.table import READ

SUFFIXES = {language.name: language.reads for language in READ}

PRINTS = {  # G-code of 3D printers: by a word of its firmware, by the extruder, and named as another language
    "slicer": ";FLAVOR:Marlin\nM140 S60\nM104 S200\nG28 ;Home\nG1 Z15.0 F6000\nG1 X10 Y10 E0.5\nM84\n",
    "extruder": "G21\nG90\nG28\nG1 X10 Y10 Z0.2 F1200\nG1 X20 Y10 E0.5\n",
    "firmware": "G21\nG90\nM82\nG0 X0 Y0 Z1\nG1 X10 F1200\nM30\n",
}
PRINT = {"gcode": {"slicer": (2, "3D printers"), "extruder": (5, "3D printer"), "firmware": (3, "3D printers")}}
TWICE = {"rapid": "Two programs in one file", "csv": "two files in one"}


def refused(tmp_path: Path, language: str, text: str | bytes) -> ReadError:
    file = tmp_path / f"part{SUFFIXES[language][0]}"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert str(caught.value).startswith(str(file))
    return caught.value


@pytest.mark.parametrize("language", SUFFIXES)
@pytest.mark.parametrize("kind", PRINTS)
def test_a_3d_print(tmp_path: Path, language: str, kind: str) -> None:
    caught = refused(tmp_path, language, PRINTS[kind])
    line, words = PRINT.get(language, {}).get(kind, (None, ""))
    assert words in str(caught) and (line is None or caught.line == line)


@pytest.mark.parametrize("language", SUFFIXES)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("labels", [(" HEAD", " branch"), ("", "")])
def test_merge_conflict_markers(tmp_path: Path, language: str, end: str, labels: tuple[str, str]) -> None:
    """The line named is that of the first marker that git wrote; without labels that of the line between."""
    lines = SAMPLES[language].split("\n")
    at = len(lines) // 2
    mixed = [f"<<<<<<<{labels[0]}", lines[at], "=======", lines[at], f">>>>>>>{labels[1]}"]
    caught = refused(tmp_path, language, end.join([*lines[:at], *mixed, *lines[at + 1 :]]))
    assert "merge-conflict marker" in str(caught)
    assert caught.line == at + (1 if labels[0] else 3)


@pytest.mark.parametrize("language", [n for n in SUFFIXES if n != "urscript"])
@pytest.mark.parametrize("between", ["", "\n\n"])
def test_two_programs_in_one_file(tmp_path: Path, language: str, between: str) -> None:
    text = SAMPLES[language]
    caught = refused(tmp_path, language, text + between + text)
    words = str(caught)
    assert TWICE.get(language, "wo programs in one file") in words
    assert caught.line is not None and caught.line >= text.count("\n")


@pytest.mark.parametrize("language", SUFFIXES)
def test_binary_inside_and_another_language(tmp_path: Path, language: str) -> None:
    text = SAMPLES[language]
    assert "binary" in str(refused(tmp_path, language, text[:40].encode() + b"\0\1" + text[40:].encode()))
    caught = refused(tmp_path, language, text[:40].encode() + b"\x02" + text[40:].encode())
    assert "not a text file" in str(caught) and caught.line == text[:40].count("\n") + 1
    for other in SAMPLES:
        if other != language:
            refused(tmp_path, language, SAMPLES[other])


@pytest.mark.parametrize("language", [n for n in SUFFIXES if n not in ("gcode", "csv")])
def test_the_first_lines_of_a_file(tmp_path: Path, language: str) -> None:
    """Cut off after every line but the last two: all these languages have a word for the end."""
    lines = SAMPLES[language].strip("\n").split("\n")
    for end in range(1, len(lines) - 1):
        refused(tmp_path, language, "\n".join(lines[:end]) + "\n")


@pytest.mark.parametrize(
    ("language", "text", "line", "words"),
    [
        ("gcode", "UNITS/MM\nGOTO/0,0,5\nFINI\n", 1, "APT/CL, name the file .apt or .cls"),
        ("gcode", "G21 G90\nCYCLE81(5,0,1,-3)\nM30\n", 2, "'CYCLE' is no word of G-code"),
        ("gcode", "G0 X0 Y0 Z5\nG1 Z-1 F100\nM30\n", 1, "no units"),
        ("gcode", "G17 G90 G71\nG0 X0 Y0 Z5\nM30\n", 1, "write G21 for mm"),
        ("apt", "G21 G90\nG0 X0\nM30\n", 1, "G-code: name the file .nc"),
        ("apt", "GOTO/0,0,5\nFINI\n", None, "no units"),
        ("csv", ";TYPE:Skirt\nG1 X1\n", 1, "unknown column ';TYPE:Skirt'"),
        ("csv", "x_mm;y_mm;z_mm;i;j;k\n0;0;5;0;0;1\n", 1, "not separated by commas"),
    ],
)
def test_what_is_said(tmp_path: Path, language: str, text: str, line: int | None, words: str) -> None:
    caught = refused(tmp_path, language, text)
    assert words in str(caught) and caught.line == line


def test_a_file_without_an_end_word_that_is_whole(tmp_path: Path) -> None:
    """A retract or a spindle stop after the last cut tells that it is."""
    for tail in ("G0 Z5\n", "M5\n", "M9\n(end)\nM5\n"):
        file = tmp_path / "part.nc"
        file.write_text(f"G21 G90\nG0 X0 Y0 Z5\nM3 S100\nG1 Z-1 F100\nX10\n{tail}" + ("M5\n" if "Z5" in tail else ""))
        assert len(read_toolpath(file)) in (3, 4)
