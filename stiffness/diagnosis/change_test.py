"""Change tests: whether a series of vectors is two constants, or a straight line, rather than one constant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

Floats = npt.NDArray[np.float64]

FEWEST = 3  # vectors before and after a step


@dataclass(frozen=True, eq=False)
class ChangeTest:
    """``shift`` (3,) of the best change, its chance ``p`` for one place, twice the log-``likelihood`` it gains, the
    set-up ``at`` which it begins."""

    shift: Floats
    p: float
    likelihood: float
    at: int


def step_test(y: Floats) -> ChangeTest:
    """Two constants instead of one, at the set-up where they explain most."""
    n = len(y)
    k = np.arange(FEWEST, n - FEWEST + 1)
    total = np.cumsum(y, axis=0)
    first = total[k - 1] / k[:, None]
    second = (total[-1] - total[k - 1]) / (n - k)[:, None]
    shift = second - first
    weight = k * (n - k) / n
    centred = y - y.mean(axis=0)
    within = centred.T @ centred - weight[:, None, None] * shift[:, :, None] * shift[:, None, :]
    t2 = _hotelling(shift, weight, within, n)
    at = int(np.argmax(t2))
    rest = centred - np.where(np.arange(n)[:, None] >= k[at], shift[at], 0.0)
    left = np.linalg.slogdet(within[at])[1]
    gained = n * (np.linalg.slogdet(centred.T @ centred)[1] - left)
    return ChangeTest(shift[at], _chance(t2[at], rest, n), gained, int(k[at]))


def line_test(y: Floats, x: Floats) -> ChangeTest:
    """A straight line instead of a constant; the shift is that over the range of x."""
    n = len(y)
    across = (x - x.mean()) / np.ptp(x)
    weight = float(across @ across)
    centred = y - y.mean(axis=0)
    slope = across @ centred / weight
    within = centred.T @ centred - weight * np.outer(slope, slope)
    t2 = _hotelling(slope[None], np.array([weight]), within[None], n)[0]
    gained = n * (np.linalg.slogdet(centred.T @ centred)[1] - np.linalg.slogdet(within)[1])
    return ChangeTest(slope, _chance(t2, centred - across[:, None] * slope, n), gained, 0)


def _hotelling(shift: Floats, weight: Floats, within: Floats, n: int) -> Floats:
    """(K,) T-squared of shifts (K, 3) whose squares of ``weight`` (K,) were taken out of scatter ``within``."""
    covariance = within / (n - 2)
    return np.asarray(weight * np.einsum("ki,ki->k", shift, np.linalg.solve(covariance, shift[:, :, None])[:, :, 0]))


def _chance(t2: float, rest: Floats, n: int) -> float:
    """Of a T-squared as large, for scatter ``rest`` (n, 3) whose neighbours may be alike."""
    rest = rest - rest.mean(axis=0)
    alike = float(np.clip((rest[1:] * rest[:-1]).sum() / max((rest**2).sum(), 1e-300), 0.0, 0.95))
    count = max(n * (1 - alike) / (1 + alike), 6.0)
    f = t2 * count / n * (count - 4) / (3 * (count - 2))
    return float(stats.f.sf(f, 3, count - 4))
