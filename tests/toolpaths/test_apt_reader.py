"""APT/CL and NX CLSF: hand-computed values; what is refused names line and word."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.readers import read_toolpath
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
    "CYCLE/DRILL,MMPM,250": (3, "CYCLE/DRILL,MMPM,250: a canned cycle"),
    "CUTCOM/LEFT,XYPLAN": (3, "cutter compensation"),
    "GODLTA/1,2,3": (3, "GODLTA"),
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
    "CIRCLE/0,0,0,0,0,1": (3, "6 values"),
    "CIRCLE/0,0,0,0,0,1,1,.1,.1,1,1,TIMES,2": (3, "helices"),
    "CIRCLE/0,2,3,0,0,1,5,.1,.1,1,1\nGOTO/-1,2,3": (3, "radius 5"),
    "CIRCLE/0,2,3,0,0,2,1,.1,.1,1,1\nGOTO/-1,2,3": (3, "length 2"),
    "CIRCLE/0,2,3,0,0,1,1,.1,.1,1,1\nRAPID\nGOTO/-1,2,3": (3, "RAPID between"),
    "CIRCLE/0,2,3,0,0,1,1,.1,.1,1,1\nGOTO/-1,2,3,0,1,0": (3, "turns along a circle"),
    "CIRCLE/0,2,3,0,0,1,1,.1,.1,1,1": (3, "no GOTO follows"),
    "GOTO/1,2,3,1,0,0\nMULTAX/OFF\nGOTO/1,2,3": (5, "no tool axis"),
    "GOTO/1,2,3,1,0,0\nTOOL PATH/B\nGOTO/1,2,3": (5, "no tool axis"),
    "TOOL PATH/B\nTOOL PATH/C": (4, "before END-OF-PATH"),
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
        ("UNITS/MM\nGOTO/1,2,$\n", 2, "continued"),
        ("UNITS/MM\nFINI\n", None, "no move"),
        ("MSYS/0,0,0,1,0,0,1,0,0\n", 1, "right angles"),
    ],
)
def test_head_and_end(tmp_path: Path, text: str, line: int | None, word: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, text)
    assert caught.value.line == line and word in str(caught.value)


def test_real_files(shared: Path) -> None:
    folder = shared / "data/cam"
    path = read_toolpath(folder / "clsf_nx/ust_a.cls")
    assert len(path) == 546 and path.kind.sum() == 508 and (path.tool == 2).all()
    np.testing.assert_allclose(path.position[0] * 1e3, [0, 222.6719, -177.5], atol=1e-12)
    np.testing.assert_allclose(path.axis[:2], [[0, 0, -1]] * 2, atol=0)
    assert len(np.unique(path.axis.round(7), axis=0)) == 63  # as data/INDEX.md says
    np.testing.assert_allclose(path.feed[path.kind == CUT], 0.25 / 60, rtol=1e-14)
    lines = {"clsf_nx/cutcom.clsf": 17, "clsf_nx/deep_drill.clsf": 7, "apt_solidworkscam/RotateThin.apt": 20}
    for name, line in lines.items():
        with pytest.raises(ReadError) as caught:
            read_toolpath(folder / name)
        assert caught.value.line == line
