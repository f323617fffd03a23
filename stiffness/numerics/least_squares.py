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

from stiffness.numerics.whitened import Whitened, gram

Floats = npt.NDArray[np.float64]
State = TypeVar("State")

SETTLED = 1e-3  # standard deviations: a smaller step ends the iteration
EVEN = 1e-9  # standard deviations: rounding of a step
PATIENCE = 3  # exchanges of all wrong bounds at once that may fail to help
PIVOTS = 10  # exchanges per number: more than any real problem takes


@dataclass(frozen=True)
class Ending:
    """When an iteration ends: a step gains less than ``gain`` in cost, of a residual of unit variance, or less than
    this ``share`` of the cost; or after so many ``steps``."""

    gain: float = 0.0
    share: float = 0.0
    steps: int = 40


EXACT = Ending(gain=1e-4)  # a hundredth of a standard deviation
ROUGH = Ending(gain=0.1, share=1e-4, steps=15)  # good enough to be compared, or to tell wrong rows
GLANCE = Ending(share=1e-3, steps=15)  # tells how much the noise leaves unexplained


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
        converged: whether they were enough.
    """

    vector: Floats
    covariance: Floats
    information: Floats
    chi2: float
    count: int
    freedom: float
    steps: int
    converged: bool = True

    @property
    def noises(self) -> float:
        """Residual over noise."""
        return float(np.sqrt(self.chi2 / max(self.freedom, 1.0)))

    @property
    def misfit(self) -> float:
        """Factor on standard deviations: 1 where the noise explains the residual, else what is left over."""
        if self.freedom < 1 or stats.chi2.sf(self.chi2, self.freedom) > 1e-3:
            return 1.0
        return self.noises


def solve(
    blocks: Callable[[Floats, State], tuple[Sequence[Whitened], State]],
    start: Floats,
    state: State,
    *,
    prior: Floats,
    prior_sd: Floats,
    low: Floats,
    high: Floats,
    held: Floats | None = None,
    spent: int = 0,
    ending: Ending = EXACT,
) -> tuple[Solution, State]:
    """Levenberg-Marquardt with a Gaussian prior and bounds; undamped unless a step makes things worse.

    Args:
        blocks: vector, state -> whitened blocks (residual = measured - predicted, jacobian of the prediction), and the
            state that the next evaluation starts from.
        start: (P,) first vector. state: what the first evaluation starts from.
        prior, prior_sd: (P,) mean and standard deviation. low, high: (P,) bounds.
        held: (K, P) combinations of the numbers that have the mean of the prior, in standard deviations; they do not
            count in the covariance.
        ending: what ends the iteration.
        spent: numbers that free offsets inside the blocks take up: they fit themselves.

    Returns:
        The solution, and the state of the last evaluation, whether its step was taken or not.
    """
    own = np.diag(1 / prior_sd**2)
    weight = own if held is None else own + held.T @ held
    vector, damping, steps, ended, last = start.copy(), 0.0, 0, False, False

    def evaluated(at: Floats, state: State) -> tuple[_Quadratic, State]:
        """Blocks go at once: they take more than all else of a fit."""
        parts, state = blocks(at, state)
        return _Quadratic.of(parts, at, prior, weight), state

    here, state = evaluated(vector, state)
    total = here.count
    while steps < ending.steps and not ended:
        steps += 1
        step = here.step(damping, low - vector, high - vector)
        if here.length(step) <= SETTLED:
            ended, last, damping = damping == 0 or last, True, 0.0
            continue
        there, state = evaluated(vector + step, state)
        if not there.cost <= here.cost * (1 + 1e-9):
            ended, damping = last, max(8 * damping, 1e-7)
            continue
        enough = max(ending.gain * max(here.cost / max(total, 1), 1.0), ending.share * here.cost)
        little = here.cost - there.cost < enough
        vector, here = vector + step, there
        # damping holds what the data do not determine where it happens to be: before the end a step without is tried
        ended, last = little and damping == 0, last or little
        damping = damping / 3 if damping > 1e-9 and not little else 0.0
    covariance = inverse(here.information + own)
    used = float(np.trace(covariance @ here.information))
    return Solution(
        vector=vector,
        covariance=covariance,
        information=here.information,
        chi2=here.chi2,
        count=total,
        freedom=total - used - spent,
        steps=steps,
        converged=ended,
    ), state


@dataclass(frozen=True, repr=False)
class _Quadratic:
    """The problem at one vector: chi-square of so many numbers, cost with the prior, gradient and curvature."""

    chi2: float
    count: int
    cost: float
    gradient: Floats
    information: Floats
    weight: Floats

    @classmethod
    def of(cls, parts: Sequence[Whitened], vector: Floats, prior: Floats, weight: Floats) -> _Quadratic:
        off, n = vector - prior, len(vector)
        chi2 = sum(float(b.residual @ b.residual) for b in parts)
        products = gram(parts, n)
        information, gradient = products[:n, :n], products[:n, n] - weight @ off
        return cls(
            chi2=chi2,
            count=sum(len(b.residual) for b in parts),
            cost=chi2 + float(off @ weight @ off),
            gradient=gradient,
            information=information,
            weight=weight,
        )

    def step(self, damping: float, low: Floats, high: Floats) -> Floats:
        """Where the quadratic is smallest between bounds."""
        return bounded_minimum(
            self.information + self.weight + np.diag(damping * np.diag(self.information)), self.gradient, low, high
        )

    def length(self, step: Floats) -> float:
        """Of a step, in standard deviations."""
        return float(max(float(step @ (self.information + self.weight) @ step), 0.0) ** 0.5)


def bounded_minimum(curvature: Floats, gradient: Floats, low: Floats, high: Floats) -> Floats:
    """The x (P,) between bounds where x' C x / 2 - g' x is smallest, C positive definite.

    Block principal pivoting (Judice & Pires 1994): numbers that leave their bounds are held there, those whose
    gradient points inward are released, all at once while that helps, else one at a time, which comes to an end.
    """
    unit = 1 / np.sqrt(np.diag(curvature))
    held = np.zeros(len(gradient), dtype=int)  # -1 on the lower bound, 1 on the upper, 0 free
    x, fewest, patience = np.zeros(len(gradient)), len(gradient) + 1, PATIENCE
    for _ in range(PIVOTS * (len(gradient) + 1)):
        free = held == 0
        x = np.where(held < 0, low, np.where(held > 0, high, 0.0))
        if free.any():
            push = gradient[free] - curvature[np.ix_(free, ~free)] @ x[~free]
            x[free] = _solved(curvature[np.ix_(free, free)], push)
        inward = held * (gradient - curvature @ x) * unit < -EVEN
        below, above = free & (x < low - EVEN * unit), free & (x > high + EVEN * unit)
        wrong = np.flatnonzero(below | above | (inward & (low < high)))
        if not len(wrong):
            break
        if len(wrong) < fewest:
            fewest, patience = len(wrong), PATIENCE
        elif patience:
            patience -= 1
        else:
            wrong = wrong[-1:]
        held[wrong] = np.where(below[wrong], -1, np.where(above[wrong], 1, 0))
    return np.clip(x, low, high)


def lowest(
    parts: Sequence[Whitened], vector: Floats, *, prior: Floats, prior_sd: Floats, low: Floats, high: Floats
) -> float:
    """Chi-square, prior included, at the bottom of the quadratic about ``vector`` (P,), between bounds."""
    here = _Quadratic.of(parts, vector, prior, np.diag(1 / prior_sd**2))
    step = here.step(0.0, low - vector, high - vector)
    return float(here.cost - 2 * here.gradient @ step + step @ (here.information + here.weight) @ step)


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
