"""Axis curve: smooth ways of rails and tables along a path, cubic B-splines over time.

Their coefficients bound them: a curve stays between the least and the greatest, its speed and its acceleration within
the differences of neighbours. So range, speed and acceleration are linear bounds, and hold between poses too.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.interpolate import BSpline

from compensator.axes.cheapest_way import CoarseWay
from compensator.axes.free_axes import FreeAxes
from compensator.turn.windows import minimised

Floats = npt.NDArray[np.float64]

DEGREE = 3
SMOOTH = 30.0  # of bends, beside the ways from the lattice: a cell to and fro is ironed out
ROUNDING = 1e-9


@dataclass(frozen=True, repr=False, eq=False)
class CurveBasis:
    """M cubic B-splines over the time of a path, evenly spread.

    Attributes:
        knots: (M + 4,) s.
        first, second: (M - 1, M) and (M - 2, M): speeds and accelerations that bound those of a curve, per s and s2.
    """

    knots: Floats
    first: sp.csr_matrix
    second: sp.csr_matrix

    @classmethod
    def of(cls, lasts: float, count: int) -> CurveBasis:
        """``count`` splines over ``lasts`` s."""
        inner = np.linspace(0.0, lasts, count - DEGREE + 1)
        knots = np.concatenate([np.full(DEGREE, 0.0), inner, np.full(DEGREE, lasts)])
        speed = DEGREE / (knots[DEGREE + 1 : count + DEGREE] - knots[1:count])
        first = sp.diags([-speed, speed], [0, 1], shape=(count - 1, count), format="csr")
        gain = (DEGREE - 1) / (knots[DEGREE + 1 : count + DEGREE - 1] - knots[2:count])
        second = sp.diags([-gain, gain], [0, 1], shape=(count - 2, count - 1), format="csr") @ first
        return cls(knots, first, second.tocsr())

    def __repr__(self) -> str:
        return f"CurveBasis({self.first.shape[1]} splines over {self.knots[-1]:.3g} s)"

    def at(self, time: Floats, derivative: int = 0) -> sp.csr_matrix:
        """(K, M) values at times (K,) s, or their derivatives."""
        count = self.first.shape[1]
        inside = np.clip(time, 0.0, self.knots[-1] * (1 - 1e-12))
        if not derivative:
            return sp.csr_matrix(BSpline.design_matrix(inside, self.knots, DEGREE))
        return sp.csr_matrix(BSpline(self.knots, np.eye(count), DEGREE).derivative(derivative)(inside))


def smoothed(free: FreeAxes, basis: CurveBasis, way: CoarseWay, time: Floats) -> Floats | None:
    """(M, A) coefficients of curves near a way over the lattice; None where limits of rails leave none.

    Args:
        time: (S,) s of the stages.
    """
    values, count = basis.at(time), basis.first.shape[1]
    bends = basis.second * float(basis.knots[-1] / count) ** 2
    out = np.empty((count, len(free)))
    for a in range(len(free)):
        if not free.moving[a]:
            out[:, a] = way.places[0, a]
            continue
        h = values.T @ values + SMOOTH * bends.T @ bends + ROUNDING * sp.eye(count)
        rows = sp.vstack([values, basis.first, basis.second])
        edge = np.concatenate([np.full(count - 1, free.speed[a]), np.full(count - 2, free.acceleration[a])])
        low, high = np.concatenate([way.low[:, a], -edge]), np.concatenate([way.high[:, a], edge])
        bounds = np.full(count, free.low[a]), np.full(count, free.high[a])
        found = program(h, -(values.T @ way.places[:, a]), rows, low=low, high=high, bounds=bounds)
        if found is None:
            return None
        out[:, a] = np.clip(found, *bounds)
    return out


def program(
    h: sp.spmatrix, gradient: Floats, a: sp.spmatrix, *, low: Floats, high: Floats, bounds: tuple[Floats, Floats]
) -> Floats | None:
    """Minimise x h x / 2 + gradient x with bounds of a x and of x, by PIQP; None where it failed.

    Rows of a without any bound are left out: of each of them PIQP writes a line to standard error.
    """
    bound = np.isfinite(low) | np.isfinite(high)
    low, high, a = low[bound], high[bound], sp.csr_matrix(a)[np.flatnonzero(bound)]
    matrices = [sp.csc_matrix(m) for m in (h, a)]
    for matrix in matrices:
        matrix.sum_duplicates()
    shapes = [ca.Sparsity(m.shape[0], m.shape[1], m.indptr.tolist(), m.indices.tolist()) for m in matrices]
    scale = float(np.abs(matrices[0].diagonal()).max()) or 1.0
    solver = ca.conic("rail", "piqp", {"h": shapes[0], "a": shapes[1]}, {"error_on_fail": False})
    return minimised(
        solver, h=ca.DM(shapes[0], matrices[0].data / scale), a=ca.DM(shapes[1], matrices[1].data),
        g=gradient / scale, lba=low, uba=high, lbx=bounds[0], ubx=bounds[1],
    )  # fmt: skip
