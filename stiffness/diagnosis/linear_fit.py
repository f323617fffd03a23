"""Ledger: what columns explain of whitened residuals, inside the data and on set-ups left out.

All that linear least squares asks of the data are products of columns. They are summed once per fold of set-ups;
after that a choice of columns costs a small matrix, and thousands can be compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.numerics.least_squares import Whitened, batches

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

SINGULAR = 1e-4  # of a column's own square: what nuisance or other columns leave of it below is not told apart


@dataclass(frozen=True, repr=False)
class Reduced:
    """Products of columns with what nuisance explains taken out: curvature (C, C), slope (C,), chi2; ``whole`` (C,)
    squares of the columns before that."""

    curvature: Floats
    slope: Floats
    chi2: float
    whole: Floats


@dataclass(frozen=True, repr=False)
class Held:
    """One fold left out: the fit is made on ``trained``, the score is chi2 - 2 slope'b + b'curvature b."""

    trained: Reduced
    slope: Floats
    curvature: Floats
    chi2: float
    count: int

    def score(self, columns: Index, weight: Floats) -> float:
        """Chi-square of the fold for weights (K,) of columns."""
        own = self.curvature[np.ix_(columns, columns)]
        return float(self.chi2 - 2 * self.slope[columns] @ weight + weight @ own @ weight)


@dataclass(frozen=True, repr=False)
class Linear:
    """A linear fit: ``weight`` (K,) of the columns, ``gain`` in chi-square, ``rank`` of what was fitted."""

    weight: Floats
    gain: float
    rank: int


class Ledger:
    """Products of columns, fold by fold.

    Args:
        blocks: whitened residuals; their jacobian holds ``nuisance`` columns, then the candidates'.
        fold: which fold every block is in.
        precision: (nuisance,) prior weight of the nuisance, per squared unit.
    """

    def __init__(self, blocks: Sequence[Whitened], fold: Sequence[int], nuisance: int, precision: Floats) -> None:
        self.nuisance, self.folds = nuisance, max(fold) + 1
        width = blocks[0].jacobian.shape[1]
        gram, count = np.zeros((self.folds, width + 1, width + 1)), np.zeros(self.folds, dtype=int)
        for k in range(self.folds):
            for some in batches([b for b, f in zip(blocks, fold, strict=True) if f == k]):
                both = np.concatenate([np.column_stack([b.jacobian, b.residual]) for b in some])
                gram[k] += both.T @ both
                count[k] += len(both)
        self.count = int(count.sum())
        self._precision = precision
        total = gram.sum(axis=0)
        self.all = self._reduced(total)[0]
        self.held = [self._held(total - gram[k], gram[k], int(count[k])) for k in range(self.folds)]

    def __repr__(self) -> str:
        return f"Ledger({self.count} numbers, {len(self.all.slope)} columns, {self.folds} folds)"

    def _reduced(self, gram: Floats) -> tuple[Reduced, Floats]:
        """Without nuisance, and the weights (nuisance, C + 1) that take it out."""
        m = self.nuisance
        own = gram[:m, :m] + np.diag(self._precision)
        scale = 1 / np.sqrt(np.maximum(np.diag(own), 1e-300))
        values, vectors = np.linalg.eigh(own * np.outer(scale, scale))
        inverse = (vectors / np.maximum(values, 1e-13)) @ vectors.T * np.outer(scale, scale)
        out = inverse @ gram[:m, m:]
        rest = gram[m:, m:] - gram[m:, :m] @ out
        return Reduced(rest[:-1, :-1], rest[:-1, -1], float(rest[-1, -1]), np.diag(gram)[m:-1].copy()), out

    def _held(self, trained: Floats, left: Floats, count: int) -> Held:
        m = self.nuisance
        reduced, out = self._reduced(trained)
        test = left[m:, m:] - out.T @ left[:m, m:] - left[m:, :m] @ out + out.T @ left[:m, :m] @ out
        return Held(reduced, test[:-1, -1], test[:-1, :-1], float(test[-1, -1]), count)

    def fit(self, columns: Sequence[int], positive: Sequence[bool], reduced: Reduced | None = None) -> Linear:
        """Weights of columns by least squares; those that cannot be negative are not."""
        at = np.asarray(columns, dtype=np.intp)
        given = reduced or self.all
        free = given.whole[at] > 0
        weight = np.zeros(len(at))
        sided = np.asarray(positive, dtype=bool)
        rank = 0
        while free.any():
            some = at[free]
            part, rank = _solved(given.curvature[np.ix_(some, some)], given.slope[some], given.whole[some])
            below = sided[free] & (part < 0)
            if not below.any():
                weight[free] = part
                break
            worst = np.flatnonzero(free)[below]
            free[worst[np.argmin(part[below] * np.sqrt(given.whole[at[worst]]))]] = False
            rank = 0
        gain = float(2 * given.slope[at] @ weight - weight @ given.curvature[np.ix_(at, at)] @ weight)
        return Linear(weight, gain, rank)

    def heldout(self, columns: Sequence[int], positive: Sequence[bool]) -> Floats:
        """(folds,) chi-square of every fold, fitted on the others."""
        at = np.asarray(columns, dtype=np.intp)
        return np.array([h.score(at, self.fit(columns, positive, h.trained).weight) for h in self.held])


def _solved(curvature: Floats, slope: Floats, whole: Floats) -> tuple[Floats, int]:
    """Least-squares solution with the smallest scaled norm, and its rank."""
    scale = 1 / np.sqrt(whole)
    values, vectors = np.linalg.eigh(curvature * np.outer(scale, scale))
    keep = values > SINGULAR
    part = vectors[:, keep]
    return scale * (part @ ((part.T @ (scale * slope)) / values[keep])), int(keep.sum())
