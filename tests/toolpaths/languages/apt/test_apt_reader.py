"""APT/CL and NX CLSF: hand-computed values; what is refused names line and word."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.apt.words import EVENTS, PASSED
from toolpaths.languages.apt.words import REFUSED as REFUSED_WORDS
from toolpaths.toolpath import CUT, RAPID

read = partial(read_text, "part.cls")


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


def test_relative_moves(tmp_path: Path) -> None:
    text = (
        "UNITS/MM\nFROM/1,2,30,0.6,0,0.8\nGODLTA/1,-2,3\nGODLTA/-10\nRAPID\nGODLTA/0,0,20,0,0,1\nGODLTA/2.5\n"
        "GOHOME/1,2,80\nFINI\n"
    )
    path = read(tmp_path, text)
    assert ends(path).round(9).tolist() == [[1, 2, 30], [2, 0, 33], [-4, 0, 25], [-4, 0, 45], [-4, 0, 47.5], [1, 2, 80]]
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
    assert ends(path).round(9).tolist() == [[1, 2, 3], [4, 5, -6], [7, 8, -9]]
    np.testing.assert_array_equal(path.axis, [[0, 0, 1], [0, 0, -1], [0, 0, -1]])
    with pytest.raises(ReadError, match="no tool axis") as caught:
        read(tmp_path, f"{head}GOTO/4,5,-6\nFINI\n")
    assert caught.value.line == 6


def test_a_three_axis_operation_after_a_tilted_one(tmp_path: Path) -> None:
    """SolidWorks CAM leaves i, j, k out where the tool is upright; each operation begins with TRNTYP and CSYS."""
    begin = "TRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\n"
    text = (
        f"PARTNO/1\nUNIT/MM\nSETUP/START\n{begin}RAPID/\nGOTO/1,2,30,.6,0,.8\nGOTO/1,2,20\n"
        f"SETUP/END\nSETUP/START\n{begin}RAPID/\nGOTO/4,5,60\nFINI\n"
    )
    path = read(tmp_path, text)
    np.testing.assert_allclose(path.axis, [[0.6, 0, 0.8], [0.6, 0, 0.8], [0, 0, 1]], atol=1e-15)
    assert [e.word for e in path.events if "SETUP" in e.word] == ["SETUP/START", "SETUP/END", "SETUP/START"]


def test_hypermill_head(tmp_path: Path) -> None:
    """As a file in a public repository begins; CALSUB calls lines that the post processor keeps."""
    system = "$$-> CSYS / 1.0, 0.0, 0.0, 0.0,  $\n  0.0, 1.0, 0.0, 0.0,  $\n  0.0, 0.0, 1.0, 0.0\n"
    text = (
        "PPRINT/ --- files_x\\StartEnd\\header.txt ---\n$$ HYPERMILL\n$$*\n$$ -> MFGNO\nPARTNO / Mold 1 1\n"
        f"MACHIN / MILL, 01\n$$ -> CUTCOM_GEOMETRY_TYPE / \nUNITS / MM\nCALSUB/START_PROG\nPARTNO/1 1 Main\n{system}"
        "MULTAX/ ON\nMODE / MILL\nSPINDL / MAIN\nLOADTL/1\nCALSUB/START_JOB\nSEQUENCE/ BEGIN,toolpath\nRAPID\n"
        "GOTO / 1.5, 2.0, 30.0, 0.0, 0.0, 1.0\nFEDRAT/ MMPM, 900.0\nGOTO / 1.5, 2.0, 3.0, 0.0, 0.0, 1.0\n"
        "CALSUB/END_PROG\nFINI\n"
    )
    path = read(tmp_path, text)
    np.testing.assert_allclose(path.position * 1e3, [[1.5, 2, 30], [1.5, 2, 3]])
    called = [e.word.split("/")[1] for e in path.events if "CALSUB" in e.word]
    assert called == ["START_PROG", "START_JOB", "END_PROG"]
    with pytest.raises(ReadError, match="CALSUB/POCKET_3: a subprogram that is not in the file"):
        read(tmp_path, text.replace("START_JOB", "POCKET_3"))


def test_creo_dialect(tmp_path: Path) -> None:
    system = "$$-> CSYS / 1.0, 0.0, 0.0, 0.0, $\n      0.0, 1.0, 0.0, 0.0, $\n      0.0, 0.0, 1.0, 0.0\n"
    text = (
        f"$$*         Pro/CLfile  Version\n$$-> MFGNO / MFG0001\nPARTNO / MFG0001\nMACHIN / UNCX01, 1\nUNITS / MM\n"
        f"LOADTL / 4, OSETNO, 4\n$$-> CUTTER / 10.000000\n{system}SPINDL / RPM, 5000.000000,  CLW\nCUTCOM / LEFT\n"
        f"RAPID\nGOTO / 1.5, -2.0, 30.0\n{system}CYCLE / DRILL, DEPTH, 4.0, MMPM, 120.0, CLEAR, 2.0\n"
        "GOTO / 10.0, 20.0, 5.0\nCYCLE / OFF\nFINI\n"
    )
    path = read(tmp_path, text)
    assert ends(path).round(9).tolist() == [[1.5, -2, 30], [10, 20, 30], [10, 20, 7], [10, 20, 1], [10, 20, 7]]
    assert (path.tool == 4).all() and path.line.tolist() == [14, 19, 19, 19, 19]
    np.testing.assert_allclose(path.feed[path.kind == CUT] * 6e4, [120])


def test_cutcom_is_kept_and_changes_no_pose(tmp_path: Path) -> None:
    text = "UNITS/MM\nCUTTER/8,0\nGOTO/1,2,3\nCUTCOM/LEFT,XYPLAN,ADJUST,3\nGOTO/4,5,6\nCUTCOM/OFF\nGOTO/7,8,9\nFINI\n"
    path = read(tmp_path, text)
    assert ends(path).round(9).tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    words = [(e.pose, e.word) for e in path.events if "CUTCOM" in e.word]
    assert words == [(1, "CUTCOM/LEFT,XYPLAN,ADJUST,3"), (2, "CUTCOM/OFF")]


def test_every_word_is_on_one_list() -> None:
    assert not EVENTS & PASSED and not (EVENTS | PASSED) & set(REFUSED_WORDS)
    assert all(word == word.upper() and why for word, why in REFUSED_WORDS.items())


@pytest.mark.parametrize("word", sorted(EVENTS | PASSED))
def test_words_that_change_nothing(tmp_path: Path, word: str) -> None:
    path = read(tmp_path, f"UNITS/MM\nGOTO/1,2,3\n{word}/SOME,1\nGOTO/4,5,6\nFINI\n")
    assert ends(path).round(9).tolist() == [[1, 2, 3], [4, 5, 6]]
    assert [e.word for e in path.events] == ([f"{word}/SOME,1"] if word in EVENTS else [])


@pytest.mark.parametrize("word", sorted(REFUSED_WORDS))
def test_words_that_are_refused_with_a_reason(tmp_path: Path, word: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"UNITS/MM\nGOTO/1,2,3\n{word}/1\nGOTO/4,5,6\nFINI\n")
    assert caught.value.line == 3 and REFUSED_WORDS[word] in str(caught.value)
