"""Equilibrium kernel: many arms at rest at once, by Newton's method on one sweep of the statics, with all slopes.

One CasADi function gives the sweep x -> F(x; v) and its derivatives. Where x = F(x; v) the implicit function theorem
gives those of x by everything else: dx/dv = (I - F_x)^-1 F_v. Only coordinates that answer to others take part in the
solve; the rest are what the sweep says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.numerics.kernel import Kernel

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

PIECE = 512  # arms at a time: their slopes stay in the cache
STEPS = 6
SETTLED = 1e-6  # m and rad: the error that the next step would take away is its square


@dataclass(frozen=True, repr=False, eq=False)
class EquilibriumKernel:
    """Arms at rest, ``m`` coordinates each, as a function of inputs with ``widths`` numbers.

    Attributes:
        kernel: inputs, x -> F, torques, and the derivatives of F by inputs and x that are not always zero.
        row, column: where each of these stands in (m, sum of widths + m).
        wanted: inputs that slopes are wanted for.
        moving: coordinates that answer to others.
    """

    kernel: Kernel
    row: Index
    column: Index
    widths: tuple[int, ...]
    wanted: tuple[int, ...]
    m: int
    moving: Index

    @classmethod
    def of(
        cls, inputs: Sequence[ca.SX], *, wanted: Sequence[int], x: ca.SX, sweep: ca.SX, torque: ca.SX
    ) -> EquilibriumKernel:
        """Of symbols: ``sweep`` (m,) of ``inputs`` and ``x`` (m,); slopes by the ``wanted`` inputs."""
        by = [inputs[k] for k in wanted]
        jacobian = ca.jacobian(sweep, ca.vertcat(*by, x))
        row, column = (np.array(v, dtype=np.intp) for v in jacobian.sparsity().get_triplet())
        widths, m = tuple(v.numel() for v in by), x.numel()
        moving = np.unique(row[column >= sum(widths)])
        out = [ca.densify(sweep), ca.densify(torque), ca.densify(ca.SX(jacobian.nz[:]))]
        kernel = Kernel(ca.Function("equilibria", [*inputs, x], out))
        return cls(kernel=kernel, row=row, column=column, widths=widths, wanted=tuple(wanted), m=m, moving=moving)

    def __repr__(self) -> str:
        return f"EquilibriumKernel({self.m} coordinates, slopes by {sum(self.widths)} numbers)"

    def run(
        self, inputs: Sequence[Floats], x: Floats, own: Index, steps: int = STEPS
    ) -> tuple[Floats, Floats, list[Floats]]:
        """Coordinates (N, m), torques (N, n), and slopes (N, m, width) of coordinates by every wanted input.

        Args:
            inputs: (N, width) or (width,) each. x: (N, m) start.
            own: (P,) those numbers of the first wanted input that slopes are kept by.
            steps: of Newton at most; torques and slopes are those where the last one began.
        """
        first = np.cumsum([0, *self.widths])
        taken = [own, *(np.arange(a, b) for a, b in pairwise(first[1:].tolist()))]
        out, torque = np.empty((len(x), self.m)), list[Floats]()
        by = [np.empty((len(x), self.m, len(columns))) for columns in taken]  # the largest arrays of a fit
        for rows in (slice(a, a + PIECE) for a in range(0, max(len(x), 1), PIECE)):
            given = [v[rows] if v.ndim == 2 else v for v in inputs]
            out[rows], part, slopes = self._piece(given, x[rows], steps)
            torque.append(part)
            for slope, columns in zip(by, taken, strict=True):
                slope[rows] = slopes[:, :, columns]
        return out, np.concatenate(torque), by

    def _piece(self, inputs: Sequence[Floats], x: Floats, steps: int) -> tuple[Floats, Floats, Floats]:
        """Coordinates, torques, and all slopes (N, m, sum of widths) of a few arms."""
        x, width = x.copy(), sum(self.widths)
        for _ in range(steps):
            new, torque, nonzero = self.kernel.run(*inputs, x)
            slopes = np.zeros((len(x), self.m, width + self.m))
            slopes[:, self.row, self.column] = nonzero
            moved, step = self._moved(slopes[:, :, width:]), new - x
            step[:, self.moving] = np.einsum("nkm,nm->nk", moved, step)
            x += step
            if np.abs(step).max(initial=0.0) < SETTLED:
                break
        by = slopes[:, :, :width]
        by[:, self.moving] = moved @ by
        return x, torque, by

    def _moved(self, by_x: Floats) -> Floats:
        """(N, k, m): the rows of (I - F_x)^-1 of the coordinates that answer to others."""
        at = self.moving
        inverse = np.linalg.inv(np.eye(len(at)) - by_x[:, at[:, None], at])
        out = inverse @ by_x[:, at]
        out[:, :, at] = inverse
        return out
