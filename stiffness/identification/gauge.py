"""Gauge: which directions of a fit's parameters the data determine, and which only the choice of a solution.

Tracker frame, joint zeros and link twists, places of reflectors: many sets of them predict the same readings. In units
of what a drawing leaves open, with the station's numbers eliminated (Schur complement), the information of the data is

    A = D (I_pp - I_ps I_ss^-1 I_sp) D / misfit^2        D = diag(prior standard deviations)

A direction of eigenvalue below TOLD is known less well from the data than to half of what the drawing leaves open.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stiffness.numerics.least_squares import inverse

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/identification/test_gauge.py
TOLD = 4.0  # (prior sd / sd of the data alone)^2, noise widened by the misfit: the data know it to half of the drawing
MOSTLY = 0.5  # share of the variance in directions that are not told: the number is the choice of a solution
NOTED = 0.1  # prior standard deviations: what the choice of a solution may do to a number that is printed


@dataclass(frozen=True, repr=False, eq=False)
class Gauge:
    """Directions of P parameters.

    Attributes:
        unit: (P,) what a drawing leaves open, as the solver sees the numbers: the loose prior.
        scale: (P,) typical sizes.
        information: (P, P) of data and firm priors, the station eliminated, for noise widened by the misfit.
    """

    unit: Floats
    scale: Floats
    information: Floats

    def __repr__(self) -> str:
        return f"Gauge({self.count} of {len(self.unit)} directions determined)"

    @classmethod
    def of(cls, unit: Floats, scale: Floats, *, data: Floats, sd: Floats, misfit: float) -> Gauge:
        """From the information (V, V) of the data and the prior standard deviations (V,) of a fit's numbers, those of
        the station behind the P parameters."""
        n = len(unit)
        own = data[n:, n:] + np.diag(sd[n:] ** -2.0)
        shared = data[:n, n:] @ inverse(own) @ data[n:, :n] if len(own) else np.zeros((n, n))
        firm = np.where(sd[:n] < unit, sd[:n] ** -2.0, 0.0)
        return cls(unit, scale, (data[:n, :n] - shared) / misfit**2 + np.diag(firm))

    @cached_property
    def _spectrum(self) -> tuple[Floats, Floats]:
        scaled = self.information * np.outer(self.unit, self.unit)
        return np.linalg.eigh(0.5 * (scaled + scaled.T))

    @property
    def told(self) -> Bools:
        """(P,) of the directions, the least determined first, whether the data determine them."""
        return np.asarray(self._spectrum[0] >= TOLD)

    @property
    def count(self) -> int:
        """How many directions are determined."""
        return int(self.told.sum())

    def open_rows(self) -> Floats:
        """(K, P): what the parameters do in directions that are not determined, in prior standard deviations."""
        return np.asarray(self._spectrum[1][:, ~self.told].T / self.unit)

    @cached_property
    def chosen(self) -> Bools:
        """(P,) parameters whose number is mostly the choice of a solution."""
        values, directions = self._spectrum
        variance = directions**2 / (1 + np.maximum(values, 0.0))
        free = variance[:, ~self.told].sum(axis=1)
        return np.asarray((free > MOSTLY * variance.sum(axis=1)) & (free > NOTED**2))

    @cached_property
    def singular(self) -> tuple[Floats, Floats]:
        """Singular values of the design in the determined directions, ascending, and these directions (P, K) as
        columns; numbers scaled to their typical size, the station eliminated, noise widened by the misfit."""
        basis, _ = np.linalg.qr(self._spectrum[1][:, self.told] * (self.unit / self.scale)[:, None])
        inner = basis.T @ (self.information * np.outer(self.scale, self.scale)) @ basis
        squares, turned = np.linalg.eigh(0.5 * (inner + inner.T))
        return np.sqrt(np.maximum(squares, 0.0)), basis @ turned
