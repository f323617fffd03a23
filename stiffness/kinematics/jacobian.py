"""The Jacobian over many postures, and how near to singular it is."""

from __future__ import annotations

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]


class Conditioning:
    """Smallest singular value of the Jacobian, linear rows divided by half the reach."""

    def __init__(self, robot: Robot) -> None:
        q = ca.SX.sym("q", robot.n)
        rotation, origin = robot.flange_symbolic(q)
        self._kernel = Kernel(
            ca.Function("jacobian", [q], [ca.densify(ca.vec(geometric_jacobian(rotation, origin, q)))])
        )
        self._length = half_reach(robot)

    def __call__(self, q: Floats) -> Floats:
        (flat,) = self._kernel.run(np.ascontiguousarray(q, dtype=float))
        jacobian = flat.reshape(len(q), q.shape[1], 6)  # transposed: singular values are the same
        return np.linalg.svd(jacobian / np.r_[[self._length] * 3, 1, 1, 1], compute_uv=False)[:, -1]


def half_reach(robot: Robot) -> float:
    """Half the length of the chain, m: what translations are divided by to compare them with turns."""
    moves = (
        np.linalg.norm(robot.before[1:, :3, 3], axis=1).sum()
        + np.linalg.norm(robot.after[:, :3, 3], axis=1).sum()
    )
    return float(moves) / 2


def geometric_jacobian(rotation: ca.SX, origin: ca.SX, q: ca.SX) -> ca.SX:
    """(6, n) of a frame given as expressions of ``q``: linear rows first, base axes."""
    columns = []
    for k in range(q.numel()):
        spin = ca.mtimes(ca.reshape(ca.jacobian(ca.vec(rotation), q[k]), 3, 3), rotation.T)
        columns.append(ca.vertcat(ca.jacobian(origin, q[k]), spin[2, 1], spin[0, 2], spin[1, 0]))
    return ca.horzcat(*columns)
