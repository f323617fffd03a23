"""Clamps along a path: against a loop over the rows, number by number."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.effects.effect import Clamp
from stiffness.memory import clamp_scan
from stiffness.memory.clamp_scan import scan

Floats = npt.NDArray[np.float64]


def walked(clamp: Clamp, starts: Floats) -> Floats:
    """(S, rows, n), state' = min(max(state + shift, low), high), one number at a time."""
    rows, n = clamp.shift.shape
    out = np.empty((len(starts), rows, n))
    for s, start in enumerate(starts):
        for j in range(n):
            state = float(start[j])
            for k in range(rows):
                state = min(max(state + clamp.shift[k, j], clamp.low[k, j]), clamp.high[k, j])
                out[s, k, j] = state
    return out


def random_clamps(rows: int, n: int, seed: int, *, whole: bool = False) -> Clamp:
    """Windows that move, some of them a point, some without an end. ``whole``: numbers that add without rounding."""
    rng = np.random.default_rng(seed)
    shift = rng.integers(-8, 9, (rows, n)) / 8 if whole else rng.normal(size=(rows, n))
    middle = rng.integers(-16, 17, (rows, n)) / 8
    half = rng.integers(0, 17, (rows, n)) / 8
    low, high = middle - half, middle + half
    low[rng.random((rows, n)) < 0.2] = -np.inf
    high[rng.random((rows, n)) < 0.2] = np.inf
    return Clamp(shift, low, high)


# above and below every threshold: walked row by row, in runs, in runs of runs, in pieces
SIZES = [(1, 1), (48, 3), (49, 1), (50, 6), (500, 6), (4095, 1), (4097, 2), (20000, 6), (40000, 1), (3, 5000)]
SIZES += [(60, 2000)]


@pytest.mark.parametrize(("rows", "n"), SIZES)
@pytest.mark.parametrize("starts", [1, 3])
def test_a_scan_is_a_loop_over_the_rows(rows: int, n: int, starts: int) -> None:
    clamp = random_clamps(rows, n, rows + n, whole=True)
    begin = np.random.default_rng(1).integers(-24, 25, (starts, n)) / 8
    found, expected = scan(clamp, begin), walked(clamp, begin)
    assert found.shape == (starts, rows, n)
    assert np.array_equal(found, expected)
    assert np.any(expected != 0)


@pytest.mark.parametrize("rows", [49, 700, 20000])
def test_with_rounding_it_is_the_loop_to_rounding(rows: int) -> None:
    clamp = random_clamps(rows, 4, rows)
    begin = np.array([[-3.0, 0.1, 0.2, 5.0], [3.0, 0.1, 0.3, -5.0]])
    assert scan(clamp, begin) == pytest.approx(walked(clamp, begin), abs=1e-12)


@pytest.mark.parametrize("rows", [40, 3000, 30000])
def test_starts_that_have_met_stay_together(rows: int) -> None:
    """Two walks from the ends of the range bracket all others until a window closes on them."""
    rng = np.random.default_rng(rows)
    shift = rng.integers(-4, 5, (rows, 2)) / 64
    low, high = np.full((rows, 2), -1.0), np.full((rows, 2), 1.0)
    low[rows // 2, 0] = high[rows // 2, 0] = 0.25
    begin = np.array([[-1.0, -1.0], [1.0, 1.0], [0.5, 0.0]])
    found = scan(Clamp(shift, low, high), begin)
    assert np.array_equal(found, walked(Clamp(shift, low, high), begin))
    assert np.all(found[0] <= found[2]) and np.all(found[2] <= found[1])
    assert np.array_equal(found[0, rows // 2 :, 0], found[1, rows // 2 :, 0])
    assert found[0, rows // 2, 0] == 0.25


def test_what_never_meets_a_bound_adds_up() -> None:
    shift = np.ones((5000, 2)) * [0.5, -0.25]
    endless = np.full((5000, 2), np.inf)
    found = scan(Clamp(shift, -endless, endless), np.zeros((1, 2)))
    assert np.array_equal(found[0], np.arange(1, 5001)[:, None] * [0.5, -0.25])


def test_an_infinite_shift_goes_to_the_bound() -> None:
    shift = np.zeros((300, 2))
    shift[100, 0], shift[200, 1] = np.inf, -np.inf
    low, high = np.full((300, 2), -2.0), np.full((300, 2), 3.0)
    found = scan(Clamp(shift, low, high), np.array([[0.5, 0.5]]))[0]
    assert found[99].tolist() == [0.5, 0.5]
    assert found[100].tolist() == [3.0, 0.5]
    assert found[-1].tolist() == [3.0, -2.0]


def test_pieces_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    clamp = random_clamps(1000, 3, 9, whole=True)
    begin = np.array([[-4.0, 0.0, 4.0], [4.0, 0.0, -4.0]])
    whole = scan(clamp, begin)
    monkeypatch.setattr(clamp_scan, "_PIECE", 77)
    monkeypatch.setattr(clamp_scan, "_WIDTH", 64)
    assert np.array_equal(scan(clamp, begin), whole)


def test_rows_may_have_more_axes() -> None:
    """Several paths side by side: (rows, paths, n)."""
    clamp = random_clamps(200, 12, 4, whole=True)
    folded = Clamp(*(a.reshape(200, 3, 4) for a in (clamp.shift, clamp.low, clamp.high)))
    begin = np.linspace(-2, 2, 12)[None]
    assert np.array_equal(scan(folded, begin), scan(clamp, begin))
