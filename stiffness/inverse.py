"""Inverse kinematics: flange poses -> joint angles, one arm configuration ("branch") kept along a path."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.kernel import Kernel
from stiffness.robot import Robot
from stiffness.spherical import SphericalArm, closed_form, posture, spherical_arm

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

TURN = 2 * np.pi
SINGULAR = 1e-9  # sine or m: below this the angles of a pose are not determined by it
EXACT = 1e-9  # m and rad: how far a returned posture may stand from its pose
_LIMIT = 1e-9  # rad: a posture this little beyond a limit is on the limit


@dataclass(frozen=True, eq=False, repr=False)
class Batch:
    """Joint angles of N poses.

    Attributes:
        q: (N, n) rad; finite, but meaningless where not ``ok``.
        ok: (N,) the posture takes up the pose, and it is not exactly singular. Limits are not in it.
        limit_margin: (N, n) rad to the nearer limit; negative beyond it.
        reach: (N,) m from the edge of the reach (closed form), else the position error, negative, of what was found
            where there is no solution, 0 elsewhere; negative: out of reach.
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
        return f"Batch({len(self.ok)} poses, {int(self.ok.sum())} solved)"

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
    def along(
        self, rotation: Floats, origin: Floats, branch: int | Ints, seed: Floats | None = None
    ) -> Batch:
        """Postures along a path of flange poses in the base.

        Args:
            rotation: (N, 3, 3).
            origin: (N, 3) m.
            branch: label, or (N,) labels.
            seed: (n,) rad: the path starts at the turn nearest to it and is then without jumps of 2 pi; or (N, n):
                each pose takes the turn nearest to its own. None: the turns that keep the path within limits.
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


def inverse_kinematics(robot: Robot) -> Inverse:
    """Closed form for a spherical wrist, else iterative."""
    arm = spherical_arm(robot)
    if arm is None:
        from stiffness.iterative import IterativeInverse

        return IterativeInverse(robot)
    return SphericalInverse(robot, arm)


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
        self._jacobian = _Conditioning(robot)

    def all(self, pose: Floats, *, limits: bool = True) -> list[tuple[int, Floats]]:
        every = np.arange(self.branches)
        pose = np.broadcast_to(np.asarray(pose, dtype=float), (self.branches, 4, 4))
        q, margins, _ = self._solve(pose[:, :3, :3], pose[:, :3, 3], every)
        found = []
        for branch in every[margins.min(axis=1) > -EXACT]:
            if pose_error(self.robot, q[branch], pose[branch]) < EXACT:
                found += [(int(branch), turned) for turned in turns(self.robot, q[branch], limits=limits)]
        return found

    def along(
        self, rotation: Floats, origin: Floats, branch: int | Ints, seed: Floats | None = None
    ) -> Batch:
        rotation, origin = checked_path(self.robot, rotation, origin)
        labels = checked_branch(self, branch, len(origin))
        q, margins, wrist = self._solve(rotation, origin, labels)
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
        return Batch(q, ok, limit_margin(self.robot, q), margins.min(axis=1), wrist, reasons)

    def configuration(self, q: Floats) -> Ints:
        return posture(self.arm, np.atleast_2d(q)).branch()

    def singularity(self, q: Floats, *, jacobian: bool = True) -> dict[str, Floats]:
        q = np.atleast_2d(q)
        at = posture(self.arm, q)
        measures = {"wrist": abs(at.wrist), "elbow": abs(at.elbow), "shoulder": abs(at.ahead)}
        return {"jacobian": self._jacobian(q), **measures} if jacobian else measures

    def _solve(self, rotation: Floats, origin: Floats, branch: Ints) -> tuple[Floats, Floats, Floats]:
        signs = 1.0 - 2.0 * ((branch[:, None] >> np.array([2, 1, 0])) & 1)
        q, margins, wrist = self._kernel.run(rotation.reshape(-1, 9), origin, signs)
        return nearest_turn(q, np.zeros(self.robot.n)), margins, wrist[:, 0]


class _Conditioning:
    """Smallest singular value of the Jacobian, linear rows divided by half the reach."""

    def __init__(self, robot: Robot) -> None:
        q = ca.SX.sym("q", robot.n)
        rotation, origin = robot.flange_symbolic(q)
        self._kernel = Kernel(ca.Function("jacobian", [q], [ca.densify(ca.vec(geometric_jacobian(rotation, origin, q)))]))
        self._length = half_reach(robot)

    def __call__(self, q: Floats) -> Floats:
        (flat,) = self._kernel.run(np.ascontiguousarray(q, dtype=float))
        jacobian = flat.reshape(len(q), -1, 6)  # transposed: singular values are the same
        return np.linalg.svd(jacobian / np.r_[[self._length] * 3, 1, 1, 1], compute_uv=False)[:, -1]


def half_reach(robot: Robot) -> float:
    """Half the length of the chain, m: what translations are divided by to compare them with turns."""
    moves = np.linalg.norm(robot.before[1:, :3, 3], axis=1).sum() + np.linalg.norm(robot.after[:, :3, 3], axis=1).sum()
    return float(moves) / 2


def geometric_jacobian(rotation: ca.SX, origin: ca.SX, q: ca.SX) -> ca.SX:
    """(6, n) of a frame given as expressions of ``q``: linear rows first, base axes."""
    columns = []
    for k in range(q.numel()):
        spin = ca.mtimes(ca.reshape(ca.jacobian(ca.vec(rotation), q[k]), 3, 3), rotation.T)
        columns.append(ca.vertcat(ca.jacobian(origin, q[k]), spin[2, 1], spin[0, 2], spin[1, 0]))
    return ca.horzcat(*columns)


def pose_error(robot: Robot, q: Floats, pose: Floats) -> float:
    """The larger of the distances, m and rad, between the flange at ``q`` and a pose (4, 4)."""
    got = robot.pose(q)
    turn = got[:3, :3].T @ pose[:3, :3]
    spin = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = np.arctan2(np.linalg.norm(spin), np.trace(turn) - 1)
    return max(float(np.linalg.norm(got[:3, 3] - pose[:3, 3])), float(angle))


def limit_margin(robot: Robot, q: Floats) -> Floats:
    """(N, n) rad from the nearer joint limit; negative beyond it."""
    return np.minimum(q - robot.lower, robot.upper - q)


def nearest_turn(q: Floats, target: Floats) -> Floats:
    """``q`` moved by multiples of 2 pi to lie next to ``target``."""
    return q - TURN * np.round((q - target) / TURN)


def turns(robot: Robot, q: Floats, *, limits: bool) -> list[Floats]:
    """Every posture that differs from ``q`` (n,) by full turns and is within limits, in order."""
    if not limits:
        return [nearest_turn(q, np.zeros(robot.n))]
    choices = []
    for angle, low, high in zip(nearest_turn(q, np.zeros(robot.n)), robot.lower, robot.upper, strict=True):
        first, last = np.ceil((low - angle - _LIMIT) / TURN), np.floor((high - angle + _LIMIT) / TURN)
        whole = [0.0] if np.isinf(low) or np.isinf(high) else np.arange(first, last + 1)
        choices.append([angle + TURN * k for k in whole if low - _LIMIT <= angle + TURN * k <= high + _LIMIT])
    grid = np.meshgrid(*choices, indexing="ij")
    return list(np.stack([g.ravel() for g in grid], axis=1))


def continuous(robot: Robot, q: Floats, seed: Floats | None) -> Floats:
    """Choose the turns of raw angles (N, n) along a path; ``seed`` as in ``Inverse.along``."""
    if len(q) == 0:
        return q
    if seed is not None:
        seed = np.asarray(seed, dtype=float)
        if seed.shape == q.shape:
            return nearest_turn(q, seed)
        if seed.shape != (robot.n,) or not np.isfinite(seed).all():
            raise RobotError(f"seed has the shape {seed.shape}, expected ({robot.n},) or {q.shape}, and finite numbers")
    jumps = np.zeros_like(q)
    np.cumsum(np.round(np.diff(q, axis=0) / TURN), axis=0, out=jumps[1:])
    q = q - TURN * jumps
    if seed is not None:
        return q + (nearest_turn(q[0], seed) - q[0])
    # No start is given: the turn whose whole range of motion stands best between the limits.
    middle = np.where(np.isfinite(robot.lower + robot.upper), (robot.lower + robot.upper) / 2, 0.0)
    centre = (q.min(axis=0) + q.max(axis=0)) / 2
    return q + (nearest_turn(centre, middle) - centre)


def checked_path(robot: Robot, rotation: Floats, origin: Floats) -> tuple[Floats, Floats]:
    """The poses as contiguous arrays; refused when shapes are wrong or a number is not finite."""
    rotation, origin = np.ascontiguousarray(rotation, dtype=float), np.ascontiguousarray(origin, dtype=float)
    if origin.ndim != 2 or origin.shape[1] != 3 or rotation.shape != (len(origin), 3, 3):
        raise RobotError(f"poses are (N, 3, 3) and (N, 3), got {rotation.shape} and {origin.shape}")
    finite = np.isfinite(rotation).all(axis=(1, 2)) & np.isfinite(origin).all(axis=1)
    if not finite.all():
        raise RobotError(f"robot {robot.name}: pose {int(np.argmin(finite))} of the path is not finite")
    return rotation, origin


def checked_branch(inverse: Inverse, branch: int | Ints, count: int) -> Ints:
    """(count,) labels; refused when one does not exist."""
    labels = np.broadcast_to(np.asarray(branch), (count,)) if np.ndim(branch) == 0 else np.asarray(branch)
    if labels.shape != (count,) or not np.issubdtype(labels.dtype, np.integer):
        raise RobotError(f"branch is a whole number or ({count},) of them, got {branch!r}")
    if count and not (0 <= labels.min() and labels.max() < inverse.branches):
        raise RobotError(f"branch {labels.min()}..{labels.max()}: {inverse.robot.name} has 0..{inverse.branches - 1}")
    return labels.astype(np.int64)
