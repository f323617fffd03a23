"""Coherence: what noise alone does to the sum over pairs, and what a common cause does."""

from __future__ import annotations

import numpy as np
from scipy import stats

from stiffness.identification.coherence import CLEARLY, MAYBE, _agree

STATES, EACH = 200, 3


def scores(common: float, seed: int, draws: int) -> list[float]:
    """Of residuals of unit variance, ``common`` of which (standard deviation) the readings of a state share."""
    rng = np.random.default_rng(seed)
    key = np.repeat(np.arange(STATES), EACH)[:, None]
    out = []
    for _ in range(draws):
        own, shared = rng.normal(size=(STATES * EACH, 3)), np.repeat(rng.normal(size=(STATES, 3)), EACH, axis=0)
        out.append(_agree(np.sqrt(1 - common**2) * own + common * shared, key))
    return out


def test_of_noise_the_standard_errors_are_those_of_a_normal_distribution() -> None:
    found = np.array(scores(0.0, seed=3, draws=2000))
    assert abs(found.mean()) < 0.15 and 0.93 < found.std() < 1.07
    assert np.mean(found > 2) < 2 * stats.norm.sf(2)
    assert np.mean(found > MAYBE) < 0.004 and found.max() < CLEARLY


def test_a_common_cause_of_a_third_of_the_noise_is_coherent() -> None:
    """Pairs agree by 1/9 of the variance: 3 states' pairs in 200 states are 1/9 * sqrt(3 * 3 * 200) errors."""
    assert min(scores(1 / 3, seed=5, draws=50)) > MAYBE / 2
    assert 3.5 < np.mean(scores(1 / 3, seed=5, draws=200)) < 5.5
    assert min(scores(0.7, seed=7, draws=50)) > CLEARLY
