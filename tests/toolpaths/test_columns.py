"""Columns and frames of a long path: what is made where it is asked for is what is kept whole, whatever the block."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import toolpaths.columns as columns
from toolpaths.columns import MadeColumn, blocks, made_from, once, put_in
from toolpaths.frame import Frame
from toolpaths.made_frames import MadeFrames

LENGTHS = [1, 6, 7, 8, 50]  # about a block of 7


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "BLOCK", 7)


def frames(count: int) -> tuple[Frame, MadeFrames]:
    """The same, whole and made."""
    rng = np.random.default_rng(count)
    whole = Frame(Rotation.random(count, rng=rng).as_matrix(), rng.uniform(-1, 1, (count, 3)))
    return whole, MadeFrames(count, lambda rows: Frame(whole.rotation[rows], whole.origin[rows]))


def same(one: Frame, other: Frame) -> None:
    np.testing.assert_array_equal(one.rotation, other.rotation)
    np.testing.assert_array_equal(one.origin, other.origin)
    np.testing.assert_array_equal(one.z, other.z)


@pytest.mark.parametrize("count", LENGTHS)
def test_frames_that_are_made_are_those_that_are_kept(count: int) -> None:
    whole, made = frames(count)
    outer = Frame(Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix(), np.array([1.0, 2.0, 3.0]))
    turn = Rotation.from_rotvec(np.outer(np.arange(count), [0.0, 0.0, 0.1])).as_matrix()
    same(made, whole)
    assert made.count == whole.count == count
    same(made.mapped(lambda some, rows: outer.then(some)), outer.then(whole))
    same(made.turned(lambda rows: turn[rows]), Frame(whole.rotation @ turn, whole.origin))
    same(made.at_origins(whole.origin + 1.0), Frame(whole.rotation, whole.origin + 1.0))
    same(outer.then(made), outer.then(whole))
    for rows in (slice(None), slice(1, None, 2), np.arange(count)[::-1], np.arange(count) % 3 == 0, np.array([-1])):
        picked = np.arange(count)[rows]
        same(made.take(rows if not np.array_equal(rows, [-1]) else picked), whole.take(picked))
    same(made.take(count - 1), whole.take(count - 1))
    joined = MadeFrames.joined([made, whole])
    same(joined, Frame(np.tile(whole.rotation, (2, 1, 1)), np.tile(whole.origin, (2, 1))))
    same(joined.take(np.array([count, 0, 2 * count - 1])), whole.take(np.array([0, 0, count - 1])))


@pytest.mark.parametrize("count", [0, *LENGTHS])
def test_blocks_are_every_row_once(count: int) -> None:
    rows = [np.arange(count)[b] for b in blocks(count)]
    np.testing.assert_array_equal(np.concatenate([np.empty(0, dtype=int), *rows]), np.arange(count))
    assert all(len(r) <= 7 for r in rows) and sum(len(r) < 7 for r in rows) <= 1


@pytest.mark.parametrize("count", LENGTHS)
def test_a_column_that_is_made(count: int) -> None:
    values = np.random.default_rng(1).uniform(size=(count, 3))
    made = MadeColumn(count, lambda rows: values[rows])
    assert len(made) == count
    np.testing.assert_array_equal(np.asarray(made), values)
    np.testing.assert_array_equal(made[1:3], values[1:3])
    np.testing.assert_array_equal(made[np.array([0, count - 1])], values[[0, -1]])
    np.testing.assert_array_equal(made[[count - 1, 0]], values[[-1, 0]])
    np.testing.assert_array_equal(made[:, [2, 0]], values[:, [2, 0]])
    np.testing.assert_array_equal(made[count - 1], values[-1])
    assert made.shape == values.shape and made[0].shape == (3,)


@pytest.mark.parametrize("value", [3.5, np.nan, 0.0])
def test_what_is_the_same_in_all_rows_is_kept_once(value: float) -> None:
    column = np.full(20, value)
    kept = once(column)
    assert kept.strides == (0,)
    np.testing.assert_array_equal(kept, column)
    for k in (0, 9, 19):
        other = column.copy()
        other[k] = 1.0
        assert once(other) is other
    assert once(column[:6]).strides == (8,)  # a short one is left alone


@pytest.mark.parametrize("apart", [[], [0], [3, 19], list(range(11)), list(range(20))])
def test_a_column_beside_another_one_is_made_again(apart: list[int]) -> None:
    base = np.random.default_rng(2).uniform(1, 2, (20, 3))
    values = base.copy()
    values[apart, 1] = np.nan if apart == [0] else -1.0
    expected = values.copy()
    made = made_from(lambda: base, values)
    if len(apart) <= 10:  # only those rows are kept
        values[:] = 0.0
    np.testing.assert_array_equal(made(), expected)
    assert (made() is base) == (not apart) and np.all(base >= 1)


def test_others_are_put_into_rows_that_were_asked_for() -> None:
    values, others = np.arange(12.0).reshape(6, 2), np.array([[-1.0, -2.0], [-3.0, -4.0]])
    chosen, rows = np.array([9, 4, 0, 7, 4, 3]), np.array([4, 7])
    expected = values.copy()
    expected[[1, 4]], expected[3] = others[0], others[1]
    np.testing.assert_array_equal(put_in(values, chosen, rows, others), expected)
    assert put_in(values, chosen, np.array([5]), others[:1]) is values
    assert put_in(values, chosen, rows, None) is values
