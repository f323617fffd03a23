"""Clamps along a path against an independent loop that applies them row after row, number by number."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stiffness.effects.memory import Clamp
from stiffness.memory import clamp_scan
from stiffness.memory.clamp_scan import scan
from stiffness.memory.clamps_in_c import clamps_in_c

Floats = npt.NDArray[np.float64]


def row_loop(clamp: Clamp, starts: Floats) -> Floats:
    """(S, rows, n) of plain numbers: state' = min(max(state + shift, low), high)."""
    rows = len(clamp.shift)
    shift, low, high = (a.reshape(rows, -1).tolist() for a in (clamp.shift, clamp.low, clamp.high))
    out = np.empty((len(starts), rows, starts.shape[1]))
    for s, start in enumerate(starts.tolist()):
        for j, state in enumerate(start):
            for k in range(rows):
                state = min(max(state + shift[k][j], low[k][j]), high[k][j])
                out[s, k, j] = state
    return out


def random_clamp(rows: int, n: int, seed: int, tight: float = 1.0) -> Clamp:
    """Shifts of many sizes; intervals that move about, and close to a point now and then."""
    rng = np.random.default_rng(seed)
    shift = rng.normal(size=(rows, n)) * rng.choice([0.0, 1e-6, 1e-3, 0.3, 5.0], (rows, n))
    middle = 0.2 * rng.normal(size=(rows, n))
    half = tight * rng.choice([0.0, 0.1, 1.0, 3.0], (rows, n), p=[0.02, 0.18, 0.4, 0.4])
    return Clamp(shift, middle - half, middle + half)


def starts_of(n: int, seed: int, count: int = 3) -> Floats:
    return np.random.default_rng([seed, 1]).uniform(-3, 3, (count, n))


LENGTHS = [1, 2, clamp_scan._SHORT, clamp_scan._SHORT + 1, 100, 1000, 5000]


@pytest.mark.parametrize("n", [1, 6, 40])
@pytest.mark.parametrize("rows", LENGTHS)
def test_random_clamps(rows: int, n: int) -> None:
    clamp, starts = random_clamp(rows, n, 100 * n + rows), starts_of(n, rows)
    np.testing.assert_allclose(scan(clamp, starts), row_loop(clamp, starts), rtol=0, atol=1e-12)


@pytest.mark.parametrize("rows", [clamp_scan._PIECE - 1, clamp_scan._PIECE, clamp_scan._PIECE + 1, 40_000])
def test_paths_of_several_pieces(rows: int) -> None:
    clamp, starts = random_clamp(rows, 2, rows, tight=30.0), starts_of(2, rows)
    np.testing.assert_allclose(scan(clamp, starts), row_loop(clamp, starts), rtol=0, atol=1e-9)


def test_many_numbers_side_by_side() -> None:
    """So many columns that the rows are walked one by one: the very bits of the loop."""
    n = clamp_scan._WIDTH // 4
    clamp, starts = random_clamp(60, n, 5), starts_of(n, 5)
    np.testing.assert_array_equal(scan(clamp, starts), row_loop(clamp, starts))


def test_the_shape_of_a_row_does_not_matter() -> None:
    flat, starts = random_clamp(300, 6, 6), starts_of(6, 6)
    shaped = Clamp(*(a.reshape(300, 2, 3) for a in (flat.shift, flat.low, flat.high)))
    np.testing.assert_array_equal(scan(shaped, starts), scan(flat, starts))


@pytest.mark.parametrize("rows", [40, 3000])
def test_bounds_that_are_never_reached(rows: int) -> None:
    """Infinite bounds: the state is the sum of the shifts."""
    shift = np.random.default_rng(7).normal(size=(rows, 3))
    far = np.full((rows, 3), np.inf)
    starts = starts_of(3, 7)
    expected = starts[:, None] + np.cumsum(shift, axis=0)
    np.testing.assert_allclose(scan(Clamp(shift, -far, far), starts), expected, atol=1e-9)


@pytest.mark.parametrize("rows", [40, 3000])
@pytest.mark.parametrize("size", [np.inf, 1e300, 1e100])
def test_shifts_beyond_every_bound(rows: int, size: float) -> None:
    """A shift that no interval can follow lands on a bound, whatever its size."""
    rng = np.random.default_rng(8)
    shift = rng.choice([-size, size, 0.0, 0.1], (rows, 4))
    clamp, starts = Clamp(shift, np.full((rows, 4), -1.0), np.full((rows, 4), 2.0)), starts_of(4, 8)
    got = scan(clamp, starts)
    np.testing.assert_allclose(got, row_loop(clamp, starts), rtol=0, atol=1e-12)
    assert np.all((got >= -1.0) & (got <= 2.0))


@pytest.mark.parametrize("rows", [40, 3000])
def test_an_interval_of_one_point_joins_all_states(rows: int) -> None:
    clamp, starts = random_clamp(rows, 3, 9), starts_of(3, 9)
    at = rows // 2
    clamp.low[at] = clamp.high[at] = 0.25
    got = scan(clamp, starts)
    np.testing.assert_array_equal(got[:, at], 0.25)
    np.testing.assert_array_equal(got[0, at:], got[2, at:])
    np.testing.assert_allclose(got, row_loop(clamp, starts), rtol=0, atol=1e-12)


def test_states_that_have_met_go_on_as_one() -> None:
    """Equal starts over several pieces are walked once; all of them get the result."""
    rows = clamp_scan._PIECE + 500
    clamp = random_clamp(rows, 2, 10)
    starts = np.tile(starts_of(2, 10, 1), (3, 1))
    got = scan(clamp, starts)
    np.testing.assert_array_equal(got[0], got[1])
    np.testing.assert_array_equal(got[0], got[2])
    np.testing.assert_allclose(got, row_loop(clamp, starts), rtol=0, atol=1e-12)


def test_a_path_in_parts_is_the_path_in_one() -> None:
    clamp, starts = random_clamp(2000, 6, 11), starts_of(6, 11)
    first, second = (
        Clamp(*(a[some] for a in (clamp.shift, clamp.low, clamp.high))) for some in (slice(700), slice(700, None))
    )
    head = scan(first, starts)
    parts = np.concatenate([head, scan(second, head[:, -1])], axis=1)
    np.testing.assert_allclose(parts, scan(clamp, starts), rtol=0, atol=1e-12)


def test_the_arguments_are_left_alone() -> None:
    clamp, starts = random_clamp(500, 3, 12), starts_of(3, 12)
    before = [a.copy() for a in (clamp.shift, clamp.low, clamp.high, starts)]
    scan(clamp, starts)
    for a, b in zip((clamp.shift, clamp.low, clamp.high, starts), before, strict=True):
        np.testing.assert_array_equal(a, b)


NUMBER = st.one_of(st.floats(-2, 2), st.sampled_from([0.0, -0.0, 1.0, -1.0, 5e-324, 1e-300]))


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_whatever_numbers(data: st.DataObject) -> None:
    rows, n = data.draw(st.sampled_from([1, 3, 49, 70, 130])), data.draw(st.integers(1, 3))
    shift, a, b = (data.draw(arrays(np.float64, (rows, n), elements=NUMBER)) for _ in range(3))
    clamp = Clamp(shift, np.minimum(a, b), np.maximum(a, b))
    starts = data.draw(arrays(np.float64, (2, n), elements=NUMBER))
    np.testing.assert_allclose(scan(clamp, starts), row_loop(clamp, starts), rtol=0, atol=1e-13)


@pytest.mark.skipif(not clamps_in_c(), reason="no C compiler")
@pytest.mark.parametrize("n", [1, 6, 12])
@pytest.mark.parametrize("rows", [clamp_scan._SHORT + 1, 511, 5000, clamp_scan._PIECE + 77])
def test_in_c_the_numbers_are_the_same(monkeypatch: pytest.MonkeyPatch, rows: int, n: int) -> None:
    clamp, starts = random_clamp(rows, n, 7 * n + rows), starts_of(n, rows)
    monkeypatch.setattr(clamp_scan, "_DONE", clamp_scan._Work())
    in_numpy = scan(clamp, starts)
    assert 0 < clamp_scan._DONE.numbers < clamp_scan._MUCH
    monkeypatch.setattr(clamp_scan, "_MUCH", 0)
    monkeypatch.setattr(clamp_scan, "_folded", None)  # not needed any more
    np.testing.assert_array_equal(scan(clamp, starts), in_numpy)
    assert np.ptp(in_numpy) > 1.0


def test_without_a_compiler_the_numbers_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    clamp, starts = random_clamp(5000, 6, 3), starts_of(6, 4)
    monkeypatch.setattr(clamp_scan, "_MUCH", 0)
    with_it = scan(clamp, starts)
    monkeypatch.setattr(clamp_scan, "clamps_in_c", lambda: None)
    np.testing.assert_array_equal(scan(clamp, starts), with_it)
