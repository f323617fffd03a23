"""Drilling cycles of SINUMERIK programs as moves, in numbers worked out from the manual."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, Toolpath

HEAD = "G710 G90 G17\nG0 X5 Y6 Z30\nF600\n"
read = partial(read_text, "part.mpf")
#: What is called, and the heights that follow: those of cuts with their feed in mm/min.
HOLES = {
    "CYCLE81(20,0,2,-15)": [2, (-15, 600), 20],
    "CYCLE81(20,0,2,,15)": [2, (-15, 600), 20],
    "CYCLE81(20,0,-2,-7,15,0,0,1,1)": [2, (-15, 600), 20],
    "CYCLE81(20,0,2,-15,7,0,0,1,2)": [2, (-15, 600), 20],
    "CYCLE82(20,10,2,-5,,0.5)": [12, (-5, 600), 20],
    "CYCLE85(20,0,2,-15,,0,300,900)": [2, (-15, 300), (2, 900), 20],
    "CYCLE89(20,0,2,-15,,1)": [2, (-15, 600), (2, 600), 20],
    # chip breaking: back by 1 mm, or by _VRT
    "CYCLE83(20,0,2,-15,,-5,,0,0,0,1,0)": [2, (-5, 600), (-4, 600), (-10, 600), (-9, 600), (-15, 600), 20],
    "CYCLE83(20,0,2,-15,,-5,,0,0,0,1,0,,,3)": [2, (-5, 600), (-2, 600), (-10, 600), (-7, 600), (-15, 600), 20],
    # swarf removal: 0.6 mm above the last depth up to 30 mm, from there on a fiftieth of it; or _DIS1
    "CYCLE83(20,0,2,-15,,,5,0,0,0,0.5,1)": [2, (-5, 300), 2, -4.4, (-10, 600), 2, -9.4, (-15, 600), 20],
    "CYCLE83(20,0,2,-60,,-30,,0,0,0,1,1)": [2, (-30, 600), 2, -28.8, (-60, 600), 20],
    "CYCLE83(20,0,2,-15,,,10,0,0,0,1,1,,,,,2)": [2, (-10, 600), 2, -8, (-15, 600), 20],
    # degression by 8 mm to no less than 8 mm; the last two strokes share what is left
    "CYCLE83(20,0,2,-51,,-20,,8,0,0,1,0)": [
        2, (-20, 600), (-19, 600), (-32, 600), (-31, 600), (-40, 600), (-39, 600), (-45.5, 600), (-44.5, 600),
        (-51, 600), 20,
    ],
    # by the factor 0.5, at least 4 mm
    "CYCLE83(20,0,2,-36,,-16,,-0.5,0,0,1,0,,4)": [
        2, (-16, 600), (-15, 600), (-24, 600), (-23, 600), (-28, 600), (-27, 600), (-32, 600), (-31, 600), (-36, 600),
        20,
    ],
}  # fmt: skip


def heights(path: Toolpath) -> list[object]:
    """Of the moves behind the approach."""
    np.testing.assert_allclose(path.position[:, :2] * 1e3, np.tile([5, 6], (len(path), 1)))
    z, feed = np.round(path.position[1:, 2] * 1e3, 9), np.round(path.feed[1:] * 6e4, 6)
    return [(h, f) if k == CUT else h for h, f, k in zip(z.tolist(), feed.tolist(), path.kind[1:], strict=True)]


@pytest.mark.parametrize("call", HOLES)
def test_holes(tmp_path: Path, call: str) -> None:
    assert heights(read(tmp_path, f"{HEAD}{call}\nM30\n")) == HOLES[call]


def test_dwells_are_listed(tmp_path: Path) -> None:
    path = read(tmp_path, HEAD + "CYCLE83(20,0,2,-15,,-10,,0,0.5,2,1,1)\nCYCLE82(20,0,2,-5,,-3)\nM30\n")
    said = [e.word for e in path.events if e.word.startswith("dwell")]
    assert said == ["dwell 0.5 s", "dwell 2 s", "dwell 0.5 s", "dwell 3 turns"]


def test_mcall_drills_at_every_place(tmp_path: Path) -> None:
    text = "MCALL CYCLE81(20,0,2,-9)\nG0 X10 Y10\nX20\nG0 Z25\nM8\nMCALL\nX30\nM30\n"
    path = read(tmp_path, HEAD + text)
    cuts = path.position[path.kind == CUT] * 1e3
    np.testing.assert_allclose(cuts, [[10, 10, -9], [20, 10, -9], [20, 10, -9]], rtol=0, atol=1e-12)
    assert path.position[-1] * 1e3 == pytest.approx([30, 10, 20])


def test_a_cycle_in_other_planes(tmp_path: Path) -> None:
    for plane, k in ((18, 1), (19, 0)):
        path = read(tmp_path, f"G710 G90 G{plane}\nG0 X30 Y30 Z30\nF600\nCYCLE81(20,0,2,-9)\nM30\n")
        np.testing.assert_allclose(path.position[1:, k] * 1e3, [2, -9, 20], rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.delete(path.position, k, axis=1) * 1e3, 30, rtol=0, atol=1e-12)


def test_a_cycle_in_inch(tmp_path: Path) -> None:
    path = read(tmp_path, "G700 G90\nG0 X0 Y0 Z2\nF10\nCYCLE83(1,0,0.1,-1,,-0.5,,0,0,0,1,0)\nM30\n")
    np.testing.assert_allclose(path.position[1:, 2] / 25.4e-3, [0.1, -0.5, -0.5 + 1 / 25.4, -1, 1], rtol=0, atol=1e-12)


def test_patterns(tmp_path: Path) -> None:
    row = read(tmp_path, HEAD + "MCALL CYCLE81(20,0,2,-9)\nHOLES1(10,20,90,5,10,3)\nMCALL\nM30\n")
    np.testing.assert_allclose(row.position[row.kind == CUT, :2] * 1e3, [[10, 25], [10, 35], [10, 45]], atol=1e-12)
    circle = read(tmp_path, HEAD + "MCALL CYCLE81(20,0,2,-9)\nHOLES2(10,20,5,90,0,4)\nMCALL\nM30\n")
    places = circle.position[circle.kind == CUT, :2] * 1e3
    np.testing.assert_allclose(places, [[10, 25], [5, 20], [10, 15], [15, 20]], rtol=0, atol=1e-12)
    arc = read(tmp_path, HEAD + "MCALL CYCLE81(20,0,2,-9)\nHOLES2(0,0,5,0,30,3)\nM30\n")
    angles = np.degrees(np.arctan2(*arc.position[arc.kind == CUT, 1::-1].T))
    np.testing.assert_allclose(angles, [0, 30, 60], rtol=0, atol=1e-9)


REFUSED = {
    "CYCLE81(20,0,2)": "without DP",
    "CYCLE81(20,0,2,15)": "in this order from above",
    "CYCLE81(20,0,2,-15,,0,1)": "_GMODE 1: the depth depends on the tool",
    "CYCLE81(20,0,2,-15,,0,0,2)": "another plane than the one in force",
    "CYCLE83(20,0,2,-15,,0,0)": "a first depth FDEP below RFP",
    "CYCLE83(20,0,2,-15,,-5,,0,0,0,1,2)": "VARI 0 or 1",
    "CYCLE83(20,0,2,-15,,-5,,0,0,0,1,0,1)": "another axis than that of the plane",
    "CYCLE83(20,0,2,-300,,-0.01,,0,0,0,1,0)": "more than 500 strokes",
    "CYCLE81(20,0,2,-15,,0,0,1,1,7)": "its 10. value 7 is not read",
    'CYCLE81(20,0,2,"A")': "a number is expected",
    "CYCLE85(20,0,2,-15)": "a feed FFR above 0",
    "CYCLE81(20,0,2,R7)": "R7, which has no value",
    "TRAORI\nCYCLE81(20,0,2,-15)": "under TRAORI",
    "SUPA G0 Z0\nCYCLE81(20,0,2,-15)": "where the tool is, is not known",
    "MCALL CYCLE81(20,0,2,-9)\nHOLES1(0,0,0,5,5,0)": "of 0 holes",
}


@pytest.mark.parametrize("call", REFUSED)
def test_refused(tmp_path: Path, call: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"{HEAD}{call}\nM30\n")
    assert REFUSED[call] in str(caught.value) and caught.value.line == 4 + call.count("\n")
