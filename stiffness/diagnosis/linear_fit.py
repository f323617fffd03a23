"""Linear fit: least squares of whitened residuals on columns of a Jacobian, cross-validated over folds of set-ups.

The normal equations need nothing of the data but products of columns. These are summed once per fold; a fit of any
columns then costs a small matrix, so that thousands can be compared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.numerics.packed import Packed
from stiffness.numerics.whitened import Whitened, gram

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

# studied in tests/stiffness/diagnosis/test_linear_fit.py
ROUNDING = 1e-11  # of the largest: sums have some 1e-14 of rounding, and a fold is a difference of such sums
SINGULAR = 1e-4  # of a column's square: less, beside nuisance and other columns, counts as linearly dependent


@dataclass(frozen=True, repr=False)
class ReducedEquations:
    """Normal equations with the nuisance parameters eliminated.

    Attributes:
        curvature: (C, C) J'J. slope: (C,) J'r. chi2: r'r.
        squares: (C,) of the columns before the elimination.
    """

    curvature: Floats
    slope: Floats
    chi2: float
    squares: Floats


@dataclass(frozen=True, repr=False)
class HeldOutFold:
    """One fold left out.

    Attributes:
        others: (C + 1, C + 1) products of the columns and, last, the residual, of all other folds, the nuisance
            parameters eliminated; ``squares`` (C,) of their columns before that.
        own: (C + 1, C + 1) of the fold itself, with the nuisance parameters as the others have them.
        count: numbers of the fold.
    """

    others: Packed
    squares: Floats
    own: Packed
    count: int

    @property
    def chi2(self) -> float:
        """Chi-square of the fold without any column."""
        return float(self.own.triangle[-1])

    def training(self, columns: Index) -> ReducedEquations:
        """The reduced equations of the other folds, of some columns (K,)."""
        found = self.others.block(np.append(columns, len(self.squares)))
        return ReducedEquations(found[:-1, :-1], found[:-1, -1], float(found[-1, -1]), self.squares[columns])

    def score(self, columns: Index, weight: Floats) -> float:
        """Chi-square of the fold for weights (K,) of columns."""
        left = np.append(-weight, 1.0)
        return float(left @ self.own.block(np.append(columns, len(self.squares))) @ left)


@dataclass(frozen=True, repr=False)
class LinearFit:
    """Weights (K,) of some columns, the ``gain``: how far chi-square falls, and the ``rank`` of the system."""

    weight: Floats
    gain: float
    rank: int


class NormalEquations:
    """Products of columns, fold by fold. Constant.

    Args:
        parts: of some blocks each, summed one after the other: whitened residuals, whose jacobian has the ``nuisance``
            parameters' columns first, then those of the ``candidates``, and the number of the fold that every block
            is in.
        precision: (nuisance,) prior precision of the nuisance parameters.
        kept: weight of a fold that is left out among those that it is compared with.
    """

    def __init__(
        self,
        parts: Iterable[tuple[Sequence[Whitened], Sequence[int]]],
        nuisance: int,
        candidates: int,
        precision: Floats,
        *,
        kept: float = 0.0,
    ) -> None:
        self.nuisance, self._precision = nuisance, precision
        grams, count = _summed(parts, nuisance + candidates)
        self.count = sum(count.values())
        triangle = np.zeros((nuisance + candidates + 1) * (nuisance + candidates + 2) // 2)
        for k in sorted(grams):
            triangle += grams[k].triangle
        total = Packed(triangle).whole()
        del triangle
        rest, _ = self._eliminated(total)
        squares = np.diag(total)[nuisance:-1].copy()
        self.reduced = ReducedEquations(rest[:-1, :-1], rest[:-1, -1], float(rest[-1, -1]), squares)
        folds = []
        for k in sorted(grams):
            own = grams.pop(k).whole()  # hundreds of MB, all together
            training = (kept - 1) * own
            training += total
            folds.append(self._fold(training, own, count[k]))
        self.folds = tuple(folds)

    def __repr__(self) -> str:
        return f"NormalEquations({self.count} numbers, {len(self.reduced.slope)} columns, {len(self.folds)} folds)"

    def _eliminated(self, products: Floats) -> tuple[Floats, Floats]:
        """(C + 1, C + 1) without what the nuisance parameters take, and their weights (nuisance, C + 1)."""
        m = self.nuisance
        own = products[:m, :m] + np.diag(self._precision)
        scale = 1 / np.sqrt(np.maximum(np.diag(own), 1e-300))
        values, vectors = np.linalg.eigh(own * np.outer(scale, scale))
        # a direction that the sums do not tell, but for rounding, stays where the fit has it
        told = np.where(values > ROUNDING, 1 / np.maximum(values, ROUNDING), 0.0)
        out = (vectors * told) @ vectors.T * np.outer(scale, scale) @ products[:m, m:]
        return products[m:, m:] - products[m:, :m] @ out, out

    def _fold(self, training: Floats, left: Floats, count: int) -> HeldOutFold:
        m = self.nuisance
        others, out = self._eliminated(training)
        across = left[m:, :m] @ out
        own = left[m:, m:] - across - across.T + out.T @ (left[:m, :m] @ out)
        return HeldOutFold(Packed.of(others), np.diag(training)[m:-1].copy(), Packed.of(own), count)

    def fit(
        self, columns: Sequence[int], positive: Sequence[bool], reduced: ReducedEquations | None = None
    ) -> LinearFit:
        """Weights of columns by least squares, not negative where ``positive``; from all folds, or from ``reduced``."""
        at = np.asarray(columns, dtype=np.intp)
        given = reduced or self.reduced
        free = given.squares[at] > 0
        weight = np.zeros(len(at))
        sided = np.asarray(positive, dtype=bool)
        rank = 0
        while free.any():
            some = at[free]
            part, rank = _solved(given.curvature[np.ix_(some, some)], given.slope[some], given.squares[some])
            below = sided[free] & (part < 0)
            if not below.any():
                weight[free] = part
                break
            worst = np.flatnonzero(free)[below]
            free[worst[np.argmin(part[below] * np.sqrt(given.squares[at[worst]]))]] = False
            rank = 0
        gain = float(2 * given.slope[at] @ weight - weight @ given.curvature[np.ix_(at, at)] @ weight)
        return LinearFit(weight, gain, rank)

    def given(self, columns: Sequence[int], weight: Floats) -> ReducedEquations:
        """The equations that are left when columns with these weights (K,), those of zero not, have been fitted."""
        at = np.asarray(columns, dtype=np.intp)[weight != 0]
        if not len(at):
            return self.reduced
        own = self.reduced
        scale = 1 / np.sqrt(own.squares[at])
        values, vectors = np.linalg.eigh(own.curvature[np.ix_(at, at)] * np.outer(scale, scale))
        keep = values > SINGULAR
        part = (scale[:, None] * vectors[:, keep]) / np.sqrt(values[keep])
        across = own.curvature[:, at] @ part
        solved = part.T @ own.slope[at]
        return ReducedEquations(
            curvature=own.curvature - across @ across.T,
            slope=own.slope - across @ solved,
            chi2=own.chi2 - float(solved @ solved),
            squares=own.squares,
        )

    def cross_validated(self, columns: Sequence[int], positive: Sequence[bool]) -> Floats:
        """(folds,) chi-square of every fold, fitted on the others."""
        at = np.asarray(columns, dtype=np.intp)
        own = range(len(at))
        return np.array([f.score(at, self.fit(own, positive, f.training(at)).weight) for f in self.folds])


def _summed(
    parts: Iterable[tuple[Sequence[Whitened], Sequence[int]]], width: int
) -> tuple[dict[int, Packed], Counter[int]]:
    """Products of ``width`` columns and the residual, and how many numbers they are of, fold by fold."""
    grams: dict[int, Packed] = {}
    count: Counter[int] = Counter()
    for blocks, fold in parts:
        for k in set(fold):
            some = [b for b, f in zip(blocks, fold, strict=True) if f == k]
            found = Packed.of(gram(some, width))
            grams[k] = grams[k] + found if k in grams else found
            count[k] += sum(len(b.residual) for b in some)
    return grams, count


def _solved(curvature: Floats, slope: Floats, squares: Floats) -> tuple[Floats, int]:
    """Least-squares solution with the smallest scaled norm, and its rank."""
    scale = 1 / np.sqrt(squares)
    values, vectors = np.linalg.eigh(curvature * np.outer(scale, scale))
    keep = values > SINGULAR
    part = vectors[:, keep]
    return scale * (part @ ((part.T @ (scale * slope)) / values[keep])), int(keep.sum())
