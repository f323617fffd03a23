"""G41 and G42 with a radius that is known, and corners ,R and ,C."""

from __future__ import annotations

import math
import random
import re
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.linuxcnc import check, installed, reference
from tests.oracles.random_contours import contour
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.machine import Machine
from toolpaths.toolpath import Toolpath

HEAD = "G21 G90 G17\nF600\nG0 X0 Y0 Z0\n"
SQUARE = "D1 X10 Y10\nX30\nY30\nX10\nY10\nG40 X0 Y0"


def read(tmp_path: Path, text: str, machine: Machine | None = None) -> Toolpath:
    file = tmp_path / "part.nc"
    file.write_text(HEAD + text + "\nM30\n")
    return read_toolpath(file, machine=machine)


@installed
@pytest.mark.parametrize("first", [0, 40, 80])
def test_random_contours_agree(tmp_path: Path, first: int) -> None:
    agreed = 0
    for seed in range(first, first + 40):
        file = tmp_path / f"{seed}.ngc"
        file.write_text(contour(seed, 5))
        try:
            ref = reference(file)
        except ReadError:
            with pytest.raises(ReadError):
                read_toolpath(file)
            continue
        check(read_toolpath(file), ref, 1.5e-4)
        agreed += 1
    assert agreed > 25


def test_inside_a_square(tmp_path: Path) -> None:
    path = read(tmp_path, "G41 G1 " + SQUARE, Machine(radii={1: 2e-3}))
    expected = [(28, 12), (28, 28), (12, 28), (12, 10), (0, 0)]
    np.testing.assert_allclose(path.position[-5:, :2] * 1e3, expected, atol=1e-9)


def test_outside_a_square(tmp_path: Path) -> None:
    path = read(tmp_path, "G42 G1 " + SQUARE, Machine(radii={1: 2e-3}))
    out = path.position[1:-1, :2] * 1e3
    away = np.hypot(*np.maximum(np.abs(out - 20) - 10, 0).T)
    np.testing.assert_allclose(away, 2, atol=1e-9)
    assert len(out) > 20  # arcs round the corners


def test_a_radius_of_zero_is_the_programmed_path(tmp_path: Path) -> None:
    path = read(tmp_path, "G42 G1 " + SQUARE, Machine(radii={1: 0.0}))
    np.testing.assert_array_equal(path.position, read(tmp_path, "G1 " + SQUARE.replace("D1 ", "")).position)


def test_the_number_of_the_tool_is_the_register(tmp_path: Path) -> None:
    with_d = read(tmp_path, "G41 G1 " + SQUARE, Machine(radii={1: 2e-3}))
    without = read(tmp_path, "T1\nG41 G1 " + SQUARE.replace("D1 ", ""), Machine(radii={1: 2e-3}))
    np.testing.assert_array_equal(without.position, with_d.position)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("G41 D1 G1 X10", 4, "by a radius that is not in the file. Declare it in the cell, [machine.radii] 1 = mm"),
        ("G41.1 G1 X10", 4, "needs D"),
        ("G41.1 D2 G1 X.5", 4, "not longer than the radius"),
        ("G41.1 D2 G2 X10 R5", 4, "begins with an arc"),
        ("G41.1 D2 G1 X10\nG42.1 D2 Y5", 5, "Write G40 before it"),
        ("G41.1 D2 G1 X10\nG28 G91 Z0", 5, "G28 under cutter compensation"),
        ("G41.1 D2 G1 X10\nG92 X0", 5, "G92 under cutter compensation"),
        ("G41.1 D2 G1 X10\nG81 X9 Z-3 R2", 5, "a canned cycle under cutter compensation"),
        ("G41.1 D2 G1 X10\nG18\nG1 X20", 6, "another plane"),
        ("G18\nG41.1 D2 G1 X10", 5, "in G17 alone"),
        ("G41.1 D9 G1 X10\nX20\nY1\nX0", 6, "does not fit"),
        ("G41.1 D9 G1 X20\nG3 X22 R1", 5, "an arc of a smaller radius"),
        ("G1 X9 D1", 4, "D1 without G41 or G42"),
        ("G1 X9,R2\nG0 Y5", 5, "no line (G1)"),
        ("G1 X9,R2\nG2 X12 R5", 5, "no line (G1)"),
        ("G1 X9,R2\nG28 G91 Z0", 5, "G28 behind a corner"),
        ("G1 X9,R2", 5, "M30 behind a corner"),
        ("G1 X9,R20\nY9", 5, ",R20 mm needs 20 mm of both lines"),
        ("G1 X9,C10\nY20", 5, ",C10 mm needs 10 mm of both lines"),
        ("G1 X9,R1\nX2", 5, "comes back on itself"),
        ("G1 X9,R1\nZ2", 5, "leave the plane"),
        ("G1 X9,R1\nX9", 5, "without length"),
        ("G1 X9,R1,C1\nY9", 4, "alone"),
        ("G1 X9,R-1\nY9", 4, "','"),
        ("G2 X9 R9,R1\nY9", 4, "behind a line"),
        ("G1 X9,A1\nY9", 4, "','"),
    ],
)
def test_refused(tmp_path: Path, text: str, line: int, words: str) -> None:
    with pytest.raises(ReadError, match=re.escape(words)) as caught:
        read(tmp_path, text)
    assert caught.value.line == line


@pytest.mark.parametrize("plane", ["G17", "G18", "G19"])
@pytest.mark.parametrize("seed", range(5))
def test_rounded_corners_touch_both_lines(tmp_path: Path, plane: str, seed: int) -> None:
    rng = random.Random(seed)
    first, second = {"G17": (0, 1), "G18": (2, 0), "G19": (1, 2)}[plane]
    way, turn, radius = rng.uniform(-3, 3), rng.choice([-1, 1]) * rng.uniform(0.2, 2.5), rng.uniform(0.5, 2)
    a = 30 * np.array([math.cos(way), math.sin(way)])
    b = a + 30 * np.array([math.cos(way + turn), math.sin(way + turn)])
    words = [f"{'XYZ'[first]}{p[0]:.9f} {'XYZ'[second]}{p[1]:.9f}" for p in (a, b)]
    path = read(tmp_path, f"{plane} G1 {words[0]} , R {radius:.9f}\n{words[1]}")
    points = path.position[1:, [first, second]] * 1e3
    u, v = a / 30, (b - a) / 30
    # along the lines, or on a circle that touches both: its centre has this distance from the corner
    inward = (v - u) / np.linalg.norm(v - u)
    center = a + inward * radius / math.cos(turn / 2)
    np.testing.assert_allclose(np.linalg.norm(points[:-1] - center, axis=1), radius, atol=1e-6)
    cut = radius * math.tan(abs(turn) / 2)
    np.testing.assert_allclose(points[[0, -2]], [a - cut * u, a + cut * v], atol=1e-6)
    np.testing.assert_allclose(points[-1], b, atol=1e-6)
    chamfer = read(tmp_path, f"{plane} G1 {words[0]},C{cut:.9f}\n{words[1]}").position[1:, [first, second]] * 1e3
    np.testing.assert_allclose(chamfer, [a - cut * u, a + cut * v, b], atol=1e-6)


def test_corners_one_after_the_other_in_incremental_words(tmp_path: Path) -> None:
    path = read(tmp_path, "G91 G1 X20,C5\nY20,C3\nX-20\nG90 G0 Z9")
    expected = [(0, 0), (15, 0), (20, 5), (20, 17), (17, 20), (0, 20), (0, 20)]
    np.testing.assert_allclose(path.position[:, :2] * 1e3, expected, atol=1e-9)


def test_a_straight_corner_is_none(tmp_path: Path) -> None:
    path = read(tmp_path, "G1 X20,R5\nX40")
    np.testing.assert_allclose(path.position[:, 0] * 1e3, (0, 20, 40))
