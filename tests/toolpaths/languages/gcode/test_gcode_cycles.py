"""Cycles with words for the spindle, ways by a point (G28), and what declares nothing new."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.linuxcnc import check, installed, reference
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.toolpath import Toolpath

HEAD = "G21 G90 G17\nF600 S500 M3\nG0 X0 Y0 Z20\n"


def read(tmp_path: Path, text: str) -> Toolpath:
    file = tmp_path / "part.ngc"
    file.write_text(HEAD + text + "\nM30\n")
    return read_toolpath(file)


@installed
@pytest.mark.parametrize(
    "text",
    [
        "G99 G84 X5 Y5 Z-3 R2\nX9\nG80", "G98 G86 X5 Y5 Z-3 R2 P.5\nY9",
        "G99 G89 X5 Y5 Z-3 R2 P.5\nY9", "G91 G84 X1 Y1 Z-5 R-3 L3", "G18 G86 X5 Z5 Y-3 R2 P.5",
        "G1 Z5\nG28 G91 Z5\nG90 G0 X1 Y1 Z20", "G1 Z5\nG0 Z9\nG91 G28 Z0\nG90 G0 X1 Y1 Z20\nG53 G0 Z0",
        "G1 Z5\nG30 X1 Y2 Z25\nG0 X1 Y1 Z20", "G1 X5 Z4\nG53 G0 Z0", "G1 Z5\nG28 X1 Y2 Z3",
    ],
)  # fmt: skip
def test_linuxcnc_agrees(tmp_path: Path, text: str) -> None:
    path = read(tmp_path, text)
    ref = reference(tmp_path / "part.ngc")
    # rs274 -g has its homes at zero: no place of the work object
    keep = [k for k, end in enumerate(ref.ends) if ref.cut[k] or end[2] != 0]
    named = {name: getattr(ref, name)[keep] for name in ("ends", "cut", "feed", "spindle")}
    check(path, replace(ref, **named), 1e-4)


def test_what_the_spindle_does_in_the_hole(tmp_path: Path) -> None:
    path = read(tmp_path, "G98 G84 X5 Y5 Z-3 R2 P.5\nG86 Z-4 R2\nG89 Z-5 R2 P2\nG80\nM4\nG84 X5 Z-3 R2")
    found = [(e.word, round(float(path.position[e.pose - 1, 2]) * 1e3, 3)) for e in path.events]
    expected = [
        ("G4 P0.5", -3), ("M4", -3), ("M3", 2), ("M5", -4), ("M3", 20), ("G4 P2", -5),
        ("M4", 20), ("M3", -3), ("M4", 2), ("M30", 20),
    ]  # fmt: skip
    assert found[1:] == expected


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("G10 L2 P1 X1 Y0 Z0", 4, "read is G10 L2 with zeros"),
        ("G10 L1 P1 Z0", 4, "read is G10 L2 with zeros"),
        ("G10 L20 P1 X0", 4, "read is G10 L2 with zeros"),
        ("G53 G1 Z0", 4, "rapid retract"),
        ("G1 X5\nG28 A0 X5", 5, "A0: a rotary axis"),
        ("G1 Z3\nX5 Z-3\nG28 G91 Z2\nG90 G0 X1 Y1 Z20", 6, "travel at Z -1 mm"),
        ("G84 X5 Z-3", 4, "needs R"),
        ("G76 X5 Z-3 R2", 4, "a canned cycle other than"),
        ("G187 X5", 4, "with coordinates"),
        ("G5.1 Q1 X5", 4, "spline"),
        ("G1 X1 E2", 4, "extruder"),
    ],
)
def test_refused(tmp_path: Path, text: str, line: int, words: str) -> None:
    with pytest.raises(ReadError, match=re.escape(words)) as caught:
        read(tmp_path, text)
    assert caught.value.line == line


def test_settings_change_nothing(tmp_path: Path) -> None:
    settings = "G10 L2 P1 X0 Y0. Z0\nG10 L2 P0 X0 Y0 Z0 A0 R0\n"
    settings += "G187 P2 E0.02\nG5.1 Q1 R5\nG5.1 Q0\nG61\nG64 P.01 Q.01\nG61.1"
    plain, with_them = read(tmp_path, "G1 X5"), read(tmp_path, settings + "\nG1 X5")
    np.testing.assert_array_equal(plain.position, with_them.position)


@pytest.mark.parametrize("motion", ["G0", "G1", "G2 X1 Y1 R4\n", "G80"])
def test_g53_is_a_rapid_whatever_is_in_force(tmp_path: Path, motion: str) -> None:
    path = read(tmp_path, f"{motion}\nG53 Z0")
    assert [e.word for e in path.events][-2:] == ["G53 Z0", "M30"]
