"""How well the readings of a fit determine its numbers: intervals and correlations."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import Unknown

Floats = npt.NDArray[np.float64]

NORMAL_95 = 1.959964  # half width of a 95 % interval in standard deviations


def interval(u: Unknown, value: float, sd: float) -> tuple[float, float]:
    """95 % interval of a number as the model file has it, from ``value`` and ``sd`` as the solver sees them.

    Where the solver sees the inverse, that is what is normally distributed: the interval is not symmetric.
    """
    low, high = value - NORMAL_95 * sd, value + NORMAL_95 * sd
    if not u.inverse:
        return low, high
    return 1 / high, 1 / low if low > 0 else float("inf")


def correlation(fit: Fit) -> Floats:
    """(P, P) of the robot's numbers as the model file has them."""
    n = len(fit.unknowns)
    covariance = fit.solution.covariance[:n, :n]
    sd = np.sqrt(np.diag(covariance))
    sign = np.where(fit.unknowns.inverse, -1.0, 1.0)  # an inverse turns the sign
    return np.asarray(covariance / np.outer(sd, sd) * np.outer(sign, sign))
