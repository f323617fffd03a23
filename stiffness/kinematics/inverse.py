"""Inverse: the contract of every inverse kinematics, its result, and the checks of its arguments."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.poses import PoseArray, Poses
from stiffness.robot.robot import Robot
from stiffness.rotation import antisymmetric

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

SINGULAR = 1e-9  # sine or m: below this the angles of a pose are not determined by it
EXACT = 1e-9  # m and rad: how far a returned posture may stand from its pose


@dataclass(frozen=True, eq=False, repr=False)
class InverseSolution:
    """Joint angles of N poses.

    Attributes:
        q: (N, n) rad; finite, but without meaning where not ``ok``.
        ok: (N,) the flange reaches the pose, and the posture is not exactly singular; joint limits do not count.
        limit_margin: (N, n) rad to the nearer limit; negative beyond it.
        reach: (N,) m, negative: out of reach. Closed form: from the edge of the reach. Iterative: 0 where
            solved, else minus the position error that was left.
        wrist: (N,) |sin| of the angle between axes 4 and 6.
        reasons: for each kind of failure the poses (N,) that have it.
    """

    q: Floats
    ok: Bools
    limit_margin: Floats
    reach: Floats
    wrist: Floats
    reasons: dict[str, Bools]

    def __repr__(self) -> str:
        return f"InverseSolution({len(self.ok)} poses, {int(self.ok.sum())} solved)"

    def why(self, pose: int) -> str:
        """What is wrong with a pose, in words; empty when nothing is."""
        return "; ".join(reason for reason, poses in self.reasons.items() if poses[pose])


class Inverse(ABC):
    """Inverse kinematics of one robot.

    Attributes:
        robot: whose.
        branches: number of branch labels: 0 .. branches - 1.
    """

    robot: Robot
    branches: int

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.robot.name}, {self.branches} branches)"

    @abstractmethod
    def all(self, pose: Floats, *, limits: bool = True) -> list[tuple[int, Floats]]:
        """Every posture (branch, q (n,) rad) that takes up a flange pose (4, 4).

        Args:
            limits: True: every turn of 2 pi inside the joint limits, and none outside; a joint without
                limits gets its turn within +-pi. False: each branch once, within +-pi.
        """

    @abstractmethod
    def along(self, poses: Poses, branch: int | Ints, seed: Floats | None = None) -> InverseSolution:
        """Postures along a path of flange poses in the base.

        Args:
            poses: N of them.
            branch: label, or (N,) labels.
            seed: (n,) rad: the path starts at the turn nearest to it and is then without jumps of 2 pi.
                (N, n): each pose takes the turn nearest to its own. None: the turn of the whole path that
                stands best between the limits.
        """

    @abstractmethod
    def reached(self, poses: Poses, *, thorough: bool = True) -> Bools:
        """(N,) whether some posture within the joint limits takes up each of N flange poses in the base.

        Args:
            thorough: False: an iterative search may miss some, in a tenth of the time.
        """

    @abstractmethod
    def configuration(self, q: Floats) -> Ints:
        """(N,) branch labels of postures q (N, n) rad."""

    @abstractmethod
    def singularity(self, q: Floats, *, jacobian: bool = True) -> dict[str, Floats]:
        """Measures (N,) that vanish where the arm is singular, by name.

        jacobian: smallest singular value of the Jacobian at the flange, its linear rows divided by the
            characteristic length (half the reach). Costs 10 microseconds a pose.
        wrist: |sin| of the angle between axes 4 and 6.
        elbow: |sin| of the angle between lower arm and wrist centre: stretched or folded at zero.
        shoulder: wrist centre over axis 1, distance in m beyond its lateral offset.
        """


def pose_error(robot: Robot, q: Floats, pose: Floats) -> float:
    """The larger of the distances, m and rad, between the flange at ``q`` and a pose (4, 4)."""
    got = robot.pose(q)
    turn = got[:3, :3].T @ pose[:3, :3]
    angle = np.arctan2(np.linalg.norm(antisymmetric(turn)), np.trace(turn) - 1)
    return max(float(np.linalg.norm(got[:3, 3] - pose[:3, 3])), float(angle))


def checked_path(robot: Robot, poses: Poses, first: int = 0) -> PoseArray:
    """The poses as contiguous arrays; refused when shapes are wrong or a number is not finite.

    Args:
        first: number of the first of them, for messages.
    """
    rotation = np.ascontiguousarray(poses.rotation, dtype=float)
    origin = np.ascontiguousarray(poses.origin, dtype=float)
    if origin.ndim != 2 or origin.shape[1] != 3 or rotation.shape != (len(origin), 3, 3):
        raise RobotError(f"poses are (N, 3, 3) and (N, 3), got {rotation.shape} and {origin.shape}")
    finite = np.isfinite(rotation).all(axis=(1, 2)) & np.isfinite(origin).all(axis=1)
    if not finite.all():
        raise RobotError(f"robot {robot.name}: pose {first + int(np.argmin(finite))} of the path is not finite")
    return PoseArray(rotation, origin)


def checked_branch(inverse: Inverse, branch: int | Ints, count: int) -> Ints:
    """(count,) labels; refused when one does not exist."""
    labels = np.broadcast_to(np.asarray(branch), (count,)) if np.ndim(branch) == 0 else np.asarray(branch)
    if labels.shape != (count,) or not np.issubdtype(labels.dtype, np.integer):
        raise RobotError(f"branch is a whole number or ({count},) of them, got {branch!r}")
    if count and (labels.min() < 0 or labels.max() >= inverse.branches):
        raise RobotError(
            f"branch {labels.min()}..{labels.max()}: {inverse.robot.name} has 0..{inverse.branches - 1}"
        )
    return labels.astype(np.int64)
