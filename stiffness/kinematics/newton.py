"""Newton steps from joint angles to flange poses, many at once."""

from __future__ import annotations

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.kinematics.jacobian import geometric_jacobian, half_reach
from stiffness.numerics.kernel import Kernel
from stiffness.poses import PoseArray, Poses
from stiffness.robot.robot import Robot
from stiffness.rotation import rotation_vector

Floats = npt.NDArray[np.float64]

_STEPS = 25  # at most
_CONVERGED = 1e-13  # m and rad
_COARSE = 1e-6  # above it a step that does not bring the pose nearer may be followed by one that does


class Newton:
    """Forward kinematics with Jacobian, and its inverse by damped Newton steps.

    Attributes:
        length: m, what translations are divided by to compare them with turns.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        q = ca.SX.sym("q", robot.n)
        rotation, origin = robot.flange_symbolic(q)
        outputs = [ca.vec(rotation.T), origin, ca.vec(geometric_jacobian(rotation, origin, q).T)]
        self._kernel = Kernel(ca.Function("pose_and_jacobian", [q], [ca.densify(e) for e in outputs]))
        self.length = half_reach(robot)

    def evaluate(self, q: Floats) -> tuple[PoseArray, Floats]:
        """Poses and Jacobian (N, 6, n) of the flange at joint angles (N, n)."""
        rotation, origin, jacobian = self._kernel.run(np.ascontiguousarray(q))
        return PoseArray(rotation.reshape(-1, 3, 3), origin), jacobian.reshape(-1, 6, self.robot.n)

    def solve(self, poses: Poses, q: Floats) -> tuple[Floats, Floats]:
        """Angles (N, n) and what is left (N, 2), m and rad, from start values; damped, so never wild."""
        rotation, origin = poses.rotation, poses.origin
        q, error = q.copy(), np.full((len(q), 2), np.inf)
        active = np.arange(len(q))
        for _ in range(_STEPS):
            at, jacobian = self.evaluate(q[active])
            turn = rotation_vector(rotation[active] @ at.rotation.swapaxes(1, 2))
            gap = np.hstack([(origin[active] - at.origin) / self.length, turn])
            size = np.stack(
                [np.linalg.norm(gap[:, :3], axis=1) * self.length, np.linalg.norm(gap[:, 3:], axis=1)], axis=1
            )
            better = size.sum(axis=1) < error[active].sum(axis=1)
            error[active] = np.where(better[:, None], size, error[active])
            going = (size.max(axis=1) > _CONVERGED) & (better | (size.max(axis=1) > _COARSE))
            if not going.any():
                break
            active, gap, size = active[going], gap[going], size[going]
            q[active] += _damped_step(jacobian[going] / np.r_[[self.length] * 3, 1, 1, 1][:, None], gap)
        at, _ = self.evaluate(q)
        left = np.linalg.norm(rotation_vector(rotation @ at.rotation.swapaxes(1, 2)), axis=1)
        return q, np.stack([np.linalg.norm(origin - at.origin, axis=1), left], axis=1)


def _damped_step(jacobian: Floats, gap: Floats) -> Floats:
    """Newton steps (N, n), damped by the gap (Levenberg-Marquardt), at most half a radian per joint."""
    n = jacobian.shape[2]
    damping = np.minimum(np.square(gap).sum(axis=1), 1e-2)
    transposed = jacobian.swapaxes(1, 2)
    # The floor keeps a singular matrix solvable; it is far below what a regular one has.
    normal = transposed @ jacobian + (damping + 1e-14)[:, None, None] * np.eye(n)
    near = damping < 1e-6
    step = np.empty((len(gap), n))
    if near.any():
        regular = np.abs(np.linalg.det(jacobian[near])) > 1e-9
        rows = np.flatnonzero(near)
        step[rows[regular]] = np.linalg.solve(jacobian[rows[regular]], gap[rows[regular], :, None])[:, :, 0]
        near[rows[~regular]] = False
    far = ~near
    step[far] = np.linalg.solve(normal[far], (transposed[far] @ gap[far, :, None]))[:, :, 0]
    longest = np.abs(step).max(axis=1, initial=0.0)
    return np.asarray(step * np.minimum(1.0, 0.5 / np.maximum(longest, 1e-300))[:, None])
