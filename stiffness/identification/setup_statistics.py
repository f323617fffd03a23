"""Set-up statistics: what a fit's residuals say of its numbers, set-up by set-up, where noise does not explain them.

Residuals of a set-up that the model does not explain have a common cause: they do not average out as noise does. The
jackknife leaves one set-up out at a time (Bell & McCaffrey 2002; "CR3" of Cameron & Miller, J. Human Resources 50
(2015) 317): linearised at the fit, with A its covariance and S_b = J_b' J_b,

    x - x_without_b = A (I - S_b A)^-1 J_b' r_b        var = (G - 1) / G * sum_b (x - x_without_b)^2
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.whitened import Whitened

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class SetupStatistics:
    """Of P numbers.

    Attributes:
        sd: (P,) standard deviations by the jackknife.
        signal: (P,) what a unit of each number does to one reading beyond what all others can imitate, in standard
            deviations of the noise: root of the mean square, over the readings that tell of it.
    """

    sd: Floats
    signal: Floats

    def __repr__(self) -> str:
        return f"SetupStatistics({len(self.sd)} numbers)"

    @classmethod
    def of(cls, setups: Sequence[Sequence[Whitened]], covariance: Floats, count: int) -> SetupStatistics:
        """From the whitened blocks of every set-up at the fit and its covariance (V, V), for the first ``count``."""
        moved, squares, fourths = np.zeros(count), np.zeros(count), np.zeros(count)
        for blocks in setups:
            spread = np.concatenate([_spread(b, covariance) for b in blocks])
            moved += _without(blocks, spread=spread, covariance=covariance, count=count) ** 2
            own = spread[:, :count] ** 2
            squares += own.sum(axis=0)
            fourths += (own**2).sum(axis=0)
        share = (len(setups) - 1) / max(len(setups), 1)
        # by the part of its derivative that no other number imitates: J A e_k / A_kk
        signal = np.sqrt(fourths / np.maximum(squares, 1e-300)) / np.diag(covariance)[:count]
        return cls(np.sqrt(share * moved), signal)


def _spread(block: Whitened, covariance: Floats) -> Floats:
    """(k, V) the jacobian times the covariance."""
    return np.asarray(block.jacobian @ (covariance if block.columns is None else covariance[block.columns]))


def _without(blocks: Sequence[Whitened], spread: Floats, covariance: Floats, count: int) -> Floats:
    """(P,) how the numbers move where these blocks are left out."""
    residual = np.concatenate([b.residual for b in blocks])
    jacobian = np.concatenate([b.wide(len(covariance)) for b in blocks])
    if len(residual) <= len(covariance):
        hat = spread @ jacobian.T
        freed = np.linalg.solve(np.eye(len(hat)) * (1 + 1e-9) - hat, residual)
        return np.asarray(spread[:, :count].T @ freed)
    inner = np.eye(len(covariance)) * (1 + 1e-9) - jacobian.T @ spread
    return np.asarray(covariance[:count] @ np.linalg.solve(inner, jacobian.T @ residual))


def moved_within_setups(sessions: Sequence[SessionFit], asked: npt.NDArray[np.bool_]) -> Floats:
    """(P,) what a unit of each number that is ``asked`` for does to the used readings from state to state of a set-up,
    reflector by reflector, in standard deviations: root of the sum of squares."""
    out = np.zeros(len(asked))
    for s in sessions:
        used, samples = np.flatnonzero(s.used), s.samples
        key = np.column_stack([samples.setup, samples.reflector])[used]
        of = np.unique(key, axis=0, return_inverse=True)[1].ravel()
        slopes_by = s.predicted.by_number
        place = {int(k): i for i, k in enumerate(slopes_by.core)}  # what a table has is not asked for
        for k in np.flatnonzero(asked).tolist():
            slopes = slopes_by.dense[used, :, place[k]] / samples.sd[used]
            mean = np.array([np.bincount(of, axis) for axis in slopes.T]).T / np.bincount(of)[:, None]
            out[k] += np.sum((slopes - mean[of]) ** 2)
    return np.sqrt(out)
