"""Inverse kinematics of arms with a spherical wrist: the closed form over many poses, branch by branch."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.kinematics.closed_form import SphericalArm, branch_measures, closed_form
from stiffness.kinematics.full_turns import continuous, fits_limits, limit_margin, nearest_turn, turns
from stiffness.kinematics.inverse import (
    EXACT,
    SINGULAR,
    Bools,
    Inverse,
    InverseSolution,
    checked_branch,
    checked_path,
    pose_error,
)
from stiffness.kinematics.jacobian import Conditioning
from stiffness.numerics.beside import halves
from stiffness.numerics.kernel import Kernel
from stiffness.poses import PoseArray, Poses
from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

BLOCK = 65536  # poses at a time: they may be made where they are asked for


class SphericalInverse(Inverse):
    """Closed form; branch bits: 4 wrist centre behind axis 1, 2 behind the lower arm, 1 axis 5 bent negative.

    On ABB robots the branch is the controller's cfx (RAPID reference manual, data type confdata).
    """

    branches = 8

    def __init__(self, robot: Robot, arm: SphericalArm) -> None:
        self.robot = robot
        self.arm = arm
        self.function = closed_form(arm)
        self._kernel = Kernel(self.function)
        self._jacobian = Conditioning(robot)

    def all(self, pose: Floats, *, limits: bool = True) -> list[tuple[int, Floats]]:
        every = np.arange(self.branches)
        pose = np.broadcast_to(np.asarray(pose, dtype=float), (self.branches, 4, 4))
        q, margins, _ = self._solve(PoseArray(pose[:, :3, :3], pose[:, :3, 3]), every)
        found = []
        for branch in every[margins.min(axis=1) > -EXACT]:
            if pose_error(self.robot, q[branch], pose[branch]) < EXACT:
                found += [(int(branch), turned) for turned in turns(self.robot, q[branch], limits=limits)]
        return found

    def along(self, poses: Poses, branch: int | Ints, seed: Floats | None = None) -> InverseSolution:
        labels = checked_branch(self, branch, poses.count)
        q, margins, wrist = (np.empty((poses.count, *width)) for width in ((self.robot.n,), (3,), ()))

        def solved(b: slice) -> tuple[Floats, Floats, Floats]:
            return self._solve(checked_path(self.robot, poses.take(b), b.start), labels[b])

        parts = [slice(first, first + BLOCK) for first in range(0, poses.count, BLOCK)]
        for b, found in zip(parts, halves(solved, parts, poses.count), strict=True):
            q[b], margins[b], wrist[b] = found
        q = continuous(self.robot, q, seed)
        reasons = {
            "out of reach: the wrist centre is too close to axis 1": margins[:, 0] < 0,
            "out of reach: too far away": margins[:, 1] < 0,
            "out of reach: too close": margins[:, 2] < 0,
            "singular: wrist centre on axis 1": abs(margins[:, 0]) <= SINGULAR,
            "singular: arm stretched": abs(margins[:, 1]) <= SINGULAR**2,
            "singular: arm folded": abs(margins[:, 2]) <= SINGULAR**2,
            "singular: axes 4 and 6 in line": wrist <= SINGULAR,
        }
        ok = ~np.any(list(reasons.values()), axis=0)
        return InverseSolution(
            q=q,
            ok=ok,
            limit_margin=limit_margin(self.robot, q),
            reach=margins.min(axis=1),
            wrist=wrist,
            reasons=reasons,
        )

    def reached(self, poses: Poses, *, thorough: bool = True) -> Bools:
        path = checked_path(self.robot, poses)
        found = np.zeros(len(path), dtype=np.bool_)
        for branch in range(self.branches):
            q, margins, _ = self._solve(path, np.full(len(path), branch))
            found |= (margins.min(axis=1) > -EXACT) & fits_limits(self.robot, q)
        return found

    def configuration(self, q: Floats) -> Ints:
        return branch_measures(self.arm, np.atleast_2d(q)).branch()

    def singularity(self, q: Floats, *, jacobian: bool = True) -> dict[str, Floats]:
        q = np.atleast_2d(q)
        at = branch_measures(self.arm, q)
        measures = {"wrist": abs(at.wrist), "elbow": abs(at.elbow), "shoulder": abs(at.ahead)}
        return {"jacobian": self._jacobian(q), **measures} if jacobian else measures

    def _solve(self, poses: Poses, branch: Ints) -> tuple[Floats, Floats, Floats]:
        signs = 1.0 - 2.0 * ((branch[:, None] >> np.array([2, 1, 0])) & 1)
        q, margins, wrist = self._kernel.run(poses.rotation.reshape(-1, 9), poses.origin, signs)
        return nearest_turn(q, np.zeros(self.robot.n)), margins, wrist[:, 0]
