"""Refit answer: what of a residual is left when every number of the fit is free to answer to a further pattern."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse

from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.least_squares import inverse

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/diagnosis/test_attribution.py
WEAK = 1e-9  # prior precision of a number over that of the data


@dataclass(frozen=True, repr=False, eq=False)
class RefitAnswer:
    """Least squares about a fit, linear, of readings on their own: no free offsets of set-ups.

    Attributes:
        rows: (N,) readings that take part, K of them. sd: (K, 3) m.
        design: (3K, V) derivatives of the readings by all numbers over their sd; sparse where these are tables.
        inverse: (V, V) of the normal matrix.
    """

    rows: Bools
    sd: Floats
    design: Floats | sparse.csr_array
    inverse: Floats

    @classmethod
    def of(cls, fit: SessionFit, rows: Bools) -> RefitAnswer:
        """Of one session; ``rows`` (N,) take part."""
        sd, seen = fit.samples.sd[rows], fit.predicted
        numbers = seen.by_number.over(sd, rows)
        station = (seen.by_station[rows] / sd[:, :, None]).reshape(3 * len(sd), -1)
        dense = isinstance(numbers, np.ndarray)
        design = np.hstack([numbers, station]) if dense else sparse.csr_array(sparse.hstack([numbers, station]))
        normal = design.T @ design
        normal = normal if dense else normal.toarray()
        scale = np.diag(normal)
        known = inverse(normal + np.diag(WEAK * scale + 1e-30)) if len(scale) else normal
        return cls(rows, sd, design, known)

    def without(self, residual: Floats) -> Floats:
        """(N, 3) m: a residual after all numbers have answered to it; zero for readings that take no part."""
        weighted = (residual[self.rows] / self.sd).reshape(-1, 1)
        return self._whole(weighted - self._project(weighted))

    def gain(self, share: Floats, turn: Floats | None, residual: Floats) -> tuple[float, Floats, Floats]:
        """Chi-square that a motion takes away, the motion (3,) m, and the residual (N, 3) m that it leaves.

        Args:
            share: (N,) of the motion that a reading shows. turn: (N, 3, 3) from the axes of the readings to those of
                the motion; None: they are the same. residual: (N, 3) m, as ``without`` left it.
        """
        share = share[self.rows]
        axes = np.tile(np.eye(3), (len(share), 1, 1)) if turn is None else np.swapaxes(turn[self.rows], 1, 2)
        flat = (share[:, None, None] * axes / self.sd[:, :, None]).reshape(-1, 3)
        free = flat - self._project(flat)
        r = (residual[self.rows] / self.sd).reshape(-1)
        normal = flat.T @ free + WEAK * np.diag(np.maximum(np.sum(flat**2, axis=0), 1e-30))
        slope = free.T @ r
        motion = np.linalg.solve(normal, slope)
        return float(slope @ motion), np.asarray(motion), self._whole(r - free @ motion)

    def _whole(self, weighted: Floats) -> Floats:
        out = np.zeros((len(self.rows), 3))
        out[self.rows] = weighted.reshape(-1, 3) * self.sd
        return out

    def _project(self, columns: Floats) -> Floats:
        return np.asarray(self.design @ (self.inverse @ (self.design.T @ columns)))
