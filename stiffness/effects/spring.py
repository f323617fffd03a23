"""A six-dimensional spring: the law that base and tool compliance share.

    [d; phi] = C [f; m]

C is symmetric and positive semi-definite, given by its six diagonal entries and, where the data supports it, its
fifteen entries below the diagonal, row by row.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from stiffness.effects.effect import Floats, Numbers, Parameter, PlaceInput, Values
from stiffness.effects.semidefinite import nearest_semidefinite

_ROUNDING = 1e-9  # of the scaled matrix: a fit that stops at the bound is singular, not negative

PARAMETERS = (
    Parameter(
        name="linear_m_per_n",
        unit="m/N",
        size=3,
        start=1e-8,
        low=0.0,
        high=1e-3,
        scale=1e-7,
        meaning="displacement per force along x, y, z",
        neutral=0.0,
    ),
    Parameter(
        name="angular_rad_per_nm",
        unit="rad/(N*m)",
        size=3,
        start=1e-7,
        low=0.0,
        high=1e-2,
        scale=1e-6,
        meaning="rotation per moment about x, y, z",
        neutral=0.0,
    ),
    Parameter(
        name="coupling",
        unit="m/N, rad/N, rad/(N*m)",
        size=15,
        start=0.0,
        low=-1e-2,
        high=1e-2,
        scale=1e-7,
        meaning="entries of C below the diagonal, row by row",
        default=0.0,
        neutral=0.0,
        extra=True,
    ),
)


def compliance(diagonal: ca.SX, lower: ca.SX) -> ca.SX:
    """Symmetric (6, 6) from its diagonal (6,) and the rows below it (15,)."""
    c = ca.diag(diagonal)
    k = 0
    for row in range(1, 6):
        for column in range(row):
            c[row, column] = c[column, row] = lower[k]
            k += 1
    return c


def yielded(given: PlaceInput, p: Values) -> ca.SX:
    """The displacement [d; phi] of the place."""
    linear, angular = p["linear_m_per_n"], p["angular_rad_per_nm"]
    return ca.mtimes(compliance(ca.vertcat(linear, angular), p["coupling"]), given.wrench)


def check(p: Numbers) -> str:
    """A compliance that is not positive semi-definite would yield against some load."""
    diagonal = np.concatenate([p["linear_m_per_n"], p["angular_rad_per_nm"]])
    c = np.zeros((6, 6))
    c[np.tril_indices(6, -1)] = p["coupling"]
    c = c + c.T
    rigid = diagonal == 0
    if np.any(c[rigid]):
        row = int(np.argmax(np.any(c != 0, axis=1) & rigid)) + 1
        return f"coupling: row {row} of C has a zero on the diagonal and coupling"
    scale = np.sqrt(np.where(rigid, 1.0, diagonal))
    smallest = float(np.linalg.eigvalsh(c / np.outer(scale, scale) + np.diag(~rigid * 1.0)).min())
    if smallest < -_ROUNDING:
        return (
            f"coupling: C is not positive semi-definite (smallest eigenvalue {smallest:.2g} with the diagonal scaled "
            "to 1): it would yield against some load; make the coupling smaller or the diagonal larger"
        )
    return ""


def nearest(p: Numbers, precision: Floats | None = None) -> dict[str, Floats]:
    """C without its negative directions: nearest by the ``precision`` (21, 21) of its numbers, else (Higham 1988) with
    entries weighed by their typical sizes."""
    c = np.diag(np.concatenate([p["linear_m_per_n"], p["angular_rad_per_nm"]]))
    below = np.zeros((6, 6))
    below[np.tril_indices(6, -1)] = p["coupling"]
    size = np.sqrt(np.repeat([PARAMETERS[0].scale, PARAMETERS[1].scale], 3))
    scaled = (c + below + below.T) / np.outer(size, size)
    if precision is None:
        values, vectors = np.linalg.eigh(scaled)
        made = (vectors * np.maximum(values, 0.0)) @ vectors.T
    else:
        unit = np.outer(size, size)
        unit = np.concatenate([np.diag(unit), unit[np.tril_indices(6, -1)]])
        made = nearest_semidefinite(scaled, precision * np.outer(unit, unit))
    made = made * np.outer(size, size)
    diagonal = np.diag(made) * (1 + 1e-9)  # rounding must not make it negative again
    return {
        "linear_m_per_n": diagonal[:3],
        "angular_rad_per_nm": diagonal[3:],
        "coupling": made[np.tril_indices(6, -1)],
    }
