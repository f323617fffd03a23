"""G-code filtered in place: cutting moves go where the program says, everything else stays byte by byte."""

from __future__ import annotations

import difflib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.commanded import program_of
from tests.oracles.filtered_gcode import corrected, cuts, filtered, read
from toolpaths.errors import ReadError, WriteError
from toolpaths.languages.gcode.filter import rewrite
from toolpaths.languages.gcode.reader import parse
from toolpaths.machine import Machine
from toolpaths.rotation import rotation_of_axis
from toolpaths.toolpath import CUT
from toolpaths.writing.marker import MARKER

HEAD = "G21 G90 G17\nG0 X0 Y0 Z5\nF600\n"


def diff(before: str, after: bytes) -> list[str]:
    lines = difflib.ndiff(before.split("\n"), after.decode("latin-1").split("\n"))
    return [line for line in lines if line[0] in "+-"]


def test_numbers_change_in_the_manner_of_the_file() -> None:
    text = HEAD + "N10 G01 X10.500 Z-1.000 (plunge) F300 M8\nn20 y-4.250 ; way\nG0 Z5.000\nM30\n"
    path = read(text.encode())
    moved = path.position + np.where((path.kind == CUT)[:, None], [[0.0001, -0.0002, 0.00003]], 0.0)
    new = rewrite(text.encode(), program_of(path, moved), path.row, Path("a.nc"))
    assert diff(text, new.text) == [
        f"+ ({MARKER})",
        "- N10 G01 X10.500 Z-1.000 (plunge) F300 M8", "+ N10 G01 X10.600 Y-0.200 Z-0.970 (plunge) F300 M8",
        "- n20 y-4.250 ; way", "+ n20 y-4.450 ; way",
    ]  # fmt: skip
    assert new.changes == ()


def test_bytes_that_are_no_poses_stay() -> None:
    data = (
        b"\xef\xbb\xbf(Fr\xc3\xa4sen \xb5 \xff)\r\n"
        + (HEAD + "\t G1  X10.0Z-1 (A) ;B\n\nM9 ( x1 )\nG0Z5\nM30").encode()
    )
    new, program, _ = filtered(data)
    assert new.text.startswith(b"\xef\xbb\xbf") and b"(Fr\xc3\xa4sen \xb5 \xff)\r\n" in new.text
    assert new.text.endswith(b" (A) ;B\n\nM9 ( x1 )\nG0Z5\nM30")
    np.testing.assert_allclose(cuts(read(new.text[3:])), cuts(program), atol=6e-4)


def test_compensated_file_and_wrong_poses_are_refused() -> None:
    new, program, path = filtered(HEAD + "G1 X10 Z-1\nM30\n")
    with pytest.raises(ReadError, match=r"a.nc:1: .*compensated already"):
        rewrite(new.text, program, path.row, Path("a.nc"))
    with pytest.raises(WriteError, match="do not belong to this file"):
        rewrite((HEAD + "M30\n").encode(), program, path.row, Path("a.nc"))


def test_arc_becomes_lines_or_stays() -> None:
    text = HEAD + "G1 X0 Z-1\nG2 X10 Y0 I5 J0 F900 (half)\nX20 I5\nG1 X30\nG0 Z5\nM30\n"
    new, program, path = filtered(text)
    out = new.text.decode()
    assert "G2 " not in out and "I5" not in out and "(half)" in out and "F900" in out
    assert [(c.place, c.what, c.count) for c in new.changes] == [("a.nc:5", "an arc became lines", 2)]
    np.testing.assert_allclose(cuts(read(new.text)), cuts(program), atol=6e-4)
    shifted = path.position + np.where((path.kind == CUT)[:, None], [[0.0003, -0.0002, 0.0001]], 0)
    new = rewrite(text.encode(), program_of(path, shifted), path.row, Path("a.nc"))
    assert "G2 X10.3 Y-0.2 I5 J0 F900 (half)\nX20.3 I5\nG1 X30.3" in new.text.decode() and new.changes == ()


def test_motion_word_comes_back_after_lines() -> None:
    text = HEAD + "G1 X0 Z-1\nG2 X10 I5\nG0 Z5\nX0\nG1 Z0\nG3 X20 I10\nX0 I-10\nG1 X1\nM30\n"
    path = read(text.encode())
    position = path.position.copy()
    only = path.line == 9  # the first G3
    position[only] += 1e-4 * np.sin(np.arange(only.sum()))[:, None]
    position[np.flatnonzero(only)[-1]] = path.position[np.flatnonzero(only)[-1]]
    new = rewrite(text.encode(), program_of(path, position), path.row, Path("a.nc"))
    assert "\nG3 X0 I-10\n" in new.text.decode() and "\nG2 X10 I5\n" in new.text.decode()
    again = read(new.text)
    np.testing.assert_allclose(again.position[-1], path.position[-1], atol=1e-12)


def test_poses_are_put_in_as_lines() -> None:
    text = HEAD + "G1 X0 Z-1\nX10 F100 (long) M8\nX20 M0\nG0 Z5\nM30\n"
    path = read(text.encode())
    rows = np.sort(np.concatenate([path.row, [1.5, 2.25, 2.5]]))
    at = np.array([np.interp(rows, path.row, c) for c in path.position.T]).T
    grown = replace(path.take(np.searchsorted(path.row, rows)), row=rows, position=at)
    program = program_of(grown, corrected(grown))
    new = rewrite(text.encode(), program, rows, Path("a.nc"))
    np.testing.assert_allclose(cuts(read(new.text)), cuts(program), atol=6e-4)
    lines = new.text.decode().split("\n")
    long = next(k for k, line in enumerate(lines) if "(long) M8" in line and "F100" in line)
    assert (
        re.fullmatch(r"X5\.\d+ Y\S+ Z\S+ F100 \(long\) M8", lines[long])
        and re.fullmatch(r"X10\S* Y\S+ Z\S+", lines[long + 1]) is not None
    )
    assert lines[long + 4].endswith(" M0") and lines[long + 4].startswith("X20.")
    assert [(c.what, c.count) for c in new.changes] == [("poses were put in as lines", 3)]
    assert new.changes[0].places == ("a.nc:5", "a.nc:6")


def test_drilling_series_is_expanded_when_a_hole_moves() -> None:
    text = HEAD + "G98 G82 X5 Y5 Z-3 R2 P.5 F90 (holes)\nX10\nG80\nG0 X50\nG99 G81 X60 Z-1 R1\nG80\nM30\n"
    path = read(text.encode())
    position = path.position.copy()
    position[(path.line == 5) & (path.kind == CUT)] += [1e-4, 2e-4, -1e-4]
    new = rewrite(text.encode(), program_of(path, position), path.row, Path("a.nc"))
    out = new.text.decode()
    assert "G82" not in out and "G98" not in out and "F90 (holes)" in out and out.count("G4 P.5") == 2
    assert "G99 G81 X60 Z-1 R1" in out
    again = read(new.text)
    np.testing.assert_allclose(cuts(again), position[path.kind == CUT] * 1e3, atol=6e-4)
    assert len(new.changes) == 1 and new.changes[0].count == 2


def test_tool_vectors_follow() -> None:
    text = HEAD + "G43.4 H1\nG0 X0 Y0 Z5 I0 J0 K1\nG1 Z0 F100\nX5 I.6 J0 K.8\nX10\nG0 Z50\nG49\nM30\n"
    path = read(text.encode())
    g = np.random.default_rng(4)
    axis = path.axis + np.where((path.kind == CUT)[:, None], g.normal(scale=1e-3, size=path.axis.shape), 0)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    program = program_of(path, corrected(path), axis)
    again = read(rewrite(text.encode(), program, path.row, Path("a.nc")).text)
    np.testing.assert_allclose(cuts(again), cuts(program), atol=6e-4)
    np.testing.assert_allclose(again.axis[path.kind == CUT], axis[path.kind == CUT], atol=2e-7)


def test_tilt_that_the_file_cannot_say_is_listed() -> None:
    text = HEAD + "G1 X10 Z-1\nM30\n"
    path = read(text.encode())
    axis = path.axis + np.array([0.002, 0, 0])
    new = rewrite(text.encode(), program_of(path, None, axis / np.linalg.norm(axis[0])), path.row, Path("a.nc"))
    assert len(new.changes) == 1 and "tilts the tool by up to 0.11 deg" in new.changes[0].what


def test_poses_of_cuts_are_enough() -> None:
    """The compensator gives the poses of cuts and the rapids before them only."""
    text = HEAD + "G1 X5 Z-1\nG0 Z5\nG99 G83 X9 Z-3 R2 Q2\nX12\nG80\nG0 Z5\nX0\nM30\n"
    path = read(text.encode())
    whole = program_of(path, corrected(path))
    keep = np.flatnonzero(path.kind == CUT)
    new = rewrite(text.encode(), program_of(path.take(keep), whole.position[keep]), path.row[keep], Path("a.nc"))
    assert new.text == rewrite(text.encode(), whole, path.row, Path("a.nc")).text
    again = read(new.text)
    assert len(again) == len(path)
    np.testing.assert_allclose(cuts(again), cuts(whole), rtol=0, atol=6e-4)
    np.testing.assert_allclose(again.position, whole.position, rtol=0, atol=2e-4)
    with pytest.raises(WriteError, match=r"a.nc:4: the program has no pose for the end"):
        rewrite(text.encode(), program_of(path.take(keep[1:])), path.row[keep[1:]], Path("a.nc"))


def test_inverse_time_stays_the_same_time() -> None:
    text = HEAD + "G1 X0 Z-1 F100\nG93 G2 X10 I5 F4\nG1 X20 F2\nG94 G1 X0 F100\nM30\n"
    new, program, path = filtered(text)
    again = read(new.text)
    for line, seconds in ((5, 15.0), (6, 30.0)):
        cuts_ = np.flatnonzero(path.line == line)
        way = np.linalg.norm(np.diff(again.position, axis=0), axis=1)[cuts_ - 1]
        np.testing.assert_allclose(np.sum(way / again.feed[cuts_]), seconds, rtol=1e-4)
        assert np.ptp(again.feed[cuts_]) < 0.01 * again.feed[cuts_[0]]
    np.testing.assert_allclose(cuts(again), cuts(program), atol=6e-4)


def test_rotary_words_are_refused() -> None:
    text = (HEAD + "(A1) G0 X1\nG1 X5 A30\nM30\n").encode()
    program = program_of(read((HEAD + "M30\n").encode()))
    with pytest.raises(WriteError, match=r"a.nc:5: rotary words cannot be corrected in place"):
        rewrite(text, program, np.zeros(1), Path("a.nc"))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("#1=5\nG1 X#1", "#"), ("G1 X[2+3]", "["), ("M98 P1", "M98"), ("G41 D1 X5", "G41"), ("G42.1 D1 X5", "G42.1"),
        ("G1 X5 , r2\nY5", ", R"), ("G68.2 X0", "G68.2"), ("G84 X5 Z-3 R2", "G84"), ("G86 X5 Z-3 R2", "G86"),
    ],
)  # fmt: skip
def test_words_that_no_other_coordinates_can_say_are_refused(text: str, word: str) -> None:
    program = program_of(read((HEAD + "M30\n").encode()))
    with pytest.raises(WriteError, match=re.escape(f"a.nc:5: {word} cannot be corrected in place")):
        rewrite(f"{HEAD}(#1 = 5, G41, [2], M98)\n{text}\nM30\n".encode(), program, np.zeros(1), Path("a.nc"))


def test_a_point_by_the_way_stays() -> None:
    text = HEAD + "G1 X10 Z-1\nX20\nG28 X21 Y0 Z9\nG0 X0 Y0 Z9\nG1 Z-1\nG91 G28 X1 Z12\nG90\nM30\n"
    path = read(text.encode())
    moved = path.position + np.where((path.kind == CUT)[:, None], [[0.0003, -0.0002, 0.00004]], 0.0)
    new = rewrite(text.encode(), program_of(path, moved), path.row, Path("a.nc")).text
    assert "G28 X21 Y0 Z9" in new.decode()
    np.testing.assert_allclose(read(new).position[:-1], moved[:-1], atol=6e-7)


def test_a_shift_by_place_names_the_corrected_place() -> None:
    """Else the origin, and with it every rapid that follows, would move along with the correction."""
    text = HEAD + "G1 X10 Z-1\nG92 X0 (here) Z4\nG1 X5\nG0 Z9\nX2 Y3\nG92.1\nG1 X6 Z1\nM30\n"
    path = read(text.encode())
    moved = path.position + np.where((path.kind == CUT)[:, None], [[0.0003, -0.0002, 0.00004]], 0.0)
    new = rewrite(text.encode(), program_of(path, moved), path.row, Path("a.nc"))
    out = new.text.decode().split("\n")
    assert "G92 X0.3 (here) Z4.04" in out and "G1 X5.3" in out and "G0 Z9" in out and "X2 Y3" in out
    assert [(c.place, c.what) for c in new.changes] == [
        ("a.nc:5", "G92 names the corrected place, so that the origin stays")
    ]
    again = read(new.text)
    np.testing.assert_allclose(cuts(again), moved[path.kind == CUT] * 1e3, rtol=0, atol=1e-9)
    np.testing.assert_allclose(again.position[path.line == 8], path.position[path.line == 8], rtol=0, atol=1e-12)


@pytest.mark.parametrize(("unit", "digits"), [("G21", 3), ("G20", 5)])
def test_shifts_in_a_row_add_nothing_up(unit: str, digits: int) -> None:
    """A hundred of them, with a change of units between block and shift."""
    other = "G20" if unit == "G21" else "G21"
    body = "".join(f"{unit} G1 X{k + 0.5} F9\n{other}\nG92 X1.25\nX1.5\n{unit} G92 X{k}\n" for k in range(1, 100))
    text = f"G21\nG0 X0 Y0 Z5\nF600\nG21\n{unit} F9\n{body}G1 X1 F9\nM30\n".replace("X1.5\n", "G1 X1.5 F9\n")
    path = read(text.encode())
    moved = path.position + np.where((path.kind == CUT)[:, None], [[0.00037, -0.00021, 0.00004]], 0.0)
    again = read(rewrite(text.encode(), program_of(path, moved), path.row, Path("a.nc")).text)
    np.testing.assert_allclose(again.position, moved, rtol=0, atol=6e-7 if digits == 3 else 3e-7)


def test_systems_of_the_machine() -> None:
    """Numbers count from where the machine has G55; without the machine the poses are refused."""
    machine = Machine(systems={"G54": (0.0, 0.0, 0.0), "G55": (0.05, -0.01, 0.002)})
    text = HEAD + "G54 G1 X10 Z-1\nG55 X10 Y1 Z0\nG91 X5\nG0 Z9\nM30\n"
    path = parse(text.split("\n"), "a.nc", machine).toolpath(1e-5)
    moved = path.position + np.where((path.kind == CUT)[:, None], [[0.0003, -0.0002, 0.00004]], 0.0)
    planned = program_of(path, moved)
    program = replace(planned, nominal_position=path.position, nominal_rotation=rotation_of_axis(path.axis))
    new = rewrite(text.encode(), program, path.row, Path("a.nc"), machine)
    assert "\nG54 G1 X10.3 Y-0.2 Z-0.96\nG55 X10.3 Y0.8 Z0.04\nG91 X5\nG0 Z9\n" in new.text.decode()
    again = parse(new.text.decode().split("\n"), "a.nc", machine).toolpath(1e-5)
    np.testing.assert_allclose(cuts(again), cuts(program), rtol=0, atol=1e-9)
    elsewhere = Machine(systems={"G54": (0.0, 0.0, 0.0), "G55": (0.0, 0.0, 0.0)})
    with pytest.raises(WriteError, match=r"a.nc:5: the pose was planned 50 mm from where the file has it"):
        rewrite(text.encode(), program, path.row, Path("a.nc"), elsewhere)
