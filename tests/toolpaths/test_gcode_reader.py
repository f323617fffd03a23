"""G-code: hand-computed values of modal words, planes, arcs; what is refused names line and word."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.readers import read_toolpath
from toolpaths.toolpath import CUT, RAPID, Toolpath

HEAD = "G21 G90 G17\nG0 X0 Y0 Z0\nF600\n"


def read(tmp_path: Path, text: str, **options: float) -> Toolpath:
    file = tmp_path / "part.nc"
    file.write_text(text)
    return read_toolpath(file, **options)


def ends(path: Toolpath) -> np.ndarray:
    """Positions in mm of the poses that stand in the file."""
    return path.position[path.row == np.round(path.row)] * 1e3


def test_modal_words_feeds_and_tools(tmp_path: Path) -> None:
    text = (
        "%\nO1001 (PART)\nN10 G90 G94 G17\nN20 G21\nT3 M6\nS5000 M3\nG54\nG0 X1 Y2\nZ10.\n"
        "g1 z-.5 f300\nX4\nT4 ; next\nG1Y-6.25F1200\nG0Z10\nM5\nM6\nX0\nM30\n%\n"
    )
    path = read(tmp_path, text)
    expected = [[1, 2, 10], [1, 2, -0.5], [4, 2, -0.5], [4, -6.25, -0.5], [4, -6.25, 10], [0, -6.25, 10]]
    np.testing.assert_allclose(path.position, np.array(expected) / 1e3, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(path.kind, [RAPID, CUT, CUT, CUT, RAPID, RAPID])
    np.testing.assert_allclose(path.feed[1:4], [0.005, 0.005, 0.02], rtol=1e-14)
    assert np.isnan(path.feed[[0, 4, 5]]).all()
    np.testing.assert_array_equal(path.tool, [3, 3, 3, 3, 3, 4])
    np.testing.assert_array_equal(path.line, [9, 10, 11, 13, 14, 17])
    np.testing.assert_array_equal(path.axis, np.tile([0.0, 0.0, 1.0], (6, 1)))
    words = [(e.pose, e.word, e.line) for e in path.events]
    assert (0, "PART", 2) in words and (0, "T3 M6", 5) in words and (0, "S5000 M3", 6) in words
    assert (3, "next", 12) in words and (5, "M6", 16) in words and (6, "M30", 18) in words
    assert path.quaternion is None and path.language == "gcode"


def test_tool_without_m6_is_in_use_at_once(tmp_path: Path) -> None:
    path = read(tmp_path, "G21 (M6 thread)\nT7\nG0 X1 Y1 Z1\nT8\nX2\n")
    np.testing.assert_array_equal(path.tool, [7, 8])


def test_inch_and_relative(tmp_path: Path) -> None:
    path = read(tmp_path, "G20 G90\nG0 X1 Y2 Z3\nG91 G1 X.5 Z-1 F10\nX.5\nG90 Y0\nG21 X10 F60\nM2\n")
    expected = [[25.4, 50.8, 76.2], [38.1, 50.8, 50.8], [50.8, 50.8, 50.8], [50.8, 0, 50.8], [10, 0, 50.8]]
    np.testing.assert_allclose(path.position * 1e3, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.feed[1:], [254e-3 / 60] * 3 + [1e-3], rtol=1e-14)


def test_position_is_known_only_after_x_y_and_z(tmp_path: Path) -> None:
    path = read(tmp_path, "G21\nG1 Z5 F100\nG0 X1\nY2\nX3\nM30\n")
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 5], [3, 2, 5]], rtol=0, atol=1e-14)
    assert [e.word for e in path.events[:2]] == [
        "Z5, before the position is known",
        "X1, before the position is known",
    ]


@pytest.mark.parametrize(
    ("plane", "start", "arc", "end", "middle"),
    [  # middle: the point half way along the arc, by hand
        ("G17", "X10 Y0 Z0", "G3 X0 Y10 I-10 J0", [0, 10, 0], [math.sqrt(50), math.sqrt(50), 0]),
        ("G17", "X10 Y0 Z0", "G2 X0 Y10 I-10 J0", [0, 10, 0], [-math.sqrt(50), -math.sqrt(50), 0]),
        ("G18", "X0 Y0 Z10", "G3 X10 Z0 K-10", [10, 0, 0], [math.sqrt(50), 0, math.sqrt(50)]),
        ("G18", "X0 Y0 Z10", "G2 X10 Z0 K-10", [10, 0, 0], [-math.sqrt(50), 0, -math.sqrt(50)]),
        ("G19", "X0 Y10 Z0", "G3 Y0 Z10 J-10", [0, 0, 10], [0, math.sqrt(50), math.sqrt(50)]),
        ("G19", "X0 Y10 Z0", "G2 Y0 Z10 J-10", [0, 0, 10], [0, -math.sqrt(50), -math.sqrt(50)]),
        ("G17", "X10 Y0 Z0", "G3 X0 Y10 R10", [0, 10, 0], [math.sqrt(50), math.sqrt(50), 0]),
        ("G17", "X10 Y0 Z0", "G3 X0 Y10 R-10", [0, 10, 0], [10 + math.sqrt(50), 10 + math.sqrt(50), 0]),
        ("G17", "X10 Y0 Z0", "G2 X0 Y10 R-10", [0, 10, 0], [-math.sqrt(50), -math.sqrt(50), 0]),
        ("G17", "X10 Y0 Z0", "G2 X0 Y10 R10", [0, 10, 0], [10 - math.sqrt(50), 10 - math.sqrt(50), 0]),
        ("G18", "X0 Y0 Z10", "G3 X10 Z0 R10", [10, 0, 0], [math.sqrt(50), 0, math.sqrt(50)]),
        ("G17", "X10 Y0 Z0", "G3 I-10", [10, 0, 0], [-10, 0, 0]),
        ("G17", "X10 Y0 Z0", "G3 X-10 Z4 I-10", [-10, 0, 4], [0, 10, 2]),
        ("G19", "X0 Y10 Z0", "G2 X6 J-10", [6, 10, 0], [3, -10, 0]),
        ("G91 G17", "X10 Y0 Z0", "G3 X-10 Y10 I-10 J0", [0, 10, 0], [math.sqrt(50), math.sqrt(50), 0]),
    ],
)
def test_arcs(
    tmp_path: Path, plane: str, start: str, arc: str, end: list[float], middle: list[float]
) -> None:
    path = read(tmp_path, f"G21 G90\nG0 {start}\n{plane} F100\n{arc}\nM30\n", chord=1e-7)
    np.testing.assert_allclose(path.position[-1] * 1e3, end, rtol=0, atol=1e-12)
    near = np.linalg.norm(path.position * 1e3 - middle, axis=1).min()
    assert near < 0.05  # the points lie 0.02 mm apart
    assert (path.line[1:] == 4).all() and (path.kind[1:] == CUT).all()
    assert len(path) > 100 and (np.diff(path.row) > 0).all() and path.row[-1] == 1.0


@pytest.mark.parametrize("chord", [1e-6, 1e-5, 3e-4])
@pytest.mark.parametrize("radius", [0.3, 5.0, 200.0])
def test_chords_stay_within_the_tolerance_of_the_arc(tmp_path: Path, chord: float, radius: float) -> None:
    text = f"G21\nG0 X{radius} Y0 Z0\nF100 G3 X0 Y{-radius} Z1 I{-radius}\nM30\n"
    path = read(tmp_path, text, chord=chord)
    flat = path.position[:, :2]
    np.testing.assert_allclose(np.linalg.norm(flat, axis=1), radius * 1e-3, rtol=1e-12)
    sagitta = radius * 1e-3 - np.linalg.norm((flat[1:] + flat[:-1]) / 2, axis=1)
    assert sagitta.max() <= chord * (1 + 1e-9)
    if len(path) > 8:
        assert sagitta.max() > chord * 0.4  # not many more points than needed
    angle = np.unwrap(np.arctan2(flat[:, 1], flat[:, 0]))
    np.testing.assert_allclose(angle[-1], 1.5 * math.pi, rtol=1e-12)
    np.testing.assert_allclose(path.position[:, 2] * 1e3, angle / (1.5 * math.pi), atol=1e-12)


def test_small_difference_of_the_radii_is_spread(tmp_path: Path) -> None:
    path = read(tmp_path, HEAD + "G1 X10\nG3 X-10.004 Y0 I-10\nM30\n", chord=1e-6)
    radius = np.linalg.norm(path.position[1:, :2], axis=1) * 1e3
    np.testing.assert_allclose([radius[0], radius[-1]], [10, 10.004], atol=1e-12)
    assert (np.diff(radius) > 0).all()


def test_retracts_to_the_machine_are_events(tmp_path: Path) -> None:
    text = (
        "G21 G90\nG28 G91 Z0.\nG90\nT1 M6\nG0 X0 Y0\nG43 Z15. H01\nG1 Z-2 F100\nX5\nG0 Z15\n"
        "G28 G91 Z0.\nG90\nT2 M6\nG0 X20 Y0\nG43 Z20 H2\nG1 Z-1\nG0 Z15\nG53 G0 Z0\nM30\n"
    )
    path = read(tmp_path, text)
    expected = [[0, 0, 15], [0, 0, -2], [5, 0, -2], [5, 0, 15], [20, 0, 20], [20, 0, -1], [20, 0, 15]]
    np.testing.assert_allclose(path.position * 1e3, expected, atol=1e-12)
    np.testing.assert_array_equal(path.tool, [1, 1, 1, 1, 2, 2, 2])
    words = [(e.pose, e.word) for e in path.events]
    assert (0, "G28 Z0") in words and (4, "G28 Z0") in words and (7, "G53 Z0") in words


def test_retract_that_hides_a_low_way_is_refused(tmp_path: Path) -> None:
    text = HEAD + "G0 Z5\nG1 X5 Z-1\nG1 Z{up}\nG28 G91 Z0\nG90\nG0 X50\nZ{down}\nG1 Z-2\nG0 Z9\nM30\n"
    for up, down in ((-1, 5), (-0.5, -1), (-2, -2)):
        with pytest.raises(ReadError, match=r"part\.nc:7: G28 Z0 .*cuts reach up to Z -1 mm"):
            read(tmp_path, text.format(up=up, down=down))
    assert len(read(tmp_path, text.format(up=-0.5, down=3))) == 7


REFUSED = {
    "G1 X1 A90": (4, "A90"),
    "G41 D1 X5": (4, "G41"),
    "G1 X1 E0.5": (4, "3D printer"),
    "M104 S200": (4, "3D printers"),
    "G92 X0": (4, "G92"),
    "G55": (4, "G55"),
    "G93": (4, "G93"),
    "G81 X1 Z-3 R2": (4, "canned cycle"),
    "G90.1": (4, "absolute arc centres"),
    "G43.4 H1": (4, "tool vectors"),
    "G5.1 Q1": (4, "spline"),
    "G17.1": (4, "G17.1"),
    "G65 P100": (4, "macro"),
    "M98 P100": (4, "subprogram"),
    "M77": (4, "M77"),
    "G1 X#101": (4, "variable"),
    "G1 X[1+2]": (4, "expression"),
    "/G1 X1": (4, "block delete"),
    "G1 X1 X2": (4, "X stands twice"),
    "G0 G1 X1": (4, "two words for motion"),
    "G1 X1.2.3": (4, "'.'"),
    "G1 X": (4, "'X'"),
    "G1 X1 (never closed": (4, "not closed"),
    "G1 X1 I2": (4, "G2 and G3"),
    "F0\nG1 X1": (5, "needs a feed, it is F0"),
    "F-3\nG1 X1": (5, "F-3"),
    "G2 X5": (4, "without centre"),
    "G2 X5 R1": (4, "too small"),
    "G2 R5": (4, "ends where it starts"),
    "G2 X5 R5 I2": (4, "both R and I"),
    "G2 X5 K2": (4, "K is no centre word"),
    "G18 G2 X5 J2": (4, "J is no centre word"),
    "G2 X10 I4": (4, "radius is 4 mm at the start, 6 mm at the end"),
    "G2 I0": (4, "radius zero"),
    "G80\nX5": (5, "no G0, G1, G2 or G3"),
    "G28 X1": (4, "G28 by way of a point"),
    "G53 G1 X1": (4, "rapid retract"),
    "G43 Z5\nH1": (5, "H1 without G43"),
    "G2 X5 I2.5 P2": (4, "P2"),
    "T1.5 M6": (4, "T1.5"),
    "G20\nG1 X1": (5, "needs a feed"),
    "O2\nG1 X1": (4, "second program"),
    "M30\nG1 X1": (5, "after the end"),
    "%\nG1 X1": (4, "middle of the program"),
    "G1 X2000000": (4, "beyond 1000 m"),
    "G1 X1 I99999999999": (4, "beyond 1e"),
    "T9999999999999999999999": (4, "beyond 1e"),
    "G1 X1 V2": (4, "V2"),
    "G1 X1 $": (4, "not a G-code word"),
}


@pytest.mark.parametrize(("text", "expected"), REFUSED.items(), ids=list(REFUSED))
def test_refused_by_line_and_word(tmp_path: Path, text: str, expected: tuple[int, str]) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, HEAD + text + "\nM30\n")
    assert caught.value.line == expected[0] and expected[1] in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "part.nc") + ":")


@pytest.mark.parametrize(
    ("text", "line", "word"),
    [
        ("G0 X1 Y1 Z1\n", 1, "no units"),
        ("G21\nX1 Y1 Z1\n", 2, "no G0"),
        ("G21\nG91 G0 X1 Y1 Z1\n", 2, "where X starts is not known"),
        ("G21\nG0 X1 Y1\nG2 X3 I1\n", 3, "needs a feed"),
        ("G21\nG0 X1 Y1\nG2 X3 I1 F5\n", 3, "not known (Z)"),
        ("%\nG21\nG0 X1 Y1 Z1\nX2\n", 5, "does not end with one"),
        ("G21\nM3 S100\nG0 X1 Y1 Z1\nX2\n", 5, "spindle turns"),
        ("G21\nG0 X1 Y1 Z1\nX2", 3, "without a line end"),
    ],
)
def test_head_and_end(tmp_path: Path, text: str, line: int, word: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, text)
    assert caught.value.line == line and word in str(caught.value)


def test_real_files(shared: Path) -> None:
    folder = shared / "data/cam"
    path = read_toolpath(folder / "gcode_fusion/1110_wall_265bit.nc")
    np.testing.assert_allclose(path.position[0] * 1e3, [-1.322, 35.263, 10], atol=1e-12)
    assert path.kind.sum() > 19_000 and (path.tool == 1).all() and path.line[0] == 16
    np.testing.assert_allclose(path.position[:, 2].min() * 1e3, -13.3, atol=1e-9)  # ZMIN of its header
    path = read_toolpath(folder / "gcode_cncjs/tball-pocket.gcode")
    assert path.line[-1] > 40_000 and len(path) == 40_265
    for name, line in {"sample.gcode": 10, "helical-thread-milling.gcode": 4, "arc-ijk.gcode": 2}.items():
        with pytest.raises(ReadError) as caught:
            read_toolpath(folder / "gcode_cncjs" / name)
        assert caught.value.line == line
