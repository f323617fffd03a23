"""How well the readings of a fit determine its numbers: intervals, correlations, singular values of the design."""

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


def singular_values(fit: Fit) -> tuple[Floats, Floats]:
    """Singular values (P,) of the scaled design, ascending, and their directions (P, P) as columns."""
    n, scale = len(fit.unknowns), fit.unknowns.scale
    squares, directions = np.linalg.eigh(fit.solution.information[:n, :n] * np.outer(scale, scale))
    return np.sqrt(np.maximum(squares, squares[-1] * 1e-32)), directions


def correlation(fit: Fit) -> Floats:
    """(P, P) of the robot's numbers as the model file has them."""
    n = len(fit.unknowns)
    covariance = fit.solution.covariance[:n, :n]
    sd = np.sqrt(np.diag(covariance))
    sign = np.where(fit.unknowns.inverse, -1.0, 1.0)  # an inverse turns the sign
    return np.asarray(covariance / np.outer(sd, sd) * np.outer(sign, sign))
