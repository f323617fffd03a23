"""A tracker that settles, fitted from where the drift is steady: the time constant is found from there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffness.identify import identify
from stiffness.session.session import load_session
from tests.stiffness.bench_lab import Lab

SPEED, TURN = np.array([6e-8, -3e-8, 4e-8]), np.array([0.0, 7e-9, 1.3e-8])


@pytest.mark.parametrize("settling", [900.0, 3000.0])
def test_the_time_constant_is_found_from_a_steady_start(settling: float, tmp_path: Path) -> None:
    Lab().session(tmp_path, 71, setups=16)
    session = load_session(tmp_path / "session.toml")
    s = session.samples
    time = np.linspace(0.0, 8000.0, len(s))
    gone = settling * -np.expm1(-time / settling)
    shown = s.position + gone[:, None] * (SPEED + np.cross(TURN, s.position))
    drifting = replace(session, samples=replace(s, position=shown, time=time))
    fit = identify([drifting], ["kinematic-offset", "tracker-drift"])
    found, sd = fit.values()["tracker-drift"], fit.deviations()["tracker-drift"]
    assert fit.solution.misfit == 1.0
    assert 0 < sd["settling_s"][0] < 0.2 * settling
    assert abs(found["settling_s"][0] - settling) < 3.5 * sd["settling_s"][0]
    assert np.abs((found["linear_m_per_s"] - SPEED) / sd["linear_m_per_s"]).max() < 3.5
    assert np.abs((found["angular_rad_per_s"] - TURN) / sd["angular_rad_per_s"]).max() < 3.5
