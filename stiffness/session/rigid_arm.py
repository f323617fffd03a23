"""Rigid arm: where it has its reflectors, and readings moved there."""

from __future__ import annotations

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot
from stiffness.session.file import Reflector
from stiffness.session.samples import Samples
from stiffness.statics.statics import Statics

Floats = npt.NDArray[np.float64]


def rigid_points(robot: Robot, reflectors: tuple[Reflector, ...], samples: Samples, q: Floats, scale: float) -> Floats:
    """(N, 3) m, where the reflectors of a rigid arm are in the base.

    Args:
        q: (N, n) rad. scale: factor on the positions of the reflectors, where another unit of length is tried.
    """
    statics, symbol = Statics(robot, ()), ca.SX.sym("q", robot.n)
    posture = statics.posture(symbol, ca.SX.zeros(statics.n_x))
    spots = [posture.links[r.link].at(ca.SX(ca.DM(r.position * scale))) for r in reflectors]
    out = ca.densify(ca.vertcat(*spots))
    (points,) = Kernel(ca.Function("rigid", [symbol], [out])).run(q)
    return np.asarray(points.reshape(len(q), -1, 3)[np.arange(len(q)), samples.reflector])


def placed(points: Floats, position: Floats, weight: Floats | None = None) -> Floats:
    """Readings (N, 3) after the rigid motion that brings them nearest to the points (Kabsch 1976).

    Args:
        weight: (N,) of the readings; None: all alike.
    """
    share = np.full(len(points), 1 / len(points)) if weight is None else weight / weight.sum()
    a, b = share @ position, share @ points
    u, _, vt = np.linalg.svd((position - a).T @ (share[:, None] * (points - b)))
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return np.asarray((position - a) @ u @ flip @ vt + b)
