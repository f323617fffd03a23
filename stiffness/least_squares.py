"""Generalised least squares with a prior, and what it says about the data.

Residuals come in blocks; inside a block they are correlated (a wrench reading is shared by all reflectors, an unknown
offset by all states), between blocks they are not. Every block is whitened by the Cholesky factor of its covariance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import linalg, stats

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

STEPS = 25
SETTLED = 1e-6  # of a standard deviation: a smaller step ends the iteration


@dataclass(frozen=True, repr=False)
class Whitened:
    """One block: whitened ``residual`` (k,), ``jacobian`` (k, P), and the factor to look back with."""

    rows: Index
    residual: Floats
    jacobian: Floats
    factor: Floats


@dataclass(frozen=True, repr=False)
class Solution:
    """A least-squares fit.

    Attributes:
        vector: (P,) estimate.
        covariance: (P, P), prior included, not scaled.
        information: (P, P) of the data alone.
        chi2: sum of squares of the whitened residuals.
        count: how many numbers were fitted to.
        freedom: count minus the parameters that the data determines.
        steps: iterations used.
    """

    vector: Floats
    covariance: Floats
    information: Floats
    chi2: float
    count: int
    freedom: float
    steps: int

    @property
    def misfit(self) -> float:
        """Factor on standard deviations: 1 where the noise explains the residual, else what is left over."""
        if self.freedom < 1 or stats.chi2.sf(self.chi2, self.freedom) > 1e-3:
            return 1.0
        return float(np.sqrt(self.chi2 / self.freedom))


def whitened(rows: Index, residual: Floats, jacobian: Floats, covariance: Floats) -> Whitened:
    """Whiten one block; ``covariance`` (k, k) is positive definite."""
    factor = np.linalg.cholesky(covariance)
    both = linalg.solve_triangular(factor, np.column_stack([residual, jacobian]), lower=True, check_finite=False)
    return Whitened(rows, both[:, 0], both[:, 1:], np.asarray(factor, dtype=float))


def solve(
    blocks: Callable[[Floats], Sequence[Whitened]],
    start: Floats,
    prior: Floats,
    prior_sd: Floats,
    low: Floats,
    high: Floats,
) -> Solution:
    """Gauss-Newton with a Gaussian prior and bounds; a step that makes things worse is halved.

    Args:
        blocks: vector -> whitened blocks, residual = measured - predicted, jacobian of the prediction.
    """
    vector, last = start.copy(), np.inf
    sd = prior_sd
    weight = 1 / prior_sd**2
    step = np.zeros_like(vector)
    for count in range(1, STEPS + 1):
        parts = blocks(vector)
        cost = sum(float(b.residual @ b.residual) for b in parts) + float(weight @ (vector - prior) ** 2)
        if cost > last * (1 + 1e-9) and np.abs(step).max() > 0 and count < STEPS:
            step, vector = step / 2, vector - step / 2
            if np.all(np.abs(step) < SETTLED * sd):
                break
            continue
        information = sum((b.jacobian.T @ b.jacobian for b in parts), np.zeros((len(vector), len(vector))))
        gradient = sum((b.jacobian.T @ b.residual for b in parts), np.zeros(len(vector)))
        covariance = inverse(information + np.diag(weight), prior_sd)
        sd = np.sqrt(np.diag(covariance))
        step = covariance @ (gradient - weight * (vector - prior))
        step = np.clip(vector + step, low, high) - vector
        last = cost
        if np.all(np.abs(step) <= SETTLED * sd):
            break
        vector = vector + step
    chi2 = sum(float(b.residual @ b.residual) for b in parts)
    total = sum(len(b.residual) for b in parts)
    used = float(np.trace(covariance @ information))
    return Solution(vector, covariance, information, chi2, total, total - used, count)


def inverse(information: Floats, scale: Floats) -> Floats:
    """Inverse of a symmetric positive matrix, scaled first so that units do not matter."""
    scaled = information * np.outer(scale, scale)
    values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    values = np.maximum(values, 1e-300)
    return np.asarray((vectors / values) @ vectors.T * np.outer(scale, scale))


def deletion_statistics(block: Whitened, sizes: Sequence[int]) -> Floats:
    """Chi-square of leaving out each reading of a block; ``sizes``: how many numbers each reading has.

    With z = C^-1 r and M = C^-1 the reading i, predicted from all the others, misses by M_ii^-1 z_i with covariance
    M_ii^-1, so that z_i' M_ii^-1 z_i is chi-square with as many degrees of freedom as it has numbers.
    """
    inverse_factor = linalg.solve_triangular(block.factor, np.eye(len(block.factor)), lower=True, check_finite=False)
    precision = inverse_factor.T @ inverse_factor
    z = inverse_factor.T @ block.residual
    ends = np.cumsum(sizes)
    spans = [slice(int(e) - n, int(e)) for e, n in zip(ends, sizes, strict=True)]
    return np.array([float(z[s] @ np.linalg.solve(precision[s, s], z[s])) for s in spans])
