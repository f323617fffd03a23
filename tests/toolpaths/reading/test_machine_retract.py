"""Where a retract to the machine would leave a straight way through the part, poses lead around it."""

from __future__ import annotations

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.reading.machine_retract import MachineRetract, around_the_cuts
from toolpaths.toolpath import CUT, RAPID, Toolpath

UP, SIDE = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
#: A slot cut from x 0 to 100 mm at z -20 mm, with its approach from z 5 mm.
SLOT = [(0, 0, 5, RAPID), (0, 0, -20, CUT), (100, 0, -20, CUT)]


def path_of(moves: list[tuple[float, float, float, int]], axes: list[tuple[float, float, float]]) -> Toolpath:
    n = len(moves)
    return Toolpath(
        source="part", language="siemens", position=np.array([m[:3] for m in moves]) * 1e-3, axis=np.array(axes),
        quaternion=None, feed=np.full(n, 0.01), kind=np.array([m[3] for m in moves], dtype=np.uint8),
        tool=np.zeros(n, dtype=np.int32), spindle=np.full(n, np.nan), sense=np.zeros(n, dtype=np.int8),
        line=np.arange(1, n + 1, dtype=np.int32), row=np.arange(n, dtype=np.float64),
    )  # fmt: skip


def led(to: tuple[float, float, float], axis: tuple[float, float, float] = UP, more: int = 0) -> Toolpath:
    """SLOT, a retract, and a rapid to a place."""
    end = [(*to, RAPID)] + [(*to, CUT)] * more
    return around_the_cuts(path_of([*SLOT, *end], [UP] * 3 + [axis] * len(end)), [MachineRetract(3, 4, "SUPA")])


def test_out_over_the_part_and_down_again() -> None:
    path = led((0, 50, -20))
    assert path.row.tolist() == pytest.approx([0, 1, 2, 2 + 1 / 3, 2 + 2 / 3, 3])
    np.testing.assert_allclose(path.position[3:5] * 1e3, [[100, 0, 15], [0, 50, 15]], rtol=0, atol=1e-9)
    assert path.kind.tolist() == [0, 1, 1, 0, 0, 0]


@pytest.mark.parametrize("place", [(0.0, 50.0, 90.0), (120.0, 0.0, -20.0), (100.0, 0.0, 30.0)])
def test_a_straight_way_that_is_clear_stays(place: tuple[float, float, float]) -> None:
    """Up along the tool's end of the box is not through it."""
    moves = [*SLOT, (100, 0, 5, RAPID), (*place, RAPID)]
    path = around_the_cuts(path_of(moves, [UP] * 5), [MachineRetract(4, 5, "SUPA")])
    assert len(path) == 5


def test_along_a_tilted_tool() -> None:
    path = led((-30, 0, -10), SIDE, more=1)
    put = path.take(np.flatnonzero(path.row % 1 != 0))
    np.testing.assert_allclose(put.axis, [UP, SIDE])
    assert put.position[0, 2] > 5e-3 and put.position[1, 0] > 0.1
    np.testing.assert_allclose(put.position[:, 1], 0, atol=1e-12)


def test_what_is_drawn_back_at_a_feed_is_no_cut() -> None:
    """Else the box would reach to wherever the tool was drawn back."""
    moves = [*SLOT, (100, 0, 500, CUT), (0, 50, 20, RAPID)]
    assert len(around_the_cuts(path_of(moves, [UP] * 5), [MachineRetract(4, 5, "SUPA")])) == 5


def test_no_way_is_refused_by_line() -> None:
    down = (0.0, 0.0, -1.0)
    with pytest.raises(ReadError, match="no way along the tool axes leads around what is cut") as caught:
        led((50, 0, -30), down)
    assert caught.value.line == 4


def test_without_cuts_or_before_the_first_move() -> None:
    moves = [(0, 0, 5, RAPID), (9, 0, 5, RAPID)]
    assert len(around_the_cuts(path_of(moves, [UP] * 2), [MachineRetract(1, 2, "SUPA")])) == 2
    path = path_of(SLOT, [UP] * 3)
    assert around_the_cuts(path, [MachineRetract(0, 1, "SUPA"), MachineRetract(3, 4, "SUPA")]) is path
