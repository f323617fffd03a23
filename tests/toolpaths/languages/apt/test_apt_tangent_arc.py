"""INDIRV with TLON,GOFWD, the arcs of CATIA V5: values computed by hand, refusals by line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.toolpath import CUT, Toolpath

HEAD = "UNITS/MM\nFEDRAT/600,MMPM\n"
CIRCLE = "TLON,GOFWD/ (CIRCLE/     1.00000,     2.00000,     3.00000,$\n    10.00000),"
LINE = "(LINE/     1.00000,     2.00000,     3.00000,$\n   "


def read(tmp_path: Path, text: str) -> Toolpath:
    file = tmp_path / "part.apt"
    file.write_text(text)
    return read_toolpath(file, chord=1e-6)


def check(path: Toolpath, center: list[float], middle: list[float], end: list[float], sweep: float) -> None:
    """The arc is the whole path, of radius 10 mm; places in mm, sweep in turns."""
    mm = path.position * 1e3
    np.testing.assert_allclose(mm[-1], end, rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(mm - center, axis=1), 10, rtol=1e-9)
    np.testing.assert_allclose(mm[np.argmin(np.abs(path.row - 0.5))], middle, rtol=0, atol=0.5)
    length = np.linalg.norm(np.diff(mm, axis=0), axis=1).sum()
    assert length == pytest.approx(sweep * math.tau * 10, rel=1e-4)
    np.testing.assert_allclose(path.feed[1:], 0.01, rtol=1e-14)
    np.testing.assert_array_equal(path.kind[1:], CUT)


H = 10 * math.sqrt(0.5)
ARCS = [  # centre 1, 2, 3, start at 11, 2, 3
    ("0,1,0", "ON", (0, 10), (H, H), 0.25),  # counterclockwise
    ("0,-1,0", "ON", (0, -10), (H, -H), 0.25),  # clockwise
    ("0,2,0", "ON", (-10, 0), (0, 10), 0.5),
    ("0,-1,0", "ON,2,INTOF", (-10, 0), (0, -10), 0.5),
    ("0,1,0", "ON,2,INTOF", (0, -10), (-H, H), 0.75),
    ("0,-1,0", "ON,2,INTOF", (0, 10), (-H, -H), 0.75),
    ("0,1,0", "ON,2,INTOF", (10, 0), (-10, 0), 1.0),
    ("0,1,0", "ON,2,INTOF", (10, 0.0002), (-10, 0), 1.0),  # rounded: an end just behind the start
    ("0.02,1,0", "ON", (-6, 8), (10 / math.sqrt(5), 20 / math.sqrt(5)), math.acos(-0.6) / math.tau),
]


@pytest.mark.parametrize(("way", "on", "end", "middle", "sweep"), ARCS)
def test_arcs_upright(
    tmp_path: Path, way: str, on: str, end: tuple[float, float], middle: tuple[float, float], sweep: float
) -> None:
    text = f"GOTO/11,2,3\nAUTOPS\nINDIRV/ {way}\n{CIRCLE}{on},$\n{LINE}{1 + end[0]}, {2 + end[1]}, 3.00000)\nFINI\n"
    path = read(tmp_path, HEAD + text)
    check(path, [1, 2, 3], [1 + middle[0], 2 + middle[1], 3], [1 + end[0], 2 + end[1], 3], sweep)
    np.testing.assert_array_equal(path.axis, [[0, 0, 1]] * len(path))
    assert path.line[0] == 3 and (path.line[1:] == 6).all()


@pytest.mark.parametrize(("way", "on", "sign", "sweep"), [(1, "ON", 1, 0.25), (-1, "ON,2,INTOF", -1, 0.75)])
def test_inclined_tool(tmp_path: Path, way: float, on: str, sign: float, sweep: float) -> None:
    """Axis 0.6, 0, 0.8: from 8, 0, -6 about 0 to 0, 10, 0; half way on either side of the x'-y' plane."""
    text = f"GOTO/8,0,-6,.6,0,.8\nINDIRV/0,{way},0\nTLON , GOFWD/(CIRCLE/0,0,0,10),{on},(LINE/0,0,0,0,10,0)\nFINI\n"
    path = read(tmp_path, HEAD + text)
    check(path, [0, 0, 0], [sign * 0.8 * H, sign * H, -sign * 0.6 * H], [0, 10, 0], sweep)
    np.testing.assert_allclose(path.position @ [0.6, 0, 0.8], 0, atol=1e-12)
    np.testing.assert_allclose(path.axis, [[0.6, 0, 0.8]] * len(path), atol=1e-15)


@pytest.mark.parametrize("seed", range(60))
def test_random_arcs(tmp_path: Path, seed: int) -> None:
    """Any place, axis, radius, side and sweep, written with 5 digits, against the circle itself."""
    rng = np.random.default_rng(seed)
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    center, radius, begin = rng.uniform(-500, 500, 3), 10 ** rng.uniform(0, 3), rng.uniform(-4, 4)
    sweep, sign = rng.uniform(0.3, math.tau - 0.01), rng.choice([-1, 1])

    def on(share: float) -> np.ndarray:
        angle = begin + sign * sweep * share
        return center + radius * frame @ [math.cos(angle), math.sin(angle), 0]

    def text(*values: np.ndarray) -> str:
        return ",".join(f"{v:.5f}" for v in np.concatenate(values))

    how = "ON,2,INTOF" if sweep > math.pi else "ON"
    way = frame @ [-sign * math.sin(begin), sign * math.cos(begin), 0]
    arc = f"TLON,GOFWD/(CIRCLE/{text(center, [radius])}),{how},(LINE/{text(center, on(1))})"
    path = read(tmp_path, f"{HEAD}GOTO/{text(on(0), frame[:, 2])}\nINDIRV/{text(way)}\n{arc}\nFINI\n")
    expected = np.array([on(row) for row in path.row])
    assert len(path) > 3
    np.testing.assert_allclose(path.position * 1e3, expected, rtol=0, atol=1e-4 + 2e-5 * radius)


def test_the_next_move_goes_on_from_the_end(tmp_path: Path) -> None:
    arc = "INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,10,0)\n"
    back = "INDIRV/-1,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,-10,0,0)\n"
    path = read(tmp_path, f"{HEAD}GOTO/10,0,0\n{arc}{back}GODLTA/0,-5,1\nFINI\n")
    ends = path.position[path.row % 1 == 0] * 1e3
    np.testing.assert_allclose(ends, [[10, 0, 0], [0, 10, 0], [-10, 0, 0], [-10, -5, 1]], atol=1e-9)


def test_in_a_second_frame(tmp_path: Path) -> None:
    """The second MSYS is turned by 90 degrees about z and lifted by 7: its x is the first one's y."""
    first, second = "MSYS/0,0,0,1,0,0,0,1,0", "MSYS/0,0,7,0,1,0,-1,0,0"
    arc = "INDIRV/0,-1,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,-10,0)"
    path = read(tmp_path, f"{HEAD}{first}\n{second}\nGOTO/10,0,0\n{arc}\nFINI\n")
    check(path, [0, 0, 7], [H, H, 7], [10, 0, 7], 0.25)


GOOD = "TLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,10,0)"
WAY = "INDIRV/0,1,0\n"
REFUSED = {
    GOOD: (4, "no INDIRV before it"),
    f"{WAY}{GOOD}\n{GOOD}": (6, "no INDIRV before it"),
    f"{WAY}GOTO/1,2,3\n{GOOD}": (4, "TLON,GOFWD does not follow"),
    f"{WAY}RAPID\n{GOOD}": (4, "TLON,GOFWD does not follow"),
    f"{WAY}{WAY}{GOOD}": (4, "TLON,GOFWD does not follow"),
    "INDIRV/0,1,0": (4, "TLON,GOFWD does not follow"),
    f"RAPID\n{WAY}{GOOD}": (5, "between RAPID"),
    f"CIRCLE/0,0,0,0,0,1\n{WAY}{GOOD}": (5, "between RAPID or CIRCLE"),
    f"CYCLE/DRILL,FEDTO,5,RAPTO,2\n{WAY}{GOOD}": (5, "a drilling cycle is in force"),
    f"{WAY}LOADTL/3\n{GOOD}": (4, "TLON,GOFWD does not follow"),
    f"{WAY}CIRCLE/0,0,0,0,0,1\n{GOOD}": (4, "TLON,GOFWD does not follow"),
    f"{WAY}CYCLE/DRILL,FEDTO,5,RAPTO,2": (4, "TLON,GOFWD does not follow"),
    f"{WAY}END": (4, "TLON,GOFWD does not follow"),
    f"TOOL PATH/A\n{WAY}END-OF-PATH": (5, "TLON,GOFWD does not follow"),
    f"TOOL PATH/A\nEND-OF-PATH\n{WAY}{GOOD}": (7, "a move outside a path"),
    "INDIRV/0,0,0": (4, "a direction without length"),
    "INDIRV/0,1": (4, "3 numbers"),
    f"INDIRV/1,1,0\n{GOOD}": (5, "45 degrees beside the tangent"),
    f"INDIRV/0,0,1\n{GOOD}": (5, "90 degrees beside the tangent"),
    f"GOTO/10.1,0,0\n{WAY}{GOOD}": (6, "radius 10, but the ends lie 10.1 and 10 from"),
    f"GOTO/0,0,0\n{WAY}{GOOD}": (6, "90 degrees beside"),
    f"GOTO/10,0,1\n{WAY}{GOOD}": (6, "an end lies 1 above its centre"),
    f"{WAY}{GOOD.replace('0,10,0)', '0,10,-2)')}": (5, "an end lies -2 above"),
    f"{WAY}{GOOD.replace('0,10,0)', '0,10,0.003)')}": (5, "an end lies 0.003 above"),
    f"{WAY}{GOOD.replace('0,10,0)', '0,9,0)')}": (5, "the ends lie 10 and 9 from"),
    f"{WAY}{GOOD.replace('0,10,0)', '0,-10,0)')}": (5, "270 degrees on, is not where the line is met the first"),
    f"{WAY}{GOOD.replace('0,10,0)', '10,0,0)')}": (5, "360 degrees on"),
    f"{WAY}{GOOD.replace('),ON,', '),ON,2,INTOF,')}": (5, "90 degrees on, is not where the line is met the second"),
    f"{WAY}{GOOD.replace('),ON,', '),ON,3,INTOF,')}": (5, "is expected"),
    f"{WAY}{GOOD.replace('),ON,', '),TO,')}": (5, "is expected"),
    f"{WAY}{GOOD.replace('CIRCLE', 'CYLNDR')}": (5, "is expected"),
    f"{WAY}{GOOD.replace('LINE/0', 'LINE/1')}": (5, "does not begin at the centre"),
    f"{WAY}{GOOD.replace(',10)', ')')}": (5, "4 numbers"),
    f"{WAY}{GOOD.replace(',10)', ',0)')}": (5, "radius 0"),
    f"{WAY}TLAXIS/0.6,0,0.8\n{GOOD}": (6, "the tool axis turns"),
    "TLON/1": (4, "arcs in this form"),
    "CLEARP/XYPLAN,5": (4, "does not know the word"),
}


@pytest.mark.parametrize(("text", "expected"), REFUSED.items(), ids=list(REFUSED))
def test_refused_by_line(tmp_path: Path, text: str, expected: tuple[int, str]) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"{HEAD}GOTO/10,0,0\n{text}\nFINI\n")
    assert caught.value.line == expected[0] and expected[1] in str(caught.value)


def test_no_start(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="says where it starts"):
        read(tmp_path, f"{HEAD}{WAY}{GOOD}\nFINI\n")
