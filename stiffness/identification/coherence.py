"""Coherence: whether residuals of readings of one arm at rest agree with each other, which noise does not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.least_squares import Solution

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/identification/test_coherence.py
CLEARLY = 5.0  # standard errors
MAYBE = 3.0  # standard errors, where it only makes intervals wider


def coherent(fit: SessionFit, clearly: float = CLEARLY) -> bool:
    """Whether residuals agree between reflectors of one link in one state, or between the states of a set-up."""
    s = fit.samples
    residual = (s.position - fit.predicted.position) / s.sd
    used = fit.used & fit.session.counts
    between_reflectors = np.column_stack([s.setup, s.state, fit.observations.data.link])
    between_states = np.column_stack([s.setup, s.reflector])
    return any(_agree(residual[used], key[used]) > clearly for key in (between_reflectors, between_states))


def hidden_bias(solution: Solution, sessions: Sequence[SessionFit]) -> Floats:
    """(V,) how far an effect that the model lacks may have moved each number; 0 where the residual is like noise.

    As much of it may lie along a number, where a fit does not see it, as is left of it beside: as many of the number's
    own standard deviations as the root of what chi-square has more than noise leaves.
    """
    if not any(coherent(s, MAYBE) for s in sessions):
        return np.zeros(len(solution.vector))
    left = max(solution.chi2 - solution.freedom, 0.0)
    return np.asarray(np.sqrt(np.diag(solution.covariance) * left))


def _agree(residual: Floats, key: npt.NDArray[np.int64]) -> float:
    """Standard errors by which products of residuals (N, 3) of one key are above zero."""
    _, of = np.unique(key, axis=0, return_inverse=True)
    of = of.reshape(-1)
    total = np.stack([np.bincount(of, residual[:, c]) for c in range(3)], axis=1)
    square = np.stack([np.bincount(of, residual[:, c] ** 2) for c in range(3)], axis=1)
    products = ((total**2 - square) / 2).sum(axis=1)  # sum over the pairs of a key
    spread = float(np.sqrt((products**2).sum()))
    return float(products.sum()) / spread if spread > 0 else 0.0
