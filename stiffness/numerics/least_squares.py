"""Generalised least squares with a Gaussian prior and bounds, and the statistics of the fit.

Residuals come in blocks; inside a block they are correlated (a wrench reading is shared by all reflectors, an unknown
offset by all states), between blocks they are not. Every block is whitened by the Cholesky factor of its covariance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from scipy import linalg, stats

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
State = TypeVar("State")

STEPS = 40
STACKED = 256  # blocks per product
NOTHING = 1e-5  # relative gain in cost that ends the iteration
SETTLED = 1e-3  # standard deviations: a smaller step ends the iteration


@dataclass(frozen=True, repr=False)
class Whitened:
    """One block: whitened ``residual`` (k,) and ``jacobian`` (k, P), and the Cholesky ``factor`` of its covariance."""

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


def batches(parts: Sequence[Whitened]) -> list[Sequence[Whitened]]:
    """Blocks to stack at a time: one product of large matrices costs less than many of small ones."""
    return [parts[k : k + STACKED] for k in range(0, len(parts), STACKED)]


def whitened(rows: Index, residual: Floats, jacobian: Floats, covariance: Floats) -> Whitened:
    """Whiten one block; ``covariance`` (k, k) is positive definite."""
    factor = np.linalg.cholesky(covariance)
    both = linalg.solve_triangular(factor, np.column_stack([residual, jacobian]), lower=True, check_finite=False)
    return Whitened(rows, both[:, 0], both[:, 1:], np.asarray(factor, dtype=float))


def solve(
    blocks: Callable[[Floats, State], tuple[Sequence[Whitened], State]],
    start: Floats,
    state: State,
    *,
    prior: Floats,
    prior_sd: Floats,
    low: Floats,
    high: Floats,
    spent: int = 0,
) -> tuple[Solution, State]:
    """Levenberg-Marquardt with a Gaussian prior and bounds; undamped unless a step makes things worse.

    Args:
        blocks: vector, state -> whitened blocks (residual = measured - predicted, jacobian of the prediction), and the
            state that the next evaluation starts from.
        start: (P,) first vector. state: what the first evaluation starts from.
        prior, prior_sd: (P,) mean and standard deviation. low, high: (P,) bounds.
        spent: numbers that free offsets inside the blocks take up: they fit themselves.

    Returns:
        The solution, and the state of the last evaluation, whether its step was taken or not.
    """
    weight = 1 / prior_sd**2
    vector, damping, steps = start.copy(), 0.0, 0
    parts, state = blocks(vector, state)
    here = _Quadratic.of(parts, vector, prior, weight)
    while steps < STEPS:
        steps += 1
        step = here.step(damping, low - vector, high - vector)
        if here.length(step) <= SETTLED:
            break
        parts, state = blocks(vector + step, state)
        there = _Quadratic.of(parts, vector + step, prior, weight)
        if not there.cost <= here.cost * (1 + 1e-9):
            damping = max(8 * damping, 1e-7)
            continue
        gain = here.cost - there.cost
        vector, here, damping = vector + step, there, damping / 3 if damping > 1e-9 else 0.0
        if gain < NOTHING * max(here.cost, 1.0):
            break
    chi2 = sum(float(b.residual @ b.residual) for b in here.parts)
    total = sum(len(b.residual) for b in here.parts)
    covariance = here.covariance()
    used = float(np.trace(covariance @ here.information))
    return Solution(
        vector=vector,
        covariance=covariance,
        information=here.information,
        chi2=chi2,
        count=total,
        freedom=total - used - spent,
        steps=steps,
    ), state


@dataclass(frozen=True, repr=False)
class _Quadratic:
    """The problem at one vector: cost, gradient and curvature."""

    parts: Sequence[Whitened]
    cost: float
    gradient: Floats
    information: Floats
    weight: Floats

    @classmethod
    def of(cls, parts: Sequence[Whitened], vector: Floats, prior: Floats, weight: Floats) -> _Quadratic:
        n = len(vector)
        cost = sum(float(b.residual @ b.residual) for b in parts) + float(weight @ (vector - prior) ** 2)
        information, gradient = np.zeros((n, n)), -weight * (vector - prior)
        for some in batches(parts):
            jacobian = np.concatenate([b.jacobian for b in some])
            information += jacobian.T @ jacobian
            gradient += jacobian.T @ np.concatenate([b.residual for b in some])
        return cls(parts=parts, cost=cost, gradient=gradient, information=information, weight=weight)

    def step(self, damping: float, low: Floats, high: Floats) -> Floats:
        """Where the quadratic is smallest between bounds: what would leave them stands still on them, and the
        others answer to that."""
        curvature = self.information + np.diag(self.weight + damping * np.diag(self.information))
        step, free = np.zeros(len(self.gradient)), np.ones(len(self.gradient), dtype=bool)
        while free.any():
            push = self.gradient[free] - curvature[np.ix_(free, ~free)] @ step[~free]
            step[free] = _solved(curvature[np.ix_(free, free)], push)
            bounded = np.clip(step, low, high)
            leaves = free & (bounded != step)
            step = bounded
            if not leaves.any():
                break
            free &= ~leaves
        return step

    def length(self, step: Floats) -> float:
        """Of a step, in standard deviations."""
        return float(max(float(step @ self.information @ step + self.weight @ step**2), 0.0) ** 0.5)

    def covariance(self) -> Floats:
        return inverse(self.information + np.diag(self.weight))


def lowest(
    parts: Sequence[Whitened], vector: Floats, *, prior: Floats, prior_sd: Floats, low: Floats, high: Floats
) -> float:
    """Chi-square, prior included, at the bottom of the quadratic about ``vector`` (P,), between bounds."""
    here = _Quadratic.of(parts, vector, prior, 1 / prior_sd**2)
    step = here.step(0.0, low - vector, high - vector)
    return float(here.cost - 2 * here.gradient @ step + step @ here.information @ step + step**2 @ here.weight)


def _solved(matrix: Floats, right: Floats) -> Floats:
    """Solution of a symmetric positive system, scaled to a unit diagonal; the pseudo-inverse where rounding ate it."""
    scale = 1 / np.sqrt(np.diag(matrix))
    try:
        factor = linalg.cho_factor(matrix * np.outer(scale, scale), check_finite=False)
    except linalg.LinAlgError:
        return inverse(matrix) @ right
    return np.asarray(scale * linalg.cho_solve(factor, scale * right, check_finite=False))


def inverse(matrix: Floats) -> Floats:
    """Inverse of a symmetric positive matrix, scaled to a unit diagonal first so that units do not matter."""
    scale = 1 / np.sqrt(np.diag(matrix))
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    values = np.maximum(values, 1e-15)
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
