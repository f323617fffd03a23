"""HEIDENHAIN Klartext: modal words, feeds, tools, retracts, paths and corners, in numbers worked out by hand."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, RAPID, Toolpath

HEAD = "BEGIN PGM A MM\nL X+0 Y+0 Z+0 R0 FMAX\nL F600\n"
read = partial(read_text, "part.h")


def behind(tmp_path: Path, text: str, chord: float = 1e-5) -> Toolpath:
    """What stands behind HEAD, read, without the pose of HEAD."""
    path = read(tmp_path, f"{HEAD}{text}\nEND PGM A MM\n", chord)
    return path.take(np.flatnonzero(path.row > 0))


def words(path: Toolpath) -> list[tuple[int, str, int]]:
    return [(e.pose, e.word, e.line) for e in path.events]


def test_modal_words_feeds_and_tools(tmp_path: Path) -> None:
    text = (
        "0  BEGIN PGM PART MM\n1  BLK FORM 0.1 Z X-5 Y-5 Z-20\n2  BLK FORM 0.2 X+5 Y+5 Z+0\n3  * - Roughing\n"
        '4  TOOL CALL "MILL 10" Z S5000 F700 DL+0 ; ten\n5  TOOL DEF "DRILL"\n'
        "6  L X+1 Y+2 R0 FMAX M3\n7  L Z+10 FMAX M8\n"
        '8  L Z-.5 F300\n9  L X4,0\n10 TOOL CALL "DRILL" Z S800\n11 L IY-8.25 F AUTO M9\n12 L Z+10 R0 FMAX\n13 STOP\n'
        "14 L X+0 FMAX M30\n15 END PGM PART MM\n"
    )
    path = read(tmp_path, text)
    expected = [[1, 2, 10], [1, 2, -0.5], [4, 2, -0.5], [4, -6.25, -0.5], [4, -6.25, 10], [0, -6.25, 10]]
    np.testing.assert_allclose(path.position, np.array(expected) / 1e3, rtol=0, atol=1e-15)
    assert path.kind.tolist() == [RAPID, CUT, CUT, CUT, RAPID, RAPID]
    np.testing.assert_allclose(path.feed * 6e4, [math.nan, 300, 300, 700, math.nan, math.nan], rtol=1e-14)
    assert path.tool.tolist() == [1, 1, 1, 2, 2, 2] and path.line.tolist() == [8, 9, 10, 12, 13, 15]
    assert words(path) == [
        (0, "BLK FORM 0.1 Z X-5 Y-5 Z-20", 2), (0, "BLK FORM 0.2 X+5 Y+5 Z+0", 3), (0, "Roughing", 4), (0, "ten", 5),
        (0, 'T="MILL 10" (tool 1) S5000', 5), (0, 'TOOL DEF "DRILL"', 6), (0, "M3", 7),
        (0, "L X+1 Y+2 R0 FMAX M3, before the position is known", 7), (0, "M8", 8), (3, 'T="DRILL" (tool 2) S800', 11),
        (3, "M9", 12), (5, "STOP", 14), (6, "M30", 15),
    ]  # fmt: skip


def test_the_feed_of_tool_call_counts_until_the_next(tmp_path: Path) -> None:
    path = behind(tmp_path, "TOOL CALL 1 Z S900 F200\nL X+1\nL X+2 F100\nL X+3 F AUTO\nL X+4 FAUTO")
    np.testing.assert_allclose(path.feed * 6e4, [200, 100, 200, 200])


def test_inch(tmp_path: Path) -> None:
    """Feeds count tenths of an inch."""
    path = read(tmp_path, "BEGIN PGM A INCH\nL X+1 Y+2 Z+3 FMAX\nL IX+0,5 F100\nEND PGM A INCH\n")
    np.testing.assert_allclose(path.position * 1e3, [[25.4, 50.8, 76.2], [38.1, 50.8, 76.2]], rtol=0, atol=1e-12)
    assert path.feed[1] * 6e4 == pytest.approx(254)


def test_feeds_by_the_turn_and_of_the_plunge(tmp_path: Path) -> None:
    path = behind(
        tmp_path, "TOOL CALL 1 Z S2000\nM136\nL X+1 F0.1\nM137\nL X+2 F500\nM103 F20\nL Z-5\nL X+5 Z-9\nM103\nL Z-10"
    )
    down = 500 * 0.2 * math.dist((2, -5), (5, -9)) / 4
    np.testing.assert_allclose(path.feed * 6e4, [200, 500, 100, down, 500])


ARCS = {
    "C": ("CC X+10 Y+0\nC X+10 Y+10 DR-", (10, 0), -math.pi / 2),
    "C, with an incremental centre and end": ("CC IX+0 IY+10\nC IX+10 IY+10 DR+", (0, 10), math.pi / 2),
    "a whole circle": ("CC X-5 Y+0\nC X+0 Y+0 DR+", (-5, 0), math.tau),
    "CC takes the last position": ("L X+10 Y+0\nCC\nL X+0\nC X+10 Y+10 DR-", (10, 0), -math.pi / 2),
    "CP to an angle": ("CC X+10 Y+0\nCP PA+90 DR-", (10, 0), -math.pi / 2),
    "CP by an angle": ("CC X+10 Y+0\nCP IPA-450 DR-", (10, 0), -2.5 * math.pi),
    "CR": ("CR X+10 Y+10 R+10 DR-", (10, 0), -math.pi / 2),
    "CR, the long way": ("CR X+10 Y+10 R-10 DR-", (0, 10), -1.5 * math.pi),
}


@pytest.mark.parametrize("name", ARCS)
def test_arcs(tmp_path: Path, name: str) -> None:
    text, center, sweep = ARCS[name]
    path = behind(tmp_path, text)
    path = path.take(np.flatnonzero(path.line == path.line[-1]))
    out = np.vstack([[0.0, 0.0], path.position[:, :2] * 1e3]) - center
    np.testing.assert_allclose(np.hypot(*out.T), np.hypot(*center), rtol=0, atol=1e-6)
    turned = np.unwrap(np.arctan2(out[:, 1], out[:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(sweep, abs=1e-9)


@pytest.mark.parametrize(("plane", "w"), [("YZ", 0), ("ZX", 1)])
def test_circles_in_other_planes(tmp_path: Path, plane: str, w: int) -> None:
    """CC names its axes; DR+ is right-handed about the third."""
    u, v = plane
    path = behind(tmp_path, f"CC {u}+0 {v}+10\nC {u}+10 {v}+10 DR+\nCP IPA+720 I{'XYZ'[w]}+6 DR+")
    first = path.take(np.flatnonzero(path.line == 5)).position * 1e3
    a, b = "XYZ".index(u), "XYZ".index(v)
    angle = np.unwrap(np.arctan2(first[:, b] - 10, first[:, a]))
    assert angle[0] > -math.pi / 2 and angle[-1] == pytest.approx(0, abs=1e-12) and (np.diff(angle) > 0).all()
    helix = path.take(np.flatnonzero(path.line == 6))
    assert helix.position[-1, w] * 1e3 == pytest.approx(6) and len(helix) > 100
    np.testing.assert_allclose(np.hypot(helix.position[:, a], helix.position[:, b] - 0.01) * 1e3, 10, atol=1e-9)


def test_ct_goes_on_in_the_direction_of_the_move_before(tmp_path: Path) -> None:
    path = behind(tmp_path, "L X+10\nCT X+20 Y+10\nCT X+30 Y+20")
    out = path.position[path.line == 5, :2] * 1e3 - [10, 10]
    np.testing.assert_allclose(np.hypot(*out.T), 10, rtol=0, atol=1e-9)
    out = path.position[path.line == 6, :2] * 1e3 - [30, 10]
    np.testing.assert_allclose(np.hypot(*out.T), 10, rtol=0, atol=1e-9)


def test_ctp_counts_from_the_pole(tmp_path: Path) -> None:
    path = behind(tmp_path, "CC X+10 Y+10\nL X+10\nCTP PR+10 PA+0")
    out = path.position[path.line == 6, :2] * 1e3 - [10, 10]
    np.testing.assert_allclose(np.hypot(*out.T), 10, rtol=0, atol=1e-9)


def test_polar_lines(tmp_path: Path) -> None:
    path = behind(
        tmp_path, "CC X+10 Y+20\nLP PR+5 PA+90\nLP IPA+90\nLP IPR+2\nLP PA+270 Z-3\nCC Z+0 X+0\nLP PR+1 PA+90 FMAX"
    )
    expected = [[10, 25, 0], [5, 20, 0], [3, 20, 0], [10, 13, -3], [1, 13, 0]]
    np.testing.assert_allclose(ends(path), expected, rtol=0, atol=1e-9)
    assert path.kind.tolist() == [CUT] * 4 + [RAPID]


@pytest.mark.parametrize(("end", "told"), [("X+10.015", ""), ("X+10.017", "radius is 5 mm at the start, 5.017 mm at")])
def test_how_far_the_end_may_lie_from_the_circle(tmp_path: Path, end: str, told: str) -> None:
    text = f"CC X+5 Y+0\nC {end} Y+0 DR-"
    if not told:
        assert ends(behind(tmp_path, text))[-1][0] == pytest.approx(10.015)
        return
    with pytest.raises(ReadError, match=told):
        behind(tmp_path, text)


CORNERS = {
    "RND R2": [[8, 0], [10, 2], [10, 10]],
    "RND 2": [[8, 0], [10, 2], [10, 10]],
    "CHF 2": [[8, 0], [10, 2], [10, 10]],
}


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize(("feed", "expected"), [("", 600), (" F50", 50)])
def test_corners(tmp_path: Path, corner: str, feed: str, expected: float) -> None:
    path = behind(tmp_path, f"L X+10\n{corner}{feed}\n* - between\nL Y+10")
    np.testing.assert_allclose(ends(path)[:, :2], CORNERS[corner], rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.feed[path.row % 1 == 0] * 6e4, [600, expected, 600])
    if "RND" in corner:
        arc = path.position[path.line == 5, :2] * 1e3
        np.testing.assert_allclose(np.hypot(*(arc - [8, 2]).T), 2, rtol=0, atol=1e-9)


def test_a_corner_between_a_line_and_an_arc(tmp_path: Path) -> None:
    """The rounding touches both: its centre is 2 mm from the line and 8 mm from the centre of the arc."""
    path = behind(tmp_path, "L X+20\nRND R2\nCC X+20 Y-10\nC X+30 Y-10 DR-\nL Y-30")
    assert ends(path)[-1].tolist() == [30, -30, 0]
    path = behind(tmp_path, "L X+20\nRND R2\nCC X+10 Y+0\nC X+10 Y+10 DR+")
    arc = path.position[path.line == 5, :2] * 1e3
    center = np.array([10 + math.sqrt(8**2 - 2**2), 2])
    np.testing.assert_allclose(np.hypot(*(arc - center).T), 2, rtol=0, atol=1e-9)


def test_retracts(tmp_path: Path) -> None:
    text = (
        "L X+10\nL Z-100 R0 FMAX M91\nL X+50 Y+50 FMAX\nL Z+20 FMAX\nM140 MB MAX\nL X+1 Y+1 Z+1 R0 FMAX\n"
        "L M140 MB5 F300\nL X+2"
    )
    path = behind(tmp_path, text)
    np.testing.assert_allclose(ends(path), [[10, 0, 0], [50, 50, 20], [1, 1, 1], [1, 1, 6], [2, 1, 6]])
    np.testing.assert_allclose(path.feed[[-2, -1]] * 6e4, [300, 600])
    said = [e.word for e in path.events]
    assert "L Z-100 R0 FMAX M91" in said and "M140 MB MAX" in said
    assert "L X+50 Y+50 FMAX, before the position is known" in said


def test_settings_and_remarks(tmp_path: Path) -> None:
    text = (
        "CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.01\nCYCL DEF 32.2 HSC-MODE:1 TA0.5\nM120 LA30\n"
        "CYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 V.ZEIT 2\nFUNCTION MODE MILL\nM27\nM90\nCYCL DEF 8.0 MIRROR\n"
        "CYCL DEF 8.1\nCYCL DEF 11.0 SCALING\n"
        "CYCL DEF 11.1 SCL 1\nFN 14: ERROR = 1000\nL X+1 M97 M27"
    )
    path = behind(tmp_path, text)
    said = [e.word for e in path.events]
    assert ends(path).tolist() == [[1, 0, 0]]
    assert "CYCL DEF 32.0 TOLERANCE" in said and "CYCL DEF 9.1 V.ZEIT 2" in said and said.count("M27") == 2
    assert "FN 14: ERROR = 1000" in said


def test_blocks_with_continuations_numbers_and_comments(tmp_path: Path) -> None:
    text = 'N10 L X+1 ; a ~ b\n12 L ~ ; first\n  Y+2 ~\n  Z+3\n13 ; "quoted; text"\n/ 14 STOP\n15 * ---- part ----'
    path = behind(tmp_path, text)
    np.testing.assert_allclose(ends(path), [[1, 0, 0], [1, 2, 3]])
    assert path.line.tolist() == [4, 5]


SKIPPED = {"/M8": True, "/ 15 STOP": True, "15 / L M9": True, "/L X+5": False, "/TOOL CALL 5 Z": False}


@pytest.mark.parametrize("text", SKIPPED)
def test_block_skip(tmp_path: Path, text: str) -> None:
    if SKIPPED[text]:
        assert any(e.word.startswith("/") for e in behind(tmp_path, f"{text}\nL X+1").events)
    else:
        with pytest.raises(ReadError, match="whether the block counts is chosen at the machine"):
            behind(tmp_path, text)


def test_an_end_that_may_be_skipped(tmp_path: Path) -> None:
    """Subprograms behind it are run by calls only."""
    path = behind(tmp_path, "CALL LBL 1\n/ 5 M30\nLBL 1\nL X+5\nLBL 0")
    assert ends(path).tolist() == [[5, 0, 0]]
    with pytest.raises(ReadError, match="whether the block counts"):
        behind(tmp_path, "/ 5 M30\nL X+5\nLBL 1\nL X+6\nLBL 0")
