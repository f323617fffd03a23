"""Refit answer: what of a residual is left when every number of the fit is free to answer to a further pattern."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.least_squares import inverse

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

WEAK = 1e-9  # prior precision of a number over that of the data


@dataclass(frozen=True, repr=False, eq=False)
class RefitAnswer:
    """Least squares about a fit, linear, of readings on their own: no free offsets of set-ups.

    Attributes:
        rows: (N,) readings that take part. sd: (N, 3) m.
        design: (N, 3, V) derivatives of the readings by all numbers over their sd; zero where they take no part.
        inverse: (V, V) of the normal matrix.
    """

    rows: Bools
    sd: Floats
    design: Floats
    inverse: Floats

    @classmethod
    def of(cls, fit: SessionFit, rows: Bools) -> RefitAnswer:
        """Of one session; ``rows`` (N,) take part."""
        sd = fit.samples.sd
        design = np.concatenate([fit.predicted.by_parameter, fit.predicted.by_station], axis=2)
        design = np.where(rows[:, None, None], design / sd[:, :, None], 0.0)
        flat = design.reshape(3 * len(rows), design.shape[2])
        normal = flat.T @ flat
        scale = np.diag(normal)
        known = inverse(normal + np.diag(WEAK * scale + 1e-30)) if len(scale) else normal
        return cls(rows, sd, design, known)

    def without(self, residual: Floats) -> Floats:
        """(N, 3) m: a residual after all numbers have answered to it."""
        return np.asarray((self._weighted(residual) - self._answered(self._weighted(residual))) * self.sd)

    def gain(self, share: Floats, turn: Floats | None, residual: Floats) -> tuple[float, Floats, Floats]:
        """Chi-square that a motion takes away, the motion (3,) m, and the residual (N, 3) m that it leaves.

        Args:
            share: (N,) of the motion that a reading shows. turn: (N, 3, 3) from the axes of the readings to those of
                the motion; None: they are the same. residual: (N, 3) m, as ``without`` left it.
        """
        axes = np.tile(np.eye(3), (len(share), 1, 1)) if turn is None else np.swapaxes(turn, 1, 2)
        pattern = np.where(self.rows[:, None, None], share[:, None, None] * axes / self.sd[:, :, None], 0.0)
        flat = pattern.reshape(-1, 3)
        free = flat - self._project(flat)
        r = self._weighted(residual).reshape(-1)
        normal = flat.T @ free + WEAK * np.diag(np.maximum(np.sum(flat**2, axis=0), 1e-30))
        slope = free.T @ r
        motion = np.linalg.solve(normal, slope)
        left = (r - free @ motion).reshape(-1, 3) * self.sd
        return float(slope @ motion), np.asarray(motion), np.asarray(left)

    def _weighted(self, residual: Floats) -> Floats:
        return np.where(self.rows[:, None], residual / self.sd, 0.0)

    def _answered(self, weighted: Floats) -> Floats:
        return self._project(weighted.reshape(-1, 1)).reshape(-1, 3)

    def _project(self, columns: Floats) -> Floats:
        flat = self.design.reshape(3 * len(self.design), self.design.shape[2])
        return np.asarray(flat @ (self.inverse @ (flat.T @ columns)))
