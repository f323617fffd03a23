"""SINUMERIK 840D: modal words, feeds, tools, retracts, arcs, corners and polar words, in numbers worked out by hand."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, RAPID, Toolpath

HEAD = "G710 G90 G17\nG0 X0 Y0 Z0\nF600\n"
read = partial(read_text, "part.mpf")


def behind(tmp_path: Path, text: str, chord: float = 1e-5) -> Toolpath:
    """What stands behind HEAD, read, without the pose of HEAD."""
    path = read(tmp_path, f"{HEAD}{text}\nM30\n", chord)
    return path.take(np.flatnonzero(path.row > 0))


def words(path: Toolpath) -> list[tuple[int, str, int]]:
    return [(e.pose, e.word, e.line) for e in path.events]


def test_modal_words_feeds_and_tools(tmp_path: Path) -> None:
    text = (
        '%_N_PART_MPF\n;$PATH=/_N_WKS_DIR/_N_PART_WPD\nN10 G90 G94 G17 G710\nN20 T="MILL 10" D1\nM6\nS5000 M3\nG54\n'
        'G0 X1 Y2\nZ10.\ng1 z-.5 f300\nX4 ; side\nT="DRILL"\nG1Y-6.25F=600*2\n'
        ':100 MSG("A ; B")\nG0Z10 M9\nM6\nX0 H3\nM30\n'
    )
    path = read(tmp_path, text)
    expected = [[1, 2, 10], [1, 2, -0.5], [4, 2, -0.5], [4, -6.25, -0.5], [4, -6.25, 10], [0, -6.25, 10]]
    np.testing.assert_allclose(path.position, np.array(expected) / 1e3, rtol=0, atol=1e-15)
    assert path.kind.tolist() == [RAPID, CUT, CUT, CUT, RAPID, RAPID]
    np.testing.assert_allclose(path.feed, [math.nan, 0.005, 0.005, 0.02, math.nan, math.nan], rtol=1e-14)
    assert path.tool.tolist() == [1, 1, 1, 1, 1, 2] and path.line.tolist() == [9, 10, 11, 13, 15, 17]
    np.testing.assert_array_equal(path.axis, np.tile([0.0, 0.0, 1.0], (6, 1)))
    assert words(path) == [
        (0, "$PATH=/_N_WKS_DIR/_N_PART_WPD", 2), (0, 'T="MILL 10" (tool 1) D1', 4), (0, "M6", 5), (0, "S5000 M3", 6),
        (0, "G0 X1 Y2, before the position is known", 8), (2, "side", 11), (3, 'T="DRILL" (tool 2)', 12),
        (4, ':100 MSG("A ; B")', 14), (4, "M9", 15), (5, "M6", 16), (5, "H3", 17), (6, "M30", 18),
    ]  # fmt: skip


def test_a_tool_without_m6_is_in_use_at_once(tmp_path: Path) -> None:
    assert read(tmp_path, "G710\nT7\nG0 X1 Y1 Z1 ; M6\nT8 D1\nX2\nT7 D1\nX3\nM2\n").tool.tolist() == [7, 8, 7]


def test_units_and_relative_words(tmp_path: Path) -> None:
    path = read(tmp_path, "G700 G90\nG0 X1 Y2 Z3\nG91 G1 X.5 Z-1 F10\nX.5 Y=AC(0)\nG90 Y=IC(-1) Z1\nM2\n")
    expected = [[25.4, 50.8, 76.2], [38.1, 50.8, 50.8], [50.8, 0, 50.8], [50.8, -25.4, 25.4]]
    np.testing.assert_allclose(path.position * 1e3, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.feed[1:], [254e-3 / 60] * 3, rtol=1e-14)
    assert read(tmp_path, "G71\nG0 X1 Y2 Z3\nG1 X2 F60\nM2\n").feed[1] == 1e-3


def test_feeds_by_the_turn_by_the_time_and_of_one_block(tmp_path: Path) -> None:
    path = behind(tmp_path, "G95 F0.1 S3000\nG1 X10\nG94 F100 X20\nX30 FB=50\nX40\nG93 F4 X50\nF2 Y10\nG2 X60 CR=5 F6")
    np.testing.assert_allclose(ends(path)[:, 0], [10, 20, 30, 40, 50, 50, 60])
    feed = path.feed[path.row % 1 == 0] * 6e4
    np.testing.assert_allclose(feed, [300, 100, 50, 100, 40, 20, 5 * math.pi * 6], rtol=1e-7)


def test_dwell_takes_its_words_to_itself(tmp_path: Path) -> None:
    path = behind(tmp_path, "G4 F0.5\nG1 X10\nG4 S30\nX20")
    np.testing.assert_allclose(path.feed * 6e4, [600, 600])
    assert ("G4 F0.5" in [e.word for e in path.events]) and ("G4 S30" in [e.word for e in path.events])


ARCS = {
    "centre": ("G2 X10 Y10 I10 J0", (10, 0), -math.pi / 2),
    "centre, absolute": ("G3 X10 Y10 I=AC(0) J=AC(10)", (0, 10), math.pi / 2),
    "whole": ("G3 I-5", (-5, 0), math.tau),
    "whole, with turns": ("G2 I-5 TURN=2", (-5, 0), -3 * math.tau),
    "turns": ("G3 X10 Y10 I0 J10 TURN=1", (0, 10), math.tau + math.pi / 2),
    "radius": ("G2 X10 Y10 CR=10", (10, 0), -math.pi / 2),
    "radius, the long way": ("G2 X10 Y10 CR=-10", (0, 10), -1.5 * math.pi),
    "angle and end": ("G3 X10 Y10 AR=90", (0, 10), math.pi / 2),
    "angle and end, the long way": ("G3 X10 Y10 AR=270", (10, 0), 1.5 * math.pi),
    "through a point": ("CIP X10 Y10 I1=7.0710678118654755 J1=2.9289321881345245", (0, 10), math.pi / 2),
}


@pytest.mark.parametrize("name", ARCS)
@pytest.mark.parametrize("plane", [17, 18, 19])
def test_arcs(tmp_path: Path, name: str, plane: int) -> None:
    """In G17, and with the axes of the other planes in their place."""
    text, center, sweep = ARCS[name]
    u, v, w = {17: "XYZ", 18: "ZXY", 19: "YZX"}[plane]
    moved = {"X": u, "Y": v, "I": "IJK"["XYZ".index(u)], "J": "IJK"["XYZ".index(v)]}
    path = behind(
        tmp_path, f"G{plane}\n" + "".join(moved.get(c, c) for c in text.replace("CIP", "cip")) + f" {w}=IC(0)"
    )
    flat = path.position[:, ["XYZ".index(u), "XYZ".index(v)]] * 1e3
    out = np.vstack([[0.0, 0.0], flat]) - center
    np.testing.assert_allclose(np.hypot(*out.T), np.hypot(*center), rtol=0, atol=1e-6)
    turned = np.unwrap(np.arctan2(out[:, 1], out[:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(sweep, abs=1e-9)
    np.testing.assert_allclose(path.position[:, "XYZ".index(w)], 0, atol=1e-12)
    np.testing.assert_allclose(path.feed * 6e4, 600)


def test_an_angle_with_the_centre_leads_to_the_end(tmp_path: Path) -> None:
    path = behind(tmp_path, "G2 I0 J10 AR=90 Z5\nG1 Y0")
    np.testing.assert_allclose(ends(path), [[-10, 10, 5], [-10, 0, 5]], rtol=0, atol=1e-12)


def test_a_helix_rises_evenly_over_its_turns(tmp_path: Path) -> None:
    path = behind(tmp_path, "G3 X0 Y0 I5 J0 Z-9 TURN=2")
    share = path.row - path.row[0] + (path.row[1] - path.row[0])
    np.testing.assert_allclose(path.position[:, 2] * 1e3, -9 * share / share[-1], rtol=0, atol=1e-9)


def test_cip_counts_its_point_as_its_end(tmp_path: Path) -> None:
    absolute = behind(tmp_path, "G1 X5 Y5 Z5\nCIP X15 Y5 Z9 I1=10 J1=10 K1=7")
    relative = behind(tmp_path, "G1 X5 Y5 Z5\nG91 CIP X10 Y0 Z4 I1=5 J1=5 K1=2")
    mixed = behind(tmp_path, "G1 X5 Y5 Z5\nCIP X15 Y5 Z=IC(4) I1=IC(5) J1=10 K1=AC(7)")
    np.testing.assert_array_equal(absolute.position, relative.position)
    np.testing.assert_array_equal(absolute.position, mixed.position)
    near = np.linalg.norm(absolute.position * 1e3 - [10, 10, 7], axis=1).min()
    assert near < 0.4


def test_ct_goes_on_in_the_direction_of_the_move_before(tmp_path: Path) -> None:
    path = behind(tmp_path, "G1 X10\nCT X20 Y10\nX30 Y20\nG1 Y30\nCT Y40")
    out = path.position[path.line == 5, :2] * 1e3 - [10, 10]
    np.testing.assert_allclose(np.hypot(*out.T), 10, rtol=0, atol=1e-9)
    out = path.position[path.line == 6, :2] * 1e3 - [30, 10]
    np.testing.assert_allclose(np.hypot(*out.T), 10, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ends(path)[-1], [30, 40, 0], rtol=0, atol=1e-9)
    assert np.sum(path.line == 8) == 1  # straight on


@pytest.mark.parametrize(
    ("end", "told"), [("X10.009", ""), ("X10.011", "radius is 5 mm at the start, 5.011 mm at the end")]
)
def test_how_far_the_end_may_lie_from_the_circle(tmp_path: Path, end: str, told: str) -> None:
    if not told:
        assert ends(behind(tmp_path, f"G2 {end} I5"))[-1][0] == pytest.approx(10.009)
        return
    with pytest.raises(ReadError, match=told):
        behind(tmp_path, f"G2 {end} I5")


def test_of_large_arcs_the_share_of_the_radius_counts(tmp_path: Path) -> None:
    assert len(behind(tmp_path, "G2 X1000.4 I500")) > 1
    with pytest.raises(ReadError, match="radius is 500 mm at the start"):
        behind(tmp_path, "G2 X1000.6 I500")


CORNERS = {
    "RND=2": [[8, 0], [10, 2], [10, 10]],
    "CHR=2": [[8, 0], [10, 2], [10, 10]],
    "CHF=2": [[10 - math.sqrt(2), 0], [10, math.sqrt(2)], [10, 10]],
    "RND=0": [[10, 0], [10, 10]],
}


@pytest.mark.parametrize("corner", CORNERS)
def test_corners(tmp_path: Path, corner: str) -> None:
    path = behind(tmp_path, f"G1 X10 {corner}\nMSG(\"between\")\nY10 F300")
    np.testing.assert_allclose(ends(path)[:, :2], CORNERS[corner], rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.feed[path.row % 1 == 0][-2:] * 6e4, [300, 300] if corner != "RND=0" else [600, 300])
    if corner == "RND=2":
        arc = path.position[(path.line == 4) & (path.row > 1), :2] * 1e3
        np.testing.assert_allclose(np.hypot(*(arc - [8, 2]).T), 2, rtol=0, atol=1e-9)


def test_a_corner_has_a_feed_of_its_own(tmp_path: Path) -> None:
    path = behind(tmp_path, "G1 X10 RND=2 FRC=100\nY10")
    np.testing.assert_allclose(path.feed[path.row % 1 == 0] * 6e4, [600, 100, 600])


def test_polar_words(tmp_path: Path) -> None:
    path = behind(
        tmp_path,
        "G111 X10 Y20\nG1 AP=90 RP=5\nAP=IC(90)\nG3 AP=-90 RP=5\nG110 X1\nG1 AP=0 RP=2\nG112 AP=90 RP=3\nAP=180 RP=1",
    )
    expected = [[10, 25], [5, 20], [10, 15], [13, 15], [10, 18]]
    np.testing.assert_allclose(ends(path)[:, :2], expected, rtol=0, atol=1e-9)
    arc = path.position[path.line == 7, :2] * 1e3 - [10, 20]
    np.testing.assert_allclose(np.hypot(*arc.T), 5, rtol=0, atol=1e-9)


def test_retracts_to_the_machine_lose_their_axes(tmp_path: Path) -> None:
    text = "G1 X10\nSUPA G0 Z=_HOME_Z D0\nG0 X50 Y50\nG0 Z20\nG53 X0\nG153 Y0\nG0 X0 Y0\nG75 Z1=0\nG0 X1 Y1 Z1\nG1 X2"
    path = behind(tmp_path, text)
    np.testing.assert_allclose(ends(path), [[10, 0, 0], [50, 50, 20], [0, 0, 20], [1, 1, 1], [2, 1, 1]])
    said = [e.word for e in path.events]
    assert "SUPA G0 Z=_HOME_Z D0" in said and "G0 X50 Y50, before the position is known" in said and "G75 Z1=0" in said


def test_a_retract_leads_around_what_is_cut(tmp_path: Path) -> None:
    """Straight from the end of one cut into the begin of the next would lead through the part."""
    path = behind(tmp_path, "G1 X0 Y0 Z-20\nG1 X100\nSUPA G0 Z0\nG0 X0 Y50\nZ-20\nG1 X100")
    between = path.take(np.flatnonzero(path.row % 1 != 0))
    assert len(between) == 2 and (between.kind == RAPID).all()
    np.testing.assert_allclose(between.position[:, :2] * 1e3, [[100, 0], [0, 50]], atol=1e-9)
    assert (between.position[:, 2] > 5e-3).all()


def test_settings_and_remarks(tmp_path: Path) -> None:
    text = (
        "SOFT FFWON COMPCAD G642\nCYCLE832(0.01,_ORI_FINISH,0.1)\nCTOL=0.01 OTOL=0.5\nSPOS=DC(0)\nFGROUP(X,Y)\n"
        'WORKPIECE(,,,"BOX",112,0,-20,-80,0,0,100,100)\nSETMS(1)\nSTOPRE\n'
        "G60 G601\nFGREF[A]=100\nM1=3 S1=900\nG25 S100\n"
        "ACC[X]=80\n$A_OUT[1]=1\nG1 X10"
    )
    path = behind(tmp_path, text)
    said = [e.word for e in path.events]
    assert ends(path).tolist() == [[10, 0, 0]]
    assert "CYCLE832(0.01,_ORI_FINISH,0.1)" in said and "FGROUP(X,Y)" in said and "$A_OUT[1]=1" in said


def test_a_second_spindle_is_not_that_of_the_feed(tmp_path: Path) -> None:
    path = behind(tmp_path, "S1000\nS2=50\nG95 F0.1\nG1 X10\nSETMS(2)\nX20")
    np.testing.assert_allclose(path.feed * 6e4, 100)
