"""Programs of the curves of rails."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
import scipy.sparse as sp

from compensator.axes.axis_curve import CurveBasis, program, smoothed
from compensator.axes.cheapest_way import CoarseWay
from compensator.axes.free_axes import FreeAxes

ENDLESS = np.array([-np.inf, -np.inf, -np.inf])


def test_a_joint_that_turns_endlessly_is_no_row(capfd: pytest.CaptureFixture[str]) -> None:
    """Rows without bounds change nothing, and PIQP, which tells of each, prints nothing."""
    h, gradient = 2.0 * sp.eye(2), np.array([-2.0, -8.0])  # least at 1, 4
    rows = sp.csr_matrix(np.array([[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]))
    bounds = np.full(2, -10.0), np.full(2, 10.0)
    free = program(h, gradient, rows, low=ENDLESS, high=-ENDLESS, bounds=bounds)
    held = program(h, gradient, rows, low=ENDLESS, high=np.array([np.inf, np.inf, 3.0]), bounds=bounds)
    assert free is not None and held is not None
    np.testing.assert_allclose(free, [1.0, 4.0], atol=1e-5)
    np.testing.assert_allclose(held, [1.0, 3.0], atol=1e-5)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("loose", [1.0, 20.0])
def test_a_smooth_way_keeps_within_speed_and_acceleration(loose: float) -> None:
    """Of a rail and of a table, mm and deg, on a way that would go faster: with limits 20 times as wide it does."""
    speed, acceleration = np.array([40.0, 4.0]), np.array([60.0, 6.0])
    free = FreeAxes(
        placement=cast(Any, None), names=("E1", "E2"), rail=np.array([True, False]), low=np.full(2, -900.0),
        high=np.full(2, 900.0), speed=loose * speed, acceleration=loose * acceleration, ways=np.zeros((2, 3)),
        moving=np.ones(2, dtype=bool), size=np.array([1e-3, 5e-3]),
    )  # fmt: skip
    time = np.linspace(0.0, 20.0, 41)
    places = np.sin(np.pi * time / 10)[:, None] * [300.0, 30.0]  # up to 94 mm/s and 9.4 deg/s
    way = CoarseWay(places, np.zeros(41), 0, low=places - 400.0, high=places + 400.0, price=0.0)
    basis = CurveBasis.of(20.0, 40)
    found = smoothed(free, basis, way, time)
    assert found is not None
    dense = np.linspace(0.0, 20.0, 2001)
    fastest = [np.abs(basis.at(dense, k) @ found).max(axis=0) for k in (1, 2)]
    within = np.array([fastest[0] <= 1.001 * speed, fastest[1] <= 1.001 * acceleration])
    assert within.all() if loose == 1.0 else not within[0].any()
    assert (fastest[0] > 0.9 * speed).all()
