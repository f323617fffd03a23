"""Joint coupling: the torque of one joint deflects another (parallel linkage of joints 2 and 3, wrist gears).

    dq_i = sum_j  rho_ij sqrt(c_i c_j) tau_j        c = 1/K,  rho symmetric, rho_ii = 0

on top of joint-stiffness. rho is the entry of the compliance matrix of the joints over the root of its two diagonal
entries; with I + rho positive semi-definite no torque gains energy.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from stiffness.effects.effect import Effect, Floats, JointInput, Numbers, Parameter, Values
from stiffness.effects.semidefinite import nearest_semidefinite


def _law(given: JointInput, p: Values) -> ca.SX:
    n, root = given.torque.numel(), ca.sqrt(given.compliance)
    rho = ca.SX.zeros(n, n)
    k = 0
    for row in range(n):
        for column in range(row):
            rho[row, column] = rho[column, row] = p["coupling"][k]
            k += 1
    return root * ca.mtimes(rho, root * given.torque)


def _check(p: Numbers) -> str:
    count = len(p["coupling"])
    n = round((1 + np.sqrt(1 + 8 * count)) / 2)
    rho = np.eye(n)
    rho[np.tril_indices(n, -1)] = p["coupling"]
    rho = rho + np.tril(rho, -1).T
    smallest = float(np.linalg.eigvalsh(rho).min())
    if smallest < -1e-9:
        return (
            f"coupling: 1 + coupling is not positive semi-definite (smallest eigenvalue {smallest:.2g}): some torque "
            "would gain energy; make the entries smaller"
        )
    return ""


def _nearest(p: Numbers, precision: Floats | None = None) -> dict[str, Floats]:
    """Entries with which no torque gains energy: nearest by their ``precision``, else all made smaller alike."""
    count = len(p["coupling"])
    n = round((1 + np.sqrt(1 + 8 * count)) / 2)
    rho = np.zeros((n, n))
    rho[np.tril_indices(n, -1)] = p["coupling"]
    rho = rho + rho.T
    if precision is not None:
        made = nearest_semidefinite(rho + np.eye(n), precision, unit_diagonal=True)
        return {"coupling": made[np.tril_indices(n, -1)] * (1 - 1e-9)}
    smallest = float(np.linalg.eigvalsh(rho).min())
    return {"coupling": p["coupling"] * min(1.0, -1.0 / smallest if smallest < 0 else 1.0)}


EFFECT = Effect(
    name="joint-coupling",
    cause="the torque of one joint deflects another, through a parallel linkage or the gears of the wrist",
    scope="robot",
    site_kind="pair",
    parameters=(
        Parameter(
            name="coupling",
            unit="1",
            size="pair",
            start=0.0,
            low=-1.0,
            high=1.0,
            scale=0.2,
            meaning="share of the mean compliance of two joints, for (2,1), (3,1), (3,2), (4,1) ...",
            neutral=0.0,
        ),
    ),
    joint=_law,
    nearest=_nearest,
    check=_check,
)
