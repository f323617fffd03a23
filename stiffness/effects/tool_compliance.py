"""Tool compliance: flange, bracket, spindle and tool shank as one six-dimensional spring.

    [d; phi] = C [f; m]

in the axes of the flange, about its origin; C is symmetric and positive semi-definite, given by its six
diagonal entries and, where the data supports it, its fifteen entries below the diagonal, row by row.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, Parameter, Values


def compliance(diagonal: ca.SX, lower: ca.SX) -> ca.SX:
    """Symmetric (6, 6) from its diagonal (6,) and the rows below it (15,)."""
    c = ca.diag(diagonal)
    k = 0
    for row in range(1, 6):
        for column in range(row):
            c[row, column] = c[column, row] = lower[k]
            k += 1
    return c


def _twist(place: int, wrench: ca.SX, p: Values) -> ca.SX:
    linear, angular = p["linear_m_per_n"], p["angular_rad_per_nm"]
    return ca.mtimes(compliance(ca.vertcat(linear, angular), p["coupling"]), wrench)


EFFECT = Effect(
    name="tool-compliance",
    cause="flange, bracket, spindle and tool shank yield, the same in every posture",
    scope="tool",
    parameters=(
        Parameter("linear_m_per_n", "m/N", 3, 1e-8, 0.0, 1e-3, 1e-7, "displacement per force along x, y, z"),
        Parameter("angular_rad_per_nm", "rad/(N*m)", 3, 1e-7, 0.0, 1e-2, 1e-6, "rotation per moment about x, y, z"),
        Parameter("coupling", "SI", 15, 0.0, -1e-2, 1e-2, 1e-7, "entries below the diagonal of C, row by row", 0.0),
    ),
    twist=_twist,
    places=lambda n: (n,),
)
