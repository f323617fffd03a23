"""Breakaway torques: the middle of what the readings leave alike, and an interval that holds all of it."""

from __future__ import annotations

import numpy as np
import pytest

from stiffness.diagnosis.added_effects import at_values_of
from stiffness.diagnosis.searched_numbers import (
    NORMAL,
    _chi2,
    _torque_noise,
    _torques,
    searched_deviations,
    with_middles,
    with_number,
)
from stiffness.identification.memory_trials import MemoryTrials
from tests.stiffness.diagnosis.sick import KUKA, sick
from tests.stiffness.diagnosis.test_structure import addition, fitted


def test_a_breakaway_torque_stands_in_the_middle_of_what_is_left_alike() -> None:
    """Every torque of the readings on trial, one after the other."""
    ill = sick("backlash joint-1", KUKA, seed=1)
    fit, (gap,) = fitted(ill, addition("backlash", "joint-1"))
    torque = _torques(fit, 0)
    trials = MemoryTrials(fit.problem, fit.solution.vector, fit.states)
    now = float(gap.values["breakaway_nm"][0])
    own = int(np.searchsorted(torque, now)) - 1
    there = np.arange(max(own - 40, 0), min(own + 40, len(torque) - 1))
    chi2 = np.array(
        [
            _chi2(fit, trials, every=[gap], a=with_number(gap, "breakaway_nm", 0, 0.5 * (torque[k] + torque[k + 1])))
            for k in there
        ]
    )
    least = chi2[there == own][0]

    def edges(more: float) -> tuple[float, float]:
        low = high = int(np.flatnonzero(there == own)[0])
        while chi2[low - 1] <= least + more * fit.solution.misfit**2:
            low -= 1
        while chi2[high + 1] <= least + more * fit.solution.misfit**2:
            high += 1
        return float(torque[there[low]]), float(torque[there[high] + 1])

    low, high = edges(1.0)
    assert high - low > 1.0
    aside = with_number(gap, "breakaway_nm", 0, low + 0.1 * (high - low))
    off = ill.fits.fit([aside], fit)
    middle = with_middles(off, at_values_of(off, [aside]))
    assert middle.fixed["backlash"]["breakaway_nm"][0] == pytest.approx(0.5 * (low + high), rel=1e-3)
    assert middle.values()["backlash"]["gap_rad"][0] == off.values()["backlash"]["gap_rad"][0] > 1e-5
    low, high = edges(3.8415)
    noise = _torque_noise(fit, 0)
    sd = searched_deviations(fit, [gap])["backlash"]["breakaway_nm"][0]
    assert sd == pytest.approx(np.hypot((high - low) / (2 * NORMAL), noise), rel=1e-6)
    assert 0.05 < noise < 2.0
