"""Random whitened residuals with nuisance and candidate columns, in folds: what linear fits are tested on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.linear_fit import NormalEquations
from stiffness.numerics.whitened import Whitened

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


@dataclass(frozen=True)
class Columns:
    """``nuisance`` (N, m) with its prior ``precision`` (m,), ``candidates`` (N, C), ``residual`` (N,); the rows of a
    block share a fold."""

    nuisance: Floats
    precision: Floats
    candidates: Floats
    residual: Floats
    block: Index
    fold: Index

    @classmethod
    def of(
        cls,
        seed: int,
        candidates: Floats | None = None,
        weight: Floats | None = None,
        *,
        blocks: int = 40,
        count: int = 8,
    ) -> Columns:
        """Unit noise, and candidates of the given true weight."""
        rng = np.random.default_rng(seed)
        sizes = rng.integers(3, 12, blocks)
        block = np.repeat(np.arange(blocks), sizes)
        total = len(block)
        columns = rng.normal(size=(total, count)) if candidates is None else candidates[:total]
        nuisance = rng.normal(size=(total, 3)) * [1.0, 100.0, 1e-3]
        columns = columns + nuisance @ rng.normal(size=(3, columns.shape[1])) * 0.3 / np.abs(nuisance).max()
        residual = rng.normal(size=total) + nuisance @ (rng.normal(size=3) / [1.0, 100.0, 1e-3])
        if weight is not None:
            residual = residual + columns @ weight
        return cls(
            nuisance=nuisance,
            precision=np.array([0.5, 1e-6, 1e-9]),
            candidates=columns,
            residual=residual,
            block=block,
            fold=block % 5,
        )

    def equations(self) -> NormalEquations:
        """As the package sums them up."""
        numbers = np.unique(self.block)
        jacobian = np.hstack([self.nuisance, self.candidates])
        blocks = []
        for k in numbers:
            rows = np.flatnonzero(self.block == k)
            blocks.append(Whitened(rows, self.residual[rows], jacobian[rows], np.eye(len(rows))))
        folds = [int(self.fold[self.block == k][0]) for k in numbers]
        return NormalEquations([(blocks, folds)], self.nuisance.shape[1], self.candidates.shape[1], self.precision)

    def refit(self, columns: list[int], rows: Index | None = None) -> tuple[Floats, Floats, float]:
        """Explicit least squares of nuisance, with its prior as rows of the system, and of columns: their numbers, and
        the cost."""
        rows = np.arange(len(self.residual)) if rows is None else rows
        m = self.nuisance.shape[1]
        design = np.hstack([self.nuisance[rows], self.candidates[np.ix_(rows, columns)]])
        prior = np.hstack([np.diag(np.sqrt(self.precision)), np.zeros((m, len(columns)))])
        system = np.vstack([design, prior])
        right = np.concatenate([self.residual[rows], np.zeros(m)])
        scale = np.linalg.norm(system, axis=0)
        found = np.linalg.lstsq(system / scale, right, rcond=None)[0] / scale
        return found[:m], found[m:], float(np.sum((right - system @ found) ** 2))

    def left_out(self, columns: list[int], fold: int, weight: Floats | None = None) -> float:
        """Chi-square of a fold with all numbers fitted on the others; ``weight``: of the columns, where it is given."""
        inside, outside = np.flatnonzero(self.fold != fold), np.flatnonzero(self.fold == fold)
        if weight is None:
            own, weight, _ = self.refit(columns, inside)
        else:
            moved = self.residual - self.candidates[:, columns] @ weight
            bare = Columns(
                nuisance=self.nuisance,
                precision=self.precision,
                candidates=self.candidates,
                residual=moved,
                block=self.block,
                fold=self.fold,
            )
            own = bare.refit([], inside)[0]
        predicted = self.nuisance[outside] @ own + self.candidates[np.ix_(outside, columns)] @ weight
        return float(np.sum((self.residual[outside] - predicted) ** 2))
