"""PostureSearch: all postures that reach one flange pose, for arms without a closed form.

Newton steps start from stored postures that nearly reach the pose. Turning the first or the last joint does not
change where the last axis stands relative to the first: a posture is looked up by that placement alone (four degrees
of freedom, five numbers), and the two joints are then set to match the pose.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from stiffness.kinematics.full_turns import TURN, fits_limits, nearest_turn
from stiffness.kinematics.inverse import EXACT
from stiffness.kinematics.jacobian import Conditioning
from stiffness.kinematics.newton import Newton
from stiffness.poses import PoseArray, Poses
from stiffness.robot.robot import Robot
from stiffness.rotation import antisymmetric

Floats = npt.NDArray[np.float64]

SAME = 1e-5  # rad: two solutions nearer than this are one
_STORED = 40_000  # postures in the table
_ROUND = 256  # of them per round; a round that finds no new branch is the last
_ROUNDS = 8
_TRIES = (16, 256)  # nearest stored postures that ``reached`` starts from, at first and where it has to be sure
_AT_A_TIME = 16_384  # starts of one batch
_LATELY = 256  # poses whose postures are remembered: a path that is planned asks for some of them again and again
_REGULAR = 1e-6  # smallest singular value; below it a whole family takes up the pose


class PostureSearch:
    """All regular postures of poses of one robot."""

    def __init__(self, robot: Robot, newton: Newton, conditioning: Conditioning) -> None:
        self._robot, self._newton, self._conditioning = robot, newton, conditioning
        self._lately: dict[bytes, list[Floats]] = {}

    def every(self, pose: Floats) -> list[Floats]:
        """Every regular posture (n,) of a pose, angles within +-pi, sorted; poses asked for lately are remembered."""
        key = pose.tobytes()
        if key not in self._lately:
            while len(self._lately) >= _LATELY:
                self._lately.pop(next(iter(self._lately)))
            self._lately[key] = self._every(pose)
        return list(self._lately[key])

    def reached(self, poses: PoseArray, *, thorough: bool) -> npt.NDArray[np.bool_]:
        """(N,) whether a posture within the joint limits was found; ``thorough``: after more tries."""
        found = np.zeros(len(poses), dtype=np.bool_)
        centre, farthest = self._outermost
        near = np.linalg.norm(poses.origin - centre, axis=1) <= farthest
        for tries in _TRIES[: 2 if thorough else 1]:
            left = np.flatnonzero(near & ~found)
            per = max(1, _AT_A_TIME // tries)
            for rows in (left[k : k + per] for k in range(0, len(left), per)):
                seeds = self._nearest_stored(poses.take(rows), tries).reshape(-1, self._robot.n)
                q, error = self._newton.solve(poses.take(np.repeat(rows, tries)), seeds)
                good = (error.max(axis=1) < EXACT) & fits_limits(self._robot, q)
                found[rows] = good.reshape(len(rows), tries).any(axis=1)
        return found

    def _every(self, pose: Floats) -> list[Floats]:
        centre, farthest = self._outermost
        if np.linalg.norm(pose[:3, 3] - centre) > farthest:
            return []
        order = self._nearest_stored(PoseArray(pose[None, :3, :3], pose[None, :3, 3]), _ROUND * _ROUNDS)[0]
        found: list[Floats] = []
        for k in range(_ROUNDS):
            before = len(found)
            self._gather(pose, order[k * _ROUND : (k + 1) * _ROUND], found)
            if len(found) == before and k > 0:
                break
        return sorted(found, key=lambda q: [round(float(v), 6) for v in q])

    def _gather(self, pose: Floats, seeds: Floats, found: list[Floats]) -> None:
        count = len(seeds)
        target = np.broadcast_to(pose, (count, 4, 4))
        q, error = self._newton.solve(PoseArray(target[:, :3, :3], target[:, :3, 3]), seeds)
        q = nearest_turn(q, np.zeros(self._robot.n))
        regular = (error.max(axis=1) < EXACT) & (self._conditioning(q) > _REGULAR)
        for posture in q[regular]:
            if all(
                np.abs(nearest_turn(posture - other, np.zeros(self._robot.n))).max() > SAME for other in found
            ):
                found.append(np.where(posture <= -np.pi + SAME, posture + TURN, posture))

    def _nearest_stored(self, poses: PoseArray, count: int) -> Floats:
        """Stored postures (N, count, n), the nearest first; joints 1 and n are set to match the pose."""
        key, heading = self._placement(poses)
        _, order = self._tree.query(key, k=count)
        q = self._stored[0][order.reshape(-1)]
        q[:, 0] += np.repeat(heading, count) - self._placement(self._newton.evaluate(q)[0])[1]
        at, _ = self._newton.evaluate(q)
        # What is left is mostly a turn about the last axis.
        left, axis = at.rotation.swapaxes(1, 2) @ np.repeat(poses.rotation, count, axis=0), self._last_axis
        q[:, -1] += np.arctan2(
            antisymmetric(left) @ axis, np.trace(left, axis1=1, axis2=2) - np.einsum("i,nij,j->n", axis, left, axis)
        )
        return np.asarray(q.reshape(len(poses), count, -1))

    @cached_property
    def _tree(self) -> Any:
        """The keys of the stored postures, for a search by distance."""
        from scipy.spatial import cKDTree  # arms with a closed form never need it

        return cKDTree(self._stored[1])

    @cached_property
    def _outermost(self) -> tuple[Floats, float]:
        """(3,) m the point of axis 1 beside joint 2, and how far from it a flange can be: all links in one line, m."""
        robot = self._robot
        links = [robot.after[k] @ robot.before[k + 1] for k in range(robot.n - 1)] + [robot.after[-1]]
        first, second = robot.before[0], links[0][:3, 3]
        along = robot.axis[0] * float(robot.axis[0] @ second)
        length = float(np.linalg.norm(second - along)) + sum(float(np.linalg.norm(m[:3, 3])) for m in links[1:])
        return first[:3, :3] @ along + first[:3, 3], length * (1.0 + EXACT)

    @property
    def _last_axis(self) -> Floats:
        """Unit vector of the last joint in the flange frame."""
        return np.asarray(self._robot.after[-1][:3, :3].T @ self._robot.axis[-1])

    def _placement(self, flange: Poses) -> tuple[Floats, Floats]:
        """Axis n against axis 1: a key (N, 5) that turns about either leave alone, and the heading (N,)."""
        rotation, origin = flange.rotation, flange.origin
        first = self._robot.before[0]
        frame = first[:3, :3] @ _frame_about(self._robot.axis[0])
        back = np.linalg.inv(self._robot.after[-1])[:3, 3]  # joint n in the flange frame
        at = (origin + np.einsum("nij,j->ni", rotation, back) - first[:3, 3]) @ frame
        along = np.einsum("nij,j->ni", rotation, self._last_axis) @ frame
        # The heading is that of joint n about axis 1, or of its axis where the joint stands on axis 1.
        radius = np.hypot(at[:, 0], at[:, 1])
        flat = np.where((radius > 1e-6)[:, None], at, along)
        heading = np.arctan2(flat[:, 1], flat[:, 0])
        c, s = np.cos(heading), np.sin(heading)
        key = [at[:, 2] / self._newton.length, radius / self._newton.length]
        key += [along[:, 2], c * along[:, 0] + s * along[:, 1], c * along[:, 1] - s * along[:, 0]]
        return np.stack(key, axis=1), heading

    @cached_property
    def _stored(self) -> tuple[Floats, Floats]:
        """Random postures (M, n) and their keys."""
        q = np.random.default_rng(20).uniform(-np.pi, np.pi, (_STORED, self._robot.n))
        q[:, 0] = q[:, -1] = 0.0
        return q, self._placement(self._newton.evaluate(q)[0])[0]


def _frame_about(axis: Floats) -> Floats:
    """(3, 3) rotation whose third column is the axis."""
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(other, axis)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])
