"""G-code: hand-computed values of modal words, planes, arcs; what is refused names line and word."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.gcode import reader as gcode
from toolpaths.machine import Machine
from toolpaths.toolpath import CUT, RAPID, Toolpath

HEAD = "G21 G90 G17\nG0 X0 Y0 Z0\nF600\n"

read = partial(read_text, "part.nc")


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
    path = read(tmp_path, "G21\nG0 Z5\nX1\nY2\nX3\nM30\n")
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 5], [3, 2, 5]], rtol=0, atol=1e-14)
    assert [e.word for e in path.events[:2]] == [
        "Z5, before the position is known",
        "X1, before the position is known",
    ]


def test_no_cut_is_left_out_before_the_position_is_known(tmp_path: Path) -> None:
    """A feed to the file's clearance is no cut (JSCut begins so); any other names the line and what to do."""
    path = read(tmp_path, "G21\nG1 Z5 F100\nG1 X1 Y2\nZ-1\nX3\nZ5\nM30\n")
    np.testing.assert_allclose(path.position[0] * 1e3, [1, 2, 5], rtol=0, atol=1e-14)
    for text, line, words in [
        ("G21\nG1 X5 F100\nX6\nY3 Z1\nM30\n", 2, "X5: a cutting move, but where Y, Z is, is not known"),
        ("G21\nG0 X1\nG1 Y5 F100\nG0 Z5\nM30\n", 3, "Y5: a cutting move, but where Z is, is not known"),
        ("G21\nG1 Z5 F100\nG0 X1 Y2\nG1 X3 Z6\nM30\n", 2, "Z5: a cutting move"),
        ("G21\nG1 Z-1 F100\nG0 X1 Y2\nG1 X3\nM30\n", 2, "Z-1: a cutting move"),
    ]:
        with pytest.raises(ReadError, match=words) as caught:
            read(tmp_path, text)
        assert caught.value.line == line and "[machine] start" in str(caught.value)


def test_where_the_tool_starts(tmp_path: Path) -> None:
    """[machine] start: what a file that begins with a cut begins from, for lines, arcs, cycles and G91."""
    (tmp_path / "a.nc").write_text("")

    def begun(text: str) -> Toolpath:
        (tmp_path / "a.nc").write_text(f"G21 {text}\nM30\n")
        return read_toolpath(tmp_path / "a.nc", machine=Machine(start=(1e-3, 2e-3, 3e-3)))

    for text, end, poses in [
        ("G90 G1 X5 F100", [5, 2, 3], 2),
        ("G91 G1 X5 Z-1 F100", [6, 2, 2], 2),
        ("G90 G2 X5 Y6 I4 F100", [5, 6, 3], 13),
        ("G90 G81 X5 Z-5 R3 F100", [5, 2, 3], 4),
        ("G90 G1 Y2 F100", [1, 2, 3], 2),
    ]:
        path = begun(text)
        assert path.kind[0] == RAPID and path.line[0] == 1 and len(path) == poses, text
        np.testing.assert_allclose(path.position[[0, -1]] * 1e3, [[1, 2, 3], end], rtol=0, atol=1e-12)
    path = begun("G90 G0 Z9\nG1 X5 F100")
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 9], [5, 2, 9]], rtol=0, atol=1e-12)


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
def test_arcs(tmp_path: Path, plane: str, start: str, arc: str, end: list[float], middle: list[float]) -> None:
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


def test_shifts_of_the_origin(tmp_path: Path) -> None:
    text = HEAD + (
        "G0 X10 Y5\nG92 X0 Z1\nG1 X3 Z4\nG92.2\nX3\nG92.3\nX4\nG92.1\nX5\nG52 X100 Y-20\nX1 Y1\n"
        "G91 X2\nG90 G52 X0\nX7\nM30\n"
    )
    expected = [[0, 0, 0], [10, 5, 0], [13, 5, 3], [3, 5, 3], [14, 5, 3], [5, 5, 3], [101, -19, 3], [103, -19, 3],
                [7, -19, 3]]  # fmt: skip
    np.testing.assert_allclose(ends(read(tmp_path, text)), expected, atol=1e-12)


def test_g92_at_the_head_says_where_the_tool_is(tmp_path: Path) -> None:
    path = read(tmp_path, "G21\nG92 X5 Y6 Z7\nG91 G0 X1\nG90 Y2\nM30\n")
    np.testing.assert_allclose(ends(path), [[6, 6, 7], [6, 2, 7]], atol=1e-12)


def test_one_coordinate_system_is_the_work_object(tmp_path: Path) -> None:
    for word in ("G54", "G55", "G59.3", "G54.1 P7"):
        np.testing.assert_allclose(ends(read(tmp_path, f"G21 {word}\nG0 X1 Y2 Z3\n{word}\nX4\nM30\n"))[-1], [4, 2, 3])


def test_several_coordinate_systems_need_their_offsets(tmp_path: Path) -> None:
    file = tmp_path / "two.nc"
    file.write_text("G21 G54\nG0 X1 Y2 Z3\nG55\nX4\nG52 X1\nX4\nM30\n")
    machine = Machine(systems={"G54": (0.0, 0.0, 0.0), "G55": (0.1, 0.2, -0.3)})
    path = gcode.read(file, str(file), 1e-5, machine)
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 3], [104, 2, 3], [105, 2, 3]], atol=1e-12)
    with pytest.raises(ReadError, match=r"two.nc:3: G55: the machine's offsets name only G54"):
        gcode.read(file, str(file), 1e-5, Machine(systems={"G54": (0.0, 0.0, 0.0)}))


def test_feeds_by_time_and_by_turn(tmp_path: Path) -> None:
    text = HEAD + (
        "G93 G1 X30 Z40 F2\nG2 X50 I10 F3 P2\nG1 X50 F9\nG95 S1200 F.1 X0\nS600\nX1\nG94 F90 X2\nG20 X.1 F2\n"
        "G95 F.01 X.2\nM30\n"
    )
    path = read(tmp_path, text)
    feed = path.feed[path.row == np.round(path.row)][1:] * 6e4  # mm/min
    arc = 3 * np.pi * 10 * 3
    np.testing.assert_allclose(feed, [50 * 2, arc, arc, 120, 60, 90, 50.8, 600 * 0.254], rtol=1e-12)


def test_arcs_with_several_turns_and_absolute_centres(tmp_path: Path) -> None:
    path = read(tmp_path, HEAD + "G92 X100\nG0 X110\nG90.1 G3 X100 Y10 Z3 I100 J0 P3\nM30\n", chord=1e-6)
    flat = path.position[1:, :2] * 1e3
    np.testing.assert_allclose(np.linalg.norm(flat, axis=1), 10, rtol=1e-12)
    angle = np.unwrap(np.arctan2(flat[:, 1], flat[:, 0]))
    np.testing.assert_allclose(angle[-1], 4.5 * np.pi, rtol=1e-12)
    np.testing.assert_allclose(path.position[1:, 2] * 1e3, 3 * angle / (4.5 * np.pi), atol=1e-12)


def test_drilling(tmp_path: Path) -> None:
    text = (
        "G21 G90 F100\nG0 X0 Y0 Z10\nG98 G81 X5 Z-3 R2\nG99 X7\nG80\nG0 Z20\nG83 Y1 Z-1.5 R1 Q1\n"
        "G91 G82 X1 Z-2 R-1 P.5 K2\n"
        "G80 G90\nG85 X0 Z0 R4\nM30\n"
    )
    path = read(tmp_path, text)
    expected = [
        (0, 0, 10), (5, 0, 10), (5, 0, 2), (5, 0, -3), (5, 0, 10), (7, 0, 10), (7, 0, 2), (7, 0, -3), (7, 0, 2),
        (7, 0, 20), (7, 1, 20), (7, 1, 1), (7, 1, 0), (7, 1, 1), (7, 1, 0.254), (7, 1, -1), (7, 1, 1), (7, 1, -0.746),
        (7, 1, -1.5), (7, 1, 1), (8, 1, 19), (8, 1, 17), (8, 1, 19), (9, 1, 19), (9, 1, 17), (9, 1, 19),
        (0, 1, 19), (0, 1, 4), (0, 1, 0), (0, 1, 4),
    ]  # fmt: skip
    np.testing.assert_allclose(path.position * 1e3, expected, atol=1e-12)
    cuts = [k for k in range(len(expected)) if path.kind[k] == CUT]
    assert cuts == [3, 7, 12, 15, 18, 21, 24, 28, 29]
    np.testing.assert_allclose(path.feed[cuts], 100 / 6e4)
    assert np.isnan(path.feed[path.kind == RAPID]).all()


def test_safety_line_and_end_of_a_cycle(tmp_path: Path) -> None:
    text = "G0 G17 G21 G40 G49 G80 G90\nX0 Y0 Z5\nG81 X1 Z-1 R2 F100\nX2\nG80 G0 X3 Z6\n"
    text += "G81 G80 X4 Z-2 R1\nG49 H0\nM30\n"
    path = read(tmp_path, text)
    expected = [(0, 0, 5), (1, 0, 5), (1, 0, 2), (1, 0, -1), (1, 0, 2), (2, 0, 2), (2, 0, -1), (2, 0, 2), (3, 0, 6),
                (4, 0, 6), (4, 0, 1), (4, 0, -2), (4, 0, 1)]  # fmt: skip
    np.testing.assert_allclose(path.position * 1e3, expected, atol=1e-12)


def test_tool_vectors(tmp_path: Path) -> None:
    text = (
        "G21 G90\nT1 M6\nG43.4 H1\nG0 X0 Y0 Z10 I0 J0 K1\nG1 Z0 F100\nX5 I.6 K.8\nX6\nG2 X8 I1\n"
        "G1 Y3 I0 J-3 K4\nG0 Z50\n"
        "G49\nG53 G0 Z0\nM30\n"
    )
    path = read(tmp_path, text)
    whole = path.row == np.round(path.row)
    expected = [[0, 0, 1]] * 2 + [[0.6, 0, 0.8]] * 3 + [[0, -0.6, 0.8]] * 2
    np.testing.assert_allclose(path.axis[whole], expected, atol=1e-15)
    np.testing.assert_allclose(path.axis[~whole], [0.6, 0, 0.8] * np.ones((sum(~whole), 1)), atol=1e-15)


def test_real_files(shared: Path) -> None:
    folder = shared / "data/cam"
    path = read_toolpath(folder / "gcode_fusion/1110_wall_265bit.nc")
    np.testing.assert_allclose(path.position[0] * 1e3, [-1.322, 35.263, 10], atol=1e-12)
    assert path.kind.sum() > 19_000 and (path.tool == 1).all() and path.line[0] == 16
    np.testing.assert_allclose(path.position[:, 2].min() * 1e3, -13.3, atol=1e-9)  # ZMIN of its header
    path = read_toolpath(folder / "gcode_cncjs/tball-pocket.gcode")
    assert path.line[-1] > 40_000 and len(path) == 40_265
    # a 3D print; G91 from nowhere; no units
    for name, line in {"sample.gcode": 10, "helical-thread-milling.gcode": 4, "arc-ijk.gcode": 2}.items():
        with pytest.raises(ReadError) as caught:
            read_toolpath(folder / "gcode_cncjs" / name)
        assert caught.value.line == line


def test_a_file_without_an_end_word_that_is_whole(tmp_path: Path) -> None:
    """A retract or a spindle stop after the last cut tells that it is."""
    for tail in ("G0 Z5\n", "M5\n", "M9\n(end)\nM5\n"):
        text = f"G21 G90\nG0 X0 Y0 Z5\nM3 S100\nG1 Z-1 F100\nX10\n{tail}" + ("M5\n" if "Z5" in tail else "")
        assert len(read(tmp_path, text)) in (3, 4)
