"""Drilling cycles of APT/CL and NX CLSF: hand-computed heights."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.toolpath import CUT, RAPID

read = partial(read_text, "part.cls")

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
    assert ends(read(tmp_path, text)).round(9).tolist() == [*expected, [20, 0, 2], [20, 0, -5], [20, 0, 2]]


def test_auto_retract_is_the_height_before_the_cycle(tmp_path: Path) -> None:
    """Or, over a hole that is higher, RAPTO of that hole."""
    cycle = "CYCLE/DRILL,FEDTO,5,RAPTO,2,RTRCTO,AUTO,MMPM,60"
    text = f"UNITS/MM\nRAPID\nGOTO/0,0,20\n{cycle}\nGOTO/0,0,0\nGOTO/10,0,30\nGOTO/20,0,0\nCYCLE/OFF\nFINI\n"
    expected = [[0, 0, 20], [0, 0, 2], [0, 0, -5], [0, 0, 20], [0, 0, 32], [10, 0, 32], [10, 0, 25], [10, 0, 32]]
    expected += [[20, 0, 32], [20, 0, 2], [20, 0, -5], [20, 0, 20]]
    assert ends(read(tmp_path, text)).round(9).tolist() == expected


def test_auto_retract_with_another_axis_is_rapto(tmp_path: Path) -> None:
    """The height before the cycle was along another axis: nothing that the tool could go back to."""
    cycle = "CYCLE/DRILL,FEDTO,5,RAPTO,2,RTRCTO,AUTO,MMPM,60"
    path = read(tmp_path, f"UNITS/MM\nRAPID\nGOTO/0,0,50\n{cycle}\nGOTO/-90,1,2,1,0,0\nCYCLE/OFF\nFINI\n")
    assert ends(path).round(9).tolist() == [[0, 0, 50], [-88, 1, 2], [-95, 1, 2], [-88, 1, 2]]
    np.testing.assert_array_equal(path.axis[1:], [[1, 0, 0]] * 3)


def test_end_of_path_ends_cycle_and_rapid(tmp_path: Path) -> None:
    text = (
        "UNITS/MM\nTOOL PATH/A\nCYCLE/DRILL,FEDTO,-5,RAPTO,2,MMPM,60\nGOTO/0,0,0\nEND-OF-PATH\n"
        "TOOL PATH/B\nGOTO/7,8,9\nRAPID\nEND-OF-PATH\nTOOL PATH/C\nGOTO/1,2,3\nEND-OF-PATH\n"
    )
    path = read(tmp_path, text)
    assert ends(path).round(9).tolist() == [[0, 0, 2], [0, 0, -5], [0, 0, 2], [7, 8, 9], [1, 2, 3]]
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
