"""Drilling cycles of Klartext as moves, in numbers worked out from the manual."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, Toolpath

read = partial(read_text, "part.h")
BASE = "Q200=2 Q201=-15 Q206=150 Q203=+0 Q204=20"
#: Cycle and parameters, and the heights that follow: those of cuts with their feed in mm/min.
HOLES = {
    "200 Q202=5 Q210=0 Q211=0": [2, (-5, 150), 2, -4.8, (-10, 150), 2, -9.8, (-15, 150), 20],
    "200 Q202=20": [2, (-15, 150), 20],
    "200 Q202=20 Q204=0": [2, (-15, 150), 2],
    "200 Q202=20 Q203=-10 Q201=-5": [-8, (-15, 150), 20 - 10],
    "201 Q208=900": [2, (-15, 150), (2, 900), 20],
    "201 Q208=0": [2, (-15, 150), (2, 150), 20],
    "201 Q208=MAX": [2, (-15, 150), 2, 20],
    # each stroke 2 mm less, to no less than 3 mm
    "203 Q202=6 Q212=2 Q205=3 Q213=0 Q208=900": [
        2, (-6, 150), (2, 900), -5.8, (-10, 150), (2, 900), -9.8, (-13, 150), (2, 900), -12.8, (-15, 150), (2, 900), 20,
    ],
    # breaks the chip twice before it comes out
    "203 Q202=4 Q213=2 Q256=0.5 Q208=FMAX": [
        2, (-4, 150), (-3.5, 150), (-8, 150), (-7.5, 150), (-12, 150), 2, -11.8, (-15, 150), 2, 20,
    ],
    # comes back to 0.5 mm above the first depth, 1 mm above the last
    "205 Q202=7.5 Q212=0 Q205=0 Q258=0.5 Q259=1 Q257=0 Q256=0.2": [2, (-7.5, 150), 2, -6.75, (-15, 150), 20],
    "205 Q202=15 Q257=6 Q256=0.2": [2, (-6, 150), (-5.8, 150), (-12, 150), (-11.8, 150), (-15, 150), 20],
    # begins in a hole of 5 mm
    "205 Q202=10 Q379=5 Q253=900": [2, (-3, 900), (-15, 150), 20],
    "240 Q343=0 Q344=0": [2, (-15, 150), 20],
}  # fmt: skip


def program(text: str) -> str:
    return f"BEGIN PGM A MM\nL X+5 Y+6 Z+30 R0 FMAX\n{text}\nEND PGM A MM\n"


def definition(cycle: str) -> str:
    """The cycle with BASE, what it gives itself instead."""
    number, _, own = cycle.partition(" ")
    named = {w.partition("=")[0] for w in own.split()}
    base = " ".join(w for w in BASE.split() if w.partition("=")[0] not in named)
    return f"CYCL DEF {number} DRILLING {base} {own}"


def heights(path: Toolpath) -> list[object]:
    """Of the moves behind the approach."""
    np.testing.assert_allclose(path.position[:, :2] * 1e3, np.tile([5, 6], (len(path), 1)))
    z, feed = np.round(path.position[1:, 2] * 1e3, 9), np.round(path.feed[1:] * 6e4, 6)
    return [(h, f) if k == CUT else h for h, f, k in zip(z.tolist(), feed.tolist(), path.kind[1:], strict=True)]


@pytest.mark.parametrize("cycle", HOLES)
def test_holes(tmp_path: Path, cycle: str) -> None:
    assert heights(read(tmp_path, program(f"{definition(cycle)}\nCYCL CALL"))) == HOLES[cycle]


def test_the_printed_form(tmp_path: Path) -> None:
    """As the control prints it: a parameter a line, continued by '~'."""
    lines = " ~\n".join(f"   {w} ;NAME OF IT" for w in [*BASE.split(), "Q202=+20"])
    path = read(tmp_path, program(f"4 CYCL DEF 200 DRILLING ~\n{lines}\n5 CYCL CALL M3"))
    assert heights(path) == [2, (-15, 150), 20] and set(path.line[1:]) == {10}


def places(path: Toolpath) -> list[list[float]]:
    return np.round(path.position[path.kind == CUT, :2] * 1e3, 9).tolist()  # type: ignore[no-any-return]


CALLS = {
    "L X+10 Y+10 R0 FMAX M99\nL X+20 R0 FMAX": [[10, 10]],
    "L X+10 Y+10 R0 FMAX\nCYCL CALL\nCYCL CALL": [[10, 10], [10, 10]],
    "L X+10 Y+10 FMAX M89\nL X+20 FMAX\nL IX+5 FMAX\nL M8\nL X+30 FMAX M99\nL X+40 FMAX": [
        [10, 10], [20, 10], [25, 10], [30, 10],
    ],
    "CYCL CALL POS X+10 Y+10 FMAX": [[10, 10]],
}  # fmt: skip


@pytest.mark.parametrize("text", CALLS)
def test_calls(tmp_path: Path, text: str) -> None:
    assert places(read(tmp_path, program(f"{definition('200 Q202=20')}\n{text}"))) == CALLS[text]


def test_a_place_with_its_surface(tmp_path: Path) -> None:
    """CYCL CALL POS: up first, over the place, then down; Z is the surface there."""
    path = read(tmp_path, program(f"{definition('200 Q202=20')}\nL Z+5 FMAX\nCYCL CALL POS X+10 Y+10 Z-3 FMAX"))
    expected = [[5, 6, 5], [5, 6, 17], [10, 10, 17], [10, 10, -1], [10, 10, -18], [10, 10, 17]]
    np.testing.assert_allclose(path.position[1:] * 1e3, expected, rtol=0, atol=1e-12)


def test_a_new_definition_ends_m89(tmp_path: Path) -> None:
    one, two = definition("200 Q202=20"), definition("200 Q202=20 Q201=-9")
    path = read(tmp_path, program(f"{one}\nL X+10 FMAX M89\n{two}\nL X+20 FMAX\nL X+30 FMAX M99"))
    assert places(path) == [[10, 6], [30, 6]]


def test_parameters_keep_what_the_cycle_gave_them(tmp_path: Path) -> None:
    path = read(tmp_path, program(f"{definition('200 Q202=20')}\nQ1 = Q203 + Q200\nL Z+Q1 FMAX\nL X+Q204 FMAX"))
    np.testing.assert_allclose(path.position[-1] * 1e3, [20, 6, 2])


def test_feeds_of_the_tool(tmp_path: Path) -> None:
    text = f"TOOL CALL 1 Z S900 F333\n{definition('200 Q202=20 Q206=AUTO')}\nCYCL CALL"
    assert heights(read(tmp_path, program(text))) == [2, (-15, 333), 20]


def test_dwells_are_listed(tmp_path: Path) -> None:
    path = read(tmp_path, program(f"{definition('200 Q202=8 Q210=0.5 Q211=1')}\nCYCL CALL"))
    assert [e.word for e in path.events if e.word.startswith("dwell")] == ["dwell 0.5 s", "dwell 1 s"]


def test_a_cycle_in_a_tilted_plane(tmp_path: Path) -> None:
    text = f"PLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX\n{definition('200 Q202=20')}\nL X+1 Y+2 Z+30 FMAX M99"
    path = read(tmp_path, program(text))
    np.testing.assert_allclose(path.position[-3:] * 1e3, [[2, 2, -1], [-15, 2, -1], [20, 2, -1]], rtol=0, atol=1e-12)


REFUSED = {
    "200": "without Q202",
    "200 Q202=0": "an infeed Q202 of 0",
    "200 Q202=5 Q201=5": "a depth Q201 of 5: below 0",
    "200 Q202=5 Q206=0": "feeds above 0",
    "200 Q202=5 Q206=MAX": "feeds above 0",
    "200 Q202=0.001": "more than 2000 strokes",
    "200 Q202=5 Q395=1": "depends on the point of the tool",
    "240 Q343=1": "depends on the point of the tool",
    "200 Q202=5 Q777=1": "Q777: this reader does not know what it means",
    "205 Q202=5 Q257=0.001": "breaks the chip more than 2000 times",
    "201 Q208=F100": "a value behind each '=' is expected",
    "200 Q202=": "a value behind each '=' is expected",
    "203 Q202=5 Q213=-1": "Q213=-1: 0 or more",
}


@pytest.mark.parametrize("cycle", REFUSED)
def test_refused(tmp_path: Path, cycle: str) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, program(f"{definition(cycle)}\nCYCL CALL"))
    assert REFUSED[cycle] in str(caught.value)
