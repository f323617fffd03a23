"""Programs of the curves of rails."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from compensator.axes.axis_curve import program

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
