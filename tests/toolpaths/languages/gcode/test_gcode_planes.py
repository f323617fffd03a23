"""G68.2 with G53.1: coordinates of a tilted plane, against scipy's Euler angles."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.machine import Machine
from toolpaths.toolpath import Toolpath

HEAD = "G21 G90 G17\nF600\nG0 X0 Y0 Z0\n"
CUT = "G0 X1 Y2 Z30\nG1 Z-3\nG3 X11 Y12 I10\nG98 G81 X5 Y5 Z-4 R1\nG80\nG0 Z30\n"


def read(tmp_path: Path, text: str, machine: Machine | None = None, name: str = "part.nc") -> Toolpath:
    file = tmp_path / name
    file.write_text(HEAD + text + "M30\n")
    return read_toolpath(file, machine=machine)


@pytest.mark.parametrize("angles", [(0, 0, 0), (90, 30, 0), (-25, 60, 140), (10, -90, 20), (180, 45, -180)])
def test_the_plane_is_that_of_its_euler_angles(tmp_path: Path, angles: tuple[float, float, float]) -> None:
    i, j, k = angles
    tilted = read(tmp_path, f"G68.2 X10 Y-20 Z5 I{i} J{j} K{k}\nG53.1\n{CUT}G69\n")
    flat = read(tmp_path, CUT)
    turn = Rotation.from_euler("ZXZ", angles, degrees=True)
    expected = turn.apply(flat.position[1:].copy()) + np.array([0.01, -0.02, 0.005])
    np.testing.assert_allclose(tilted.position[1:], expected, atol=1e-12)
    np.testing.assert_allclose(tilted.axis[1:], np.tile(turn.apply((0, 0, 1)), (len(flat) - 1, 1)), atol=1e-12)
    np.testing.assert_array_equal(tilted.kind, flat.kind)


def test_origins_count(tmp_path: Path) -> None:
    path = read(tmp_path, "G52 X100\nG68.2 X10 Y0 Z0 I0 J90 K0\nG53.1\nG0 X1 Y2 Z3\nG69\nG0 X0 Y0 Z50\n")
    np.testing.assert_allclose(path.position[1:] * 1e3, [(111, -3, 2), (100, 0, 50)], atol=1e-9)
    np.testing.assert_allclose(path.axis[1:], [(0, -1, 0), (0, 0, 1)], atol=1e-12)


def test_rotary_words_beside_it_are_remarks(tmp_path: Path) -> None:
    text = f"G0 A0 C0\nG0 A30 C90\nG68.2 X0 Y0 Z0 I90 J30 K0\nG53.1\n{CUT}G69\n"
    text += "G28 G91 Z0\nG28 A0 C0\nG90\nG0 X0 Y0 Z50\n"
    path = read(tmp_path, text)
    assert [e.word for e in path.events][:2] == ["A0 C0", "A30 C90"]
    np.testing.assert_allclose(path.axis[-1], (0, 0, 1))


TILT = "G68.2 X0 Y0 Z0 I0 J30 K0\n"


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (TILT + "G0 X1 Y1 Z1\n", 5, "between G68.2 and G53.1"),
        (TILT + "G53.1\nG1 X5\n", 6, "where Y, Z is, is not known"),
        (TILT + TILT, 5, "on top of G68.2"),
        ("G53.1\n", 4, "G53.1 without G68.2"),
        (TILT.replace("X0", "P1 X0"), 4, "G68.2 P1"),
        (TILT.replace("X0", "Q1 X0"), 4, "Q1"),
        (TILT + "G92 X0\n", 5, "G92 under G68.2"),
        (TILT + "G55\n", 5, "G55 under G68.2"),
        (TILT + "G53.1\nG43.4 H1\nG0 X1 Y1 Z1\n", 7, "G43.4 under G68.2"),
        (TILT + "G41.1 D1\n", 5, "without tilted axes"),
        ("G0 A30\nG1 X5\n" + TILT, 5, "in no tilted plane while the rotary axes stand at A30"),
        ("G0 A30 X5\n" + TILT, 4, "read only as rapids in a block of their own"),
        ("G1 A30\n" + TILT, 4, "read only as rapids in a block of their own"),
        (TILT + "G53.1\nG0 X0 Y0 Z5\nG1 X9\nG69\nG28 G91 Z0\nG90\nG0 X0 Y0 Z-50\n", 9,
         "travel at Z -50 mm, cuts reach up to Z 4.33013 mm"),
    ],
)  # fmt: skip
def test_refused(tmp_path: Path, text: str, line: int, words: str) -> None:
    with pytest.raises(ReadError, match=re.escape(words)) as caught:
        read(tmp_path, text)
    assert caught.value.line == line


def test_a_retract_in_a_plane_looks_along_the_tool(tmp_path: Path) -> None:
    away = f"{TILT.replace('J30', 'J90')}G53.1\n{CUT}G69\nG28 G91 Z0\nG90\n"
    again = f"{TILT.replace('J30', 'J90')}G53.1\n{CUT}"
    assert len(read(tmp_path, away + again)) > 20
    with pytest.raises(ReadError, match="the tool would travel"):
        read(tmp_path, away + again.replace("Z30", "Z-3.5"))
