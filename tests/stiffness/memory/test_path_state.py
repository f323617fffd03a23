"""The state along a path, kept where it changes, against the same state kept pose by pose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.memory.preload import PreloadState

Floats = npt.NDArray[np.float64]


def walked(poses: int, columns: int, *, seed: int, unknown: int) -> tuple[Floats, Floats, Floats]:
    """Low, high and likely state: steps at a few poses, not known at the first ``unknown`` ones."""
    rng = np.random.default_rng(seed)
    steps = np.where(rng.uniform(size=(poses, columns)) < 0.1, rng.choice([-1e-4, 1e-4], size=(poses, columns)), 0.0)
    likely = np.cumsum(steps, axis=0)
    wide = np.where(np.arange(poses)[:, None] < unknown, 5e-5, 0.0)
    return likely - wide, likely + wide, likely


@pytest.mark.parametrize("poses", [1, 2, 15, 16, 17, 200])
@pytest.mark.parametrize(("columns", "unknown"), [(6, 0), (6, 5), (2, 1000), (0, 0)])
@pytest.mark.parametrize("piece", [1, 16, 1000])
def test_a_path_in_pieces_is_the_whole(poses: int, columns: int, unknown: int, piece: int) -> None:
    low, high, likely = walked(poses, columns, seed=poses, unknown=unknown)
    whole = PreloadState(low, high, likely)
    cut = [slice(k, k + piece) for k in range(0, poses, piece)]
    path = PreloadState.chained([PreloadState(low[c], high[c], likely[c]) for c in cut])
    for name in ("low", "high", "middle", "known", "is_open", "unknown_rows", "changed"):
        np.testing.assert_array_equal(getattr(path, name), getattr(whole, name), err_msg=name)
    rng = np.random.default_rng(1)
    for rows in (np.arange(poses), rng.integers(0, poses, 30), np.array([poses - 1]), np.empty(0, dtype=np.intp)):
        for name in ("low", "high", "middle"):
            np.testing.assert_array_equal(getattr(path.take(rows), name), getattr(whole, name)[rows])
    for name in ("low", "high", "middle"):
        np.testing.assert_array_equal(getattr(path.last, name), getattr(whole, name)[-1])


def test_states_without_a_history_are_their_mean() -> None:
    """A piece without a likely state gives the mean of its bounds, and keeps it open."""
    low, high, _ = walked(20, 3, seed=4, unknown=20)
    path = PreloadState.chained([PreloadState(low[:8], high[:8]), PreloadState(low[8:], high[8:])])
    np.testing.assert_array_equal(path.middle, 0.5 * (low + high))
    np.testing.assert_array_equal(path.unknown_rows, np.arange(20))


def test_a_joint_that_stays_unknown_takes_hardly_any_room() -> None:
    """Whatever the others do: bounds are kept apart from what is likely."""
    poses = 4000
    likely = np.cumsum(np.full((poses, 6), 1e-6), axis=0)  # changes at every pose
    low, high = likely.copy(), likely.copy()
    low[:, 3], high[:, 3], likely[:, 3] = -5e-5, 5e-5, 0.0
    whole = PreloadState(low, high, likely)
    path = PreloadState.chained([whole.take(np.arange(k, k + 500)) for k in range(0, poses, 500)])
    assert sum(a.nbytes for a in (path.lowest, path.highest, path.bounded, path.rows)) < 0.01 * likely.nbytes
    for name in ("low", "high", "middle", "known", "is_open", "unknown_rows"):
        np.testing.assert_array_equal(getattr(path, name), getattr(whole, name), err_msg=name)


def test_a_piece_that_is_known_follows_one_that_is_not() -> None:
    low, high, likely = walked(20, 3, seed=6, unknown=8)
    path = PreloadState.chained([PreloadState(low[:8], high[:8], likely[:8]), PreloadState(*[likely[8:]] * 3)])
    np.testing.assert_array_equal(path.low, low)
    np.testing.assert_array_equal(path.high, high)
    np.testing.assert_array_equal(path.unknown_rows, np.arange(8))


def test_a_state_that_hardly_changes_takes_hardly_any_room() -> None:
    poses = 20_000
    likely = walked(poses, 12, seed=5, unknown=3)[2][np.arange(poses) // 500 * 500]  # forty changes
    path = PreloadState.chained([PreloadState(likely, likely, likely)])
    kept = sum(a.nbytes for a in vars(path).values() if isinstance(a, np.ndarray))
    assert kept < 0.01 * likely.nbytes
    np.testing.assert_array_equal(path.middle, likely)
