"""APT/CL and NX CLSF: hand-computed values; what is refused names line and word."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.apt.words import EVENTS, PASSED
from toolpaths.languages.apt.words import REFUSED as REFUSED_WORDS
from toolpaths.toolpath import CUT, RAPID, Toolpath


def read(tmp_path: Path, text: str, **options: float) -> Toolpath:
    file = tmp_path / "part.cls"
    file.write_text(text)
    return read_toolpath(file, **options)


def test_nx_path(tmp_path: Path) -> None:
    text = (
        "TOOL PATH/OP1,TOOL,MILL_10\nTLDATA/MILL,10.0,1.0,75.0,0.0,0.0\n"
        "MSYS/1.0,2.0,3.0,1.0,0.0,0.0,0.0,1.0,0.0\n$$ centerline data\nPAINT/COLOR,186\n"
        "LOAD/TOOL,7,ADJUST,7 \nSELECT/TOOL,8\nRAPID\nGOTO/10.0,20.0,30.0,0.6,0.0,0.8\nFEDRAT/MMPM,250.0000\n"
        "GOTO/10.0,20.0,-1.5\nGOTO/1.0E1,-2.5,$\n 3.25\nRAPID\nGOTO/0,0,50,0,0,1\nEND-OF-PATH\n"
    )
    path = read(tmp_path, text)
    expected = [[10, 20, 30], [10, 20, -1.5], [10, -2.5, 3.25], [0, 0, 50]]
    np.testing.assert_allclose(path.position, np.array(expected) / 1e3, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.axis, [[0.6, 0, 0.8]] * 3 + [[0, 0, 1]], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(path.kind, [RAPID, CUT, CUT, RAPID])
    np.testing.assert_allclose(path.feed, [np.nan, 0.25 / 60, 0.25 / 60, np.nan], rtol=1e-14)
    np.testing.assert_array_equal(path.tool, [7] * 4)
    np.testing.assert_array_equal(path.line, [9, 11, 12, 15])
    words = [(e.pose, e.word, e.line) for e in path.events]
    assert (0, "TOOL PATH/OP1,TOOL,MILL_10", 1) in words and (0, "centerline data", 4) in words
    assert path.language == "apt" and path.quaternion is None


def test_apt_dialect(tmp_path: Path) -> None:
    text = (
        "PARTNO PLATE 7/8\nMULTAX / ON\nUNITS / INCHES\nLOADTL / 3, 1\nSPINDL / 1200.0, RPM, CLW\nCOOLNT/ON\n"
        "FROM / 0, 0, 10, 0, 0, 1\nFEDRAT / 0.005, IPR\nGOTO / 1.0, 2.0, 3.0\nFEDRAT/12.5,IPM\ngoto/4,5,6\n"
        "FEDRAT/254,MMPM\nGOTO/4,5,7\nFEDRAT/10\nGOTO/4,5,8\nFINI\n"
    )
    path = read(tmp_path, text)
    expected = np.array([[0, 0, 10], [1, 2, 3], [4, 5, 6], [4, 5, 7], [4, 5, 8]]) * 25.4e-3
    np.testing.assert_allclose(path.position, expected, rtol=1e-14)
    np.testing.assert_array_equal(path.kind, [RAPID, CUT, CUT, CUT, CUT])
    feeds = np.array([0.005 * 1200 * 25.4, 12.5 * 25.4, 254, 254]) / 60e3
    np.testing.assert_allclose(path.feed[1:], feeds, rtol=1e-13)
    np.testing.assert_array_equal(path.tool, [3] * 5)
    assert path.events[0].word == "PARTNO/PLATE 7/8"


def test_rapid_holds_for_one_goto(tmp_path: Path) -> None:
    path = read(tmp_path, "UNITS/MM\nRAPID/\nPAINT/PATH\nGOTO/1,1,1\nGOTO/2,1,1\nFINI\n")
    np.testing.assert_array_equal(path.kind, [RAPID, CUT])
    assert np.isnan(path.feed).all()  # the file gives none


def test_unit_from_the_feed(tmp_path: Path) -> None:
    for word, unit in (("MMPM", 1e-3), ("IPM", 25.4e-3)):
        path = read(tmp_path, f"RAPID\nGOTO/1,2,3\nFEDRAT/{word},60\nGOTO/2,3,4\nFINI\n")
        np.testing.assert_allclose(path.position, np.array([[1, 2, 3], [2, 3, 4]]) * unit, rtol=1e-14)
        np.testing.assert_allclose(path.feed[1], unit, rtol=1e-14)


def test_second_frame_is_turned_into_the_first(tmp_path: Path) -> None:
    first, second = "MSYS/10,0,0,0,1,0,-1,0,0", "MSYS/0,0,5,1,0,0,0,0,1"
    text = (
        f"UNITS/MM\nTOOL PATH/A\n{first}\nGOTO/1,2,3\nEND-OF-PATH\n"
        f"TOOL PATH/B\n{second}\nGOTO/1,2,3,0,0,1\nEND-OF-PATH\n"
    )
    path = read(tmp_path, text)
    # by hand: second frame has x, y, z along absolute x, z, -y, so 1,2,3 lies at absolute (1, -3, 7);
    # less the first origin (-9, -3, 7), along its axes (0,1,0), (-1,0,0), (0,0,1): (-3, 9, 7)
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 3], [-3, 9, 7]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.axis, [[0, 0, 1], [-1, 0, 0]], rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("axis", "end", "middle", "sweep"),
    [  # clockwise about the axis, as NX writes it
        ("0,0,-1", "0,10,0", [math.sqrt(50), math.sqrt(50), 0], 0.5),
        ("0,0,1", "0,10,0", [-math.sqrt(50), -math.sqrt(50), 0], 1.5),
        ("0,1,0", "0,0,10", [math.sqrt(50), 0, math.sqrt(50)], 0.5),
        ("0,0,-1", "10,0,0", [-10, 0, 0], 2.0),
        ("0,0,-1", "-10,0,4", [0, 10, 2], 1.0),
    ],
)
def test_nx_circle(tmp_path: Path, axis: str, end: str, middle: list[float], sweep: float) -> None:
    circle = f"CIRCLE/0,0,0,{axis},10,0.06,0.5,8,1"
    text = f"FEDRAT/MMPM,100\nGOTO/10,0,0\n{circle}\nPAINT/COLOR,31\nGOTO/{end}\nFINI\n"
    path = read(tmp_path, text, chord=1e-6)
    np.testing.assert_allclose(path.position[-1] * 1e3, [float(v) for v in end.split(",")], atol=1e-12)
    np.testing.assert_allclose(path.position[len(path) // 2] * 1e3, middle, atol=0.5)
    length = np.linalg.norm(np.diff(path.position, axis=0), axis=1).sum() * 1e3
    rise = float(end.split(",")[2]) if axis[0:3] == "0,0" else 0.0
    np.testing.assert_allclose(length, math.hypot(sweep * math.pi * 10, rise), rtol=1e-3)


def test_circles_of_real_files_join_their_lines_smoothly(shared: Path) -> None:
    """NX means clockwise: then the way into and out of each circle of the pocket has no corner."""
    path = read_toolpath(shared / "data/cam/clsf_nx/_3_PAZ_125_N2.cls", chord=1e-6)
    step = np.diff(path.position, axis=0)
    step = step[np.linalg.norm(step, axis=1) > 1e-4]
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    turn = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", step[1:], step[:-1]), -1, 1)))
    # drawn the other way round, 320 of the joints would turn back
    assert (turn > 150).sum() == 0


REFUSED = {
    "CYCLE/DRILL,MMPM,250": (3, "CYCLE/DRILL,MMPM,250: FEDTO (or DEPTH) and RAPTO"),
    "CYCLE": (3, "read are DRILL, CSINK"),
    "CYCLE/TAP,FEDTO,5,RAPTO,2,MMPR,1": (3, "the spindle has to turn with the feed"),
    "CYCLE/DRILL,FEDTO,-5,RAPTO,2,MMPM,100": (3, "a depth below 0"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,-6,MMPM,100": (3, "RAPTO lies below"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2,MMPM,0": (3, "a feed above 0"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2,MMPM,1,IPM,1": (3, "two words for the same"),
    "CYCLE/DRILL,FEDTO,5,DEPTH,5,RAPTO,2": (3, "two words for the same"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2,FEDTO,6": (3, "FEDTO,6: each of"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2,CSINK,6": (3, "CSINK,6: each of"),
    "CYCLE/DRILL,FEDTO,5,RAPTO": (3, "RAPTO,: each of"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,1E999": (3, "RAPTO,1E999: each of"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2,DWELL,-1": (3, "a dwell of 0"),
    "CYCLE/DEEP,FEDTO,5,RAPTO,2,INCR,0": (3, "a step above 0"),
    "CYCLE/DEEP,FEDTO,5,RAPTO,2,SUBPECK,1": (3, "a step above 0"),
    "CYCLE/DEEP,FEDTO,5,RAPTO,2,INCR,1E-300": (3, "more than 200 pecks"),
    "CYCLE/DEEP,FEDTO,398.5,RAPTO,2,INCR,2": (3, "more than 200 pecks"),
    "CYCLE/BORE,DRAG,FEDTO,5,RAPTO,2": (3, "DRAG,FEDTO: each of"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2\nRAPID": (4, "a drilling cycle is in force"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2\nFROM/0,0,9": (4, "a drilling cycle is in force"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2\nGODLTA/0,0,9": (4, "a drilling cycle is in force"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2\nLOADTL/2": (4, "CYCLE/OFF is missing"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2\nCIRCLE/0,2,3,0,0,1": (4, "a drilling cycle is in force"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2,MMPM,9\nFEDRAT/5,MMPM": (4, "another feed within a cycle"),
    "RAPID\nCYCLE/DRILL,FEDTO,5,RAPTO,2,MMPM,9": (4, "a cycle between RAPID"),
    "CYCLE/DRILL,FEDTO,5,RAPTO,2,MMPR,.1\nGOTO/1,2,3": (4, "no speed in RPM"),
    "CUTCOM/LEFT,XYPLAN": (3, "the cutter is not in the file"),
    "CUTTER/0,0\nCUTCOM/LEFT": (4, "the cutter has diameter 0"),
    "CUTTER/5,0\n$$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_PROFILE\nCUTCOM/RIGHT": (5, "OUTPUT_ON_PROFILE"),
    "CUTTER/5,0\nCUTCOM/NORMDS": (4, "LEFT, RIGHT, ON or OFF"),
    "CUTTER/5,0\nCUTCOM/LEFT,NORMDS": (4, "only ADJUST"),
    "CUTCOM": (3, "LEFT, RIGHT, ON or OFF"),
    "GODLTA/1,2": (3, "1 or 3 or 6 numbers"),
    "GOHOME": (3, "the place of home"),
    "MOVARC/0,0,0,0,0,1,5,ANGLE,90": (3, "arcs in this form"),
    "SET/MODE,INCR": (3, "absolute coordinates"),
    "PARTNO/TWO": (3, "Two programs?"),
    "GOFWD/C1,PAST,L1": (3, "APT source"),
    "NURBS/1": (3, "splines"),
    "FROBNICATE/1": (3, "FROBNICATE/1: this reader does not know the word"),
    "GOTO/1,2": (3, "3 or 6 numbers"),
    "GOTO/1,2,3,4": (3, "3 or 6 numbers"),
    "GOTO/1,2,nan": (3, "3 or 6 numbers"),
    "GOTO/P1": (3, "3 or 6 numbers"),
    "GOTO/1,2,1_0": (3, "3 or 6 numbers"),
    "GOTO/1,2,1E300": (3, "below 1e+09"),
    "GOTO/1,2,3,0,0,0": (3, "length 0"),
    "GOTO/1,2,3,0,0,1.1": (3, "length 1.1"),
    "GOTO/2000000,2,3": (3, "beyond 1000 m"),
    "FEDRAT/MMPM": (3, "one number"),
    "FEDRAT/100,FPM": (3, "one number"),
    "FEDRAT/0,MMPM": (3, "above 0"),
    "FEDRAT/0.1,MMPR\nGOTO/1,1,1": (4, "no speed in RPM"),
    "SPINDL/100,SFM\nFEDRAT/0.1,MMPR\nGOTO/1,1,1": (5, "no speed in RPM"),
    "RAPID/ON": (3, "plain RAPID"),
    "UNITS/INCHES": (3, "unit changes"),
    "UNITS/FURLONG": (3, "MM or INCHES"),
    "LOAD/TOOL": (3, "tool number"),
    "LOAD/WIRE,1": (3, "tool number"),
    "LOADTL/1.5": (3, "tool number"),
    "MSYS/0,0,0,1,0,0,0,1,0": (3, "comes after poses"),
    "CSYS/1,0,0,0,0,1,0,0,0,0,1,0": (3, "comes after poses"),
    "TRNTYP/PART,0,0,0": (3, "TRNTYP/WORLD"),
    "MULTAX/MAYBE": (3, "MULTAX"),
    "CSYS/1,0,0,0,0,1,0,0,0,0,1": (3, "12 numbers"),
    "CSYS/1,0,0,0,0,1,0,0,0,0,2,0": (3, "three rows of a rotation"),
    "$$-> CSYS / 1,0,0,0,0,1,0,0,0,0,1,0\n$$-> CSYS / 1,0,0,5, $\n 0,1,0,0,0,0,1,0": (4, "a second coordinate system"),
    "$$*CATIA0\n$$ A\n$$ 1 0 0 0\n$$ 0 1 0 0\n$$ 0 0 1 0\n$$*CATIA0\n$$ 1 0 0 0\n$$ 0 1 0 0\n$$ 0 0 1 5": (
        11,
        "a second coordinate system",
    ),
    "CIRCLE/0,0,0,0,0": (3, "5 values"),
    "CIRCLE/0,0,0,0,0,1,1,.1,.1,1,1,TIMES,0": (3, "TIMES with a number above 0"),
    "CIRCLE/0,0,0,0,0,1,1,.1,.1,1,1,TIMES,101": (3, "TIMES with a number above 0"),
    "CIRCLE/0,2,3,0,0,1,1,.1,.1,1,1,TIMES,2\nGOTO/-1,2,5": (3, "TIMES,2, but the end lies 0.5 of a turn"),
    "CIRCLE/0,2,3,0,0,1,TIMES,5E-4\nGOTO/1,2,3": (3, "TIMES,0.0005, but the end lies 1 of a turn"),
    "CIRCLE/0,2,3,0,0,1\nGOTO/-1.1,2,3": (3, "the ends lie 1 and 1.1 from its centre"),
    "CIRCLE/1,2,3,0,0,1\nGOTO/1,2,3": (3, "the ends lie 0 and 0"),
    "CIRCLE/0,2,3,0,0,1\nCIRCLE/0,2,3,0,0,1": (3, "no GOTO follows"),
    "CIRCLE/0,2,3,0,0,1\nFROM/-1,2,3": (4, "a start between a circle"),
    "RAPID\nCIRCLE/0,2,3,0,0,1": (4, "RAPID between"),
    "CIRCLE/0,2,3,0,0,1,5,.1,.1,1,1\nGOTO/-1,2,3": (3, "radius 5"),
    "CIRCLE/0,2,3,0,0,2,1,.1,.1,1,1\nGOTO/-1,2,3": (3, "length 2"),
    "CIRCLE/0,2,3,0,0,1,1,.1,.1,1,1\nRAPID\nGOTO/-1,2,3": (3, "RAPID between"),
    "CIRCLE/0,2,3,0,0,1,1,.1,.1,1,1\nGOTO/-1,2,3,0,1,0": (3, "turns along a circle"),
    "CIRCLE/0,2,3,0,0,1,1,.1,.1,1,1": (3, "no GOTO follows"),
    "GOTO/1,2,3,1,0,0\nMULTAX/OFF\nGOTO/1,2,3": (5, "no tool axis"),
    "GOTO/1,2,3,1,0,0\nTOOL PATH/B\nGOTO/1,2,3": (5, "no tool axis"),
    "TOOL PATH/B\nTOOL PATH/C": (4, "before END-OF-PATH"),
    "TOOL PATH/B\nEND-OF-PATH\nGOTO/1,1,1": (5, "a move outside a path"),
    "TOOL PATH/B\nCYCLE/DRILL,FEDTO,5,RAPTO,7": (4, "a depth above 0 lies above the point in CLSF"),
    "FINI\nGOTO/1,2,3": (4, "after FINI"),
    "!!!": (3, "not an APT statement"),
}


@pytest.mark.parametrize(("text", "expected"), REFUSED.items(), ids=list(REFUSED))
def test_refused_by_line_and_word(tmp_path: Path, text: str, expected: tuple[int, str]) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"UNITS/MM\nGOTO/1,2,3\n{text}\nFINI\n")
    assert expected[1] in str(caught.value)
    assert caught.value.line == expected[0]


@pytest.mark.parametrize(
    ("text", "line", "word"),
    [
        ("GOTO/1,2,3\nFINI\n", None, "no units"),
        (
            "FEDRAT/MMPM,10\nGOTO/1,2,3\nFEDRAT/IPM,10\nGOTO/2,2,3\nFINI\n",
            None,
            "in mm (MMPM) as well as in inch",
        ),
        ("FEDRAT/100\nGOTO/1,2,3\nFINI\n", 1, "feed without unit"),
        ("GOTO/1,2,3\nUNITS/MM\nFINI\n", 2, "unit changes"),
        ("UNITS/MM\nGOTO/1,2,3\n", None, "cut off: FINI or END-OF-PATH"),
        ("UNITS/MM\nTOOL PATH/A\nGOTO/1,2,3\n", None, "cut off: END-OF-PATH"),
        ("UNITS/MM\nTOOL PATH/A\nGOTO/1,2,3\nEND-OF-PATH\nTOOL PATH/B\nGOTO/1,2,3\n", None, "cut off: END-OF-PATH"),
        ("UNITS/MM\nGOTO/1,2,$\n", 2, "continued"),
        ("UNITS/MM\nFINI\n", None, "no move"),
        ("MSYS/0,0,0,1,0,0,1,0,0\n", 1, "right angles"),
        ("UNITS/MM\nGODLTA/1,2,3\nFINI\n", 2, "says from where"),
        ("UNITS/MM\nCIRCLE/1,2,3,0,0,1\nFINI\n", 2, "says where it starts"),
        ("UNITS/MM\nCSYS/1,0,0,0,0,1,0,0,0,0,1,0\nCSYS/1,0,0,9,0,1,0,0,0,0,1,0\n", 3, "without TRNTYP/WORLD"),
        ("%\nO1000\nG21 G90\n", 1, "not an APT statement"),
        ("G21 G90\nG1 X5\n", 1, "G21/G90: this reader does not know the word"),
    ],
)
def test_head_and_end(tmp_path: Path, text: str, line: int | None, word: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, text)
    assert caught.value.line == line and word in str(caught.value)


def corners(path: Toolpath) -> list[list[float]]:
    """Poses that are no points of an arc, mm."""
    return (path.position[path.row % 1 == 0] * 1e3).round(9).tolist()


def test_relative_moves(tmp_path: Path) -> None:
    text = (
        "UNITS/MM\nFROM/1,2,30,0.6,0,0.8\nGODLTA/1,-2,3\nGODLTA/-10\nRAPID\nGODLTA/0,0,20,0,0,1\nGODLTA/2.5\n"
        "GOHOME/1,2,80\nFINI\n"
    )
    path = read(tmp_path, text)
    assert corners(path) == [[1, 2, 30], [2, 0, 33], [-4, 0, 25], [-4, 0, 45], [-4, 0, 47.5], [1, 2, 80]]
    np.testing.assert_array_equal(path.kind, [RAPID, CUT, CUT, RAPID, CUT, RAPID])
    np.testing.assert_allclose(path.axis, [[0.6, 0, 0.8]] * 3 + [[0, 0, 1]] * 3, rtol=0, atol=1e-15)


@pytest.mark.parametrize("radius", ["", ",10"])
@pytest.mark.parametrize(
    ("axis", "end", "middle", "sweep"),
    [  # counterclockwise about the axis, as SolidWorks CAM writes it
        ("0,0,1", "0,10,0", [math.sqrt(50), math.sqrt(50), 0], 0.5),
        ("0,0,-1", "0,10,0", [-math.sqrt(50), -math.sqrt(50), 0], 1.5),
        ("0,-1,0", "0,0,10", [math.sqrt(50), 0, math.sqrt(50)], 0.5),
        ("0,0,1", "10,0,0", [-10, 0, 0], 2.0),
        ("0,0,1", "-10,0,4", [0, 10, 2], 1.0),
    ],
)
def test_circle_of_six_and_seven_numbers(
    tmp_path: Path, radius: str, axis: str, end: str, middle: list[float], sweep: float
) -> None:
    text = f"UNIT/MM\nFEDRAT/100.,MMPM\nGOTO/10,0,0\nCIRCLE/0,0,0,{axis}{radius}\nFEDRAT/60,MMPM\nGOTO/{end}\nFINI\n"
    path = read(tmp_path, text, chord=1e-6)
    np.testing.assert_allclose(path.position[-1] * 1e3, [float(v) for v in end.split(",")], atol=1e-12)
    np.testing.assert_allclose(path.position[len(path) // 2] * 1e3, middle, atol=0.5)
    rise = float(end.split(",")[2]) if axis[0:3] == "0,0" else 0.0
    length = np.linalg.norm(np.diff(path.position, axis=0), axis=1).sum() * 1e3
    np.testing.assert_allclose(length, math.hypot(sweep * math.pi * 10, rise), rtol=1e-3)
    np.testing.assert_allclose(path.feed[1:], 1e-3, rtol=1e-14)


@pytest.mark.parametrize(
    ("end", "times", "turns"), [("10,0,9", "3", 3.0), ("0,-10,9", "2.25", 2.25), ("10,0,1", "1", 1)]
)
def test_helix_of_several_turns(tmp_path: Path, end: str, times: str, turns: float) -> None:
    circle = f"CIRCLE/0,0,0,0,0,1,10,0.06,0.5,8,1,TIMES,{times}"
    path = read(tmp_path, f"FEDRAT/MMPM,100\nGOTO/10,0,0\n{circle}\nGOTO/{end}\nFINI\n", chord=1e-6)
    mm = path.position * 1e3
    angle = np.unwrap(np.arctan2(mm[:, 1], mm[:, 0]))
    assert angle[-1] == pytest.approx(-2 * math.pi * turns) and (np.diff(angle) < 0).all()
    np.testing.assert_allclose(mm[:, 2], float(end.split(",")[2]) * angle / angle[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(mm[:, :2], axis=1), 10, rtol=1e-12)


HOLES = {  # heights after the start at 40 above the point 1, 2, 3: rapids as they are, cuts in brackets
    "DRILL,FEDTO,8,RAPTO,2,MMPM,60": [2, [-8], 2],
    "DRILL,FEDTO,8,MMPM,60,RAPTO,2,RTRCTO,25,DWELL,0": [2, [-8], 25],
    "DRILL,DEPTH,8,MMPM,60,CLEAR,2,RETURN,1": [2, [-8], 2],
    "CSINK,FEDTO,1,MMPM,60,RAPTO,2,RTRCTO,AUTO": [2, [-1], 40],
    "FACE,FEDTO,1,MMPM,60,RAPTO,2,AUTO": [2, [-1], 40],
    "DRILL,FEDTO,8,MMPM,60,RAPTO,2,RTRCTO,25,MANUAL": [2, [-8], 25],
    "DRILL,FEDTO,8,MMPM,60,RAPTO,2,RTRCTO,50": [50, 2, [-8], 50],
    "DEEP,FEDTO,8,INCR,4,MMPM,60,RAPTO,2": [2, [-2], 2, -1.6, [-6], 2, -5.6, [-8], 2],
    "DEEP2,FEDTO,8,1STPECK,5,SUBPECK,2,MMPM,60,RAPTO,1": [1, [-4], 1, -3.8, [-6], 1, -5.8, [-8], 1],
    "DEEP2,FEDTO,8,1STPECK,.25,SUBPECK,5,MMPM,60,RAPTO,2": [2, [1.75], 2, [-3.25], 2, -2.75, [-8], 2],
    "BRKCHP,FEDTO,8,STEP,5,MMPM,60,RAPTO,2,RTRCTO,9": [2, [-3], -2.5, [-8], 9],
    "DEEP,FEDTO,8,INCR,50,MMPM,60,RAPTO,2": [2, [-8], 2],
    "DEEP,FEDTO,8,MMPM,60,RAPTO,2": [2, [-8], 2],
    "BORE,FEDTO,8,MMPM,60,RAPTO,2,RTRCTO,9": [2, [-8], [2], 9],
    "REAM,FEDTO,8,MMPM,60,RAPTO,2": [2, [-8], [2]],
    "DRILL,FEDTO,0,MMPM,60,RAPTO,2": [2, [0], 2],
}


@pytest.mark.parametrize("tilted", [False, True])
@pytest.mark.parametrize("words", HOLES)
def test_drilling_cycles(tmp_path: Path, words: str, tilted: bool) -> None:
    axis = np.array([0.0, 0.6, 0.8]) if tilted else np.array([0.0, 0.0, 1.0])
    point, start = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0]) + 40 * axis
    given = ",".join(map(str, [*start, *axis]))
    text = f"UNITS/MM\nRAPID\nGOTO/{given}\nCYCLE/INIT\nCYCLE/{words}\nGOTO/1,2,3\nCYCLE/OFF\nGOTO/0,0,90\nFINI\n"
    path = read(tmp_path, text.replace("GOTO/0,0,90", "FEDRAT/30,MMPM\nGOTO/0,0,90"))
    heights = [h for item in HOLES[words] for h in (item if isinstance(item, list) else [item])]
    kinds = [CUT if isinstance(item, list) else RAPID for item in HOLES[words]]
    expected = [start, *(point + h * axis for h in heights), [0, 0, 90]]
    np.testing.assert_allclose(path.position * 1e3, expected, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(path.kind, [RAPID, *kinds, CUT])
    np.testing.assert_allclose(path.feed[path.kind == CUT] * 6e4, [60] * sum(kinds) + [30], rtol=1e-12)
    np.testing.assert_array_equal(path.line[1:-1], [6] * len(kinds))
    np.testing.assert_array_equal(path.axis, [axis] * len(path))


def test_between_holes_up_then_across(tmp_path: Path) -> None:
    """From a low hole to a high one the tool first leaves along its axis; to a low one it goes across first."""
    cycle = "CYCLE/DRILL,FEDTO,5,RAPTO,2,MMPM,60"
    text = f"UNITS/MM\n{cycle}\nGOTO/0,0,0\nGOTO/10,0,30\nGOTO/20,0,0\nCYCLE/OFF\nFINI\n"
    expected = [[0, 0, 2], [0, 0, -5], [0, 0, 2], [0, 0, 32], [10, 0, 32], [10, 0, 25], [10, 0, 32], [20, 0, 32]]
    assert corners(read(tmp_path, text)) == [*expected, [20, 0, 2], [20, 0, -5], [20, 0, 2]]


def test_auto_retract_is_the_height_before_the_cycle(tmp_path: Path) -> None:
    """Or, over a hole that is higher, RAPTO of that hole."""
    cycle = "CYCLE/DRILL,FEDTO,5,RAPTO,2,RTRCTO,AUTO,MMPM,60"
    text = f"UNITS/MM\nRAPID\nGOTO/0,0,20\n{cycle}\nGOTO/0,0,0\nGOTO/10,0,30\nGOTO/20,0,0\nCYCLE/OFF\nFINI\n"
    expected = [[0, 0, 20], [0, 0, 2], [0, 0, -5], [0, 0, 20], [0, 0, 32], [10, 0, 32], [10, 0, 25], [10, 0, 32]]
    expected += [[20, 0, 32], [20, 0, 2], [20, 0, -5], [20, 0, 20]]
    assert corners(read(tmp_path, text)) == expected


def test_auto_retract_with_another_axis_is_rapto(tmp_path: Path) -> None:
    """The height before the cycle was along another axis: nothing that the tool could go back to."""
    cycle = "CYCLE/DRILL,FEDTO,5,RAPTO,2,RTRCTO,AUTO,MMPM,60"
    path = read(tmp_path, f"UNITS/MM\nRAPID\nGOTO/0,0,50\n{cycle}\nGOTO/-90,1,2,1,0,0\nCYCLE/OFF\nFINI\n")
    assert corners(path) == [[0, 0, 50], [-88, 1, 2], [-95, 1, 2], [-88, 1, 2]]
    np.testing.assert_array_equal(path.axis[1:], [[1, 0, 0]] * 3)


@pytest.mark.parametrize(
    ("begun", "word"),
    [("CIRCLE/0,0,0,0,0,1", "between a circle and its end"), ("CYCLE/DRILL,FEDTO,1,RAPTO,1", "a drilling cycle")],
)
def test_frame_must_not_change_in_the_middle(tmp_path: Path, begun: str, word: str) -> None:
    first, second = "MSYS/0,0,0,1,0,0,0,1,0", "MSYS/0,0,7,1,0,0,0,1,0"
    text = f"UNITS/MM\nFEDRAT/60,MMPM\n{first}\nGOTO/1,0,0\n{begun}\n%s\nGOTO/-1,0,0\nFINI\n"
    assert len(read(tmp_path, text % first)) > 3
    with pytest.raises(ReadError, match=word) as caught:
        read(tmp_path, text % second)
    assert caught.value.line == 6


def test_end_of_path_ends_cycle_and_rapid(tmp_path: Path) -> None:
    text = (
        "UNITS/MM\nTOOL PATH/A\nCYCLE/DRILL,FEDTO,-5,RAPTO,2,MMPM,60\nGOTO/0,0,0\nEND-OF-PATH\n"
        "TOOL PATH/B\nGOTO/7,8,9\nRAPID\nEND-OF-PATH\nTOOL PATH/C\nGOTO/1,2,3\nEND-OF-PATH\n"
    )
    path = read(tmp_path, text)
    assert corners(path) == [[0, 0, 2], [0, 0, -5], [0, 0, 2], [7, 8, 9], [1, 2, 3]]
    np.testing.assert_array_equal(path.kind, [RAPID, CUT, RAPID, CUT, CUT])


def test_nx_cycle_in_a_second_frame_with_dwell(tmp_path: Path) -> None:
    """MSYS turned about x: its z is y of the first; FEDTO of CLSF is a height; the feed per turn is the cycle's."""
    text = (
        "TOOL PATH/A\nMSYS/0,0,0,1,0,0,0,1,0\nSPINDL/RPM,500,CLW\nRAPID\nGOTO/0,0,50\nEND-OF-PATH\n"
        "TOOL PATH/B\nMSYS/5,0,0,1,0,0,0,0,-1\nCYCLE/DRILL,DEEP,RAPTO,3,FEDTO,-7,STEP,6,DWELL,REV,4,IPR,.1\n"
        "GOTO/1,2,3,0,0,1\nCYCLE/OFF\nEND-OF-PATH\n"
    )
    path = read(tmp_path, text)
    expected = np.array([[0, 0, 50], [6, 6, -2], [6, 0, -2], [6, 6, -2], [6, 0.6, -2], [6, -4, -2], [6, 6, -2]])
    np.testing.assert_allclose(path.position, expected * 25.4e-3, rtol=0, atol=1e-14)
    np.testing.assert_allclose(path.axis, [[0, 0, 1]] + [[0, 1, 0]] * 6, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.feed[path.kind == CUT], 0.1 * 500 * 25.4e-3 / 60, rtol=1e-14)
    assert [(e.pose, e.word) for e in path.events if "DELAY" in e.word] == [(6, "DELAY/REV,4")]


def test_spindle_off_and_on(tmp_path: Path) -> None:
    head = "UNITS/MM\nSPINDL/RANGE,2,RPM,1000\nSPINDL/OFF\nFEDRAT/.2,MMPR\n"
    with pytest.raises(ReadError, match="no speed in RPM"):
        read(tmp_path, f"{head}GOTO/1,1,1\nFINI\n")
    path = read(tmp_path, f"{head}SPINDL/ON\nGOTO/1,1,1\nFINI\n")
    np.testing.assert_allclose(path.feed, [0.2 / 60], rtol=1e-14)


def test_second_csys(tmp_path: Path) -> None:
    """Under TRNTYP/WORLD coordinates stay; after the part is turned over the axis must be named."""
    turned = "CSYS/-1,0,0,0,0,1,0,0,0,0,-1,0"
    head = f"UNITS/MM\nTRNTYP/WORLD,0,0,0\nCSYS/1,0,0,-9,0,1,0,0,0,0,1,5\nGOTO/1,2,3\n{turned}\n"
    path = read(tmp_path, f"{head}GOTO/4,5,-6,0,0,-1\n{turned}\nGOTO/7,8,-9\nFINI\n")
    assert corners(path) == [[1, 2, 3], [4, 5, -6], [7, 8, -9]]
    np.testing.assert_array_equal(path.axis, [[0, 0, 1], [0, 0, -1], [0, 0, -1]])
    with pytest.raises(ReadError, match="no tool axis") as caught:
        read(tmp_path, f"{head}GOTO/4,5,-6\nFINI\n")
    assert caught.value.line == 6


def test_creo_dialect(tmp_path: Path) -> None:
    system = "$$-> CSYS / 1.0, 0.0, 0.0, 0.0, $\n      0.0, 1.0, 0.0, 0.0, $\n      0.0, 0.0, 1.0, 0.0\n"
    text = (
        f"$$*         Pro/CLfile  Version\n$$-> MFGNO / MFG0001\nPARTNO / MFG0001\nMACHIN / UNCX01, 1\nUNITS / MM\n"
        f"LOADTL / 4, OSETNO, 4\n$$-> CUTTER / 10.000000\n{system}SPINDL / RPM, 5000.000000,  CLW\nCUTCOM / LEFT\n"
        f"RAPID\nGOTO / 1.5, -2.0, 30.0\n{system}CYCLE / DRILL, DEPTH, 4.0, MMPM, 120.0, CLEAR, 2.0\n"
        "GOTO / 10.0, 20.0, 5.0\nCYCLE / OFF\nFINI\n"
    )
    path = read(tmp_path, text)
    assert corners(path) == [[1.5, -2, 30], [10, 20, 30], [10, 20, 7], [10, 20, 1], [10, 20, 7]]
    assert (path.tool == 4).all() and path.line.tolist() == [14, 19, 19, 19, 19]
    np.testing.assert_allclose(path.feed[path.kind == CUT] * 6e4, [120])


def test_cutcom_is_kept_and_changes_no_pose(tmp_path: Path) -> None:
    text = "UNITS/MM\nCUTTER/8,0\nGOTO/1,2,3\nCUTCOM/LEFT,XYPLAN,ADJUST,3\nGOTO/4,5,6\nCUTCOM/OFF\nGOTO/7,8,9\nFINI\n"
    path = read(tmp_path, text)
    assert corners(path) == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    words = [(e.pose, e.word) for e in path.events if "CUTCOM" in e.word]
    assert words == [(1, "CUTCOM/LEFT,XYPLAN,ADJUST,3"), (2, "CUTCOM/OFF")]


def test_every_word_is_on_one_list() -> None:
    assert not EVENTS & PASSED and not (EVENTS | PASSED) & set(REFUSED_WORDS)
    assert all(word == word.upper() and why for word, why in REFUSED_WORDS.items())


@pytest.mark.parametrize("word", sorted(EVENTS | PASSED))
def test_words_that_change_nothing(tmp_path: Path, word: str) -> None:
    path = read(tmp_path, f"UNITS/MM\nGOTO/1,2,3\n{word}/SOME,1\nGOTO/4,5,6\nFINI\n")
    assert corners(path) == [[1, 2, 3], [4, 5, 6]]
    assert [e.word for e in path.events] == ([f"{word}/SOME,1"] if word in EVENTS else [])


@pytest.mark.parametrize("word", sorted(REFUSED_WORDS))
def test_words_that_are_refused_with_a_reason(tmp_path: Path, word: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"UNITS/MM\nGOTO/1,2,3\n{word}/1\nGOTO/4,5,6\nFINI\n")
    assert caught.value.line == 3 and REFUSED_WORDS[word] in str(caught.value)
