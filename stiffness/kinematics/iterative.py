"""Inverse kinematics by Newton steps, for arms whose wrist axes do not meet in a point.

Every branch of one pose: ``posture_search``. Along a path: ``follower``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.kinematics.follower import Follower
from stiffness.kinematics.full_turns import continuous, limit_margin, nearest_turn, turns
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
from stiffness.kinematics.newton import Newton
from stiffness.kinematics.posture_search import SAME, PostureSearch
from stiffness.poses import Poses
from stiffness.robot.robot import Robot, placement

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class IterativeInverse(Inverse):
    """Newton steps; a branch is a posture's place among all of its pose, sorted by angle, joint 1 first.

    A label means the same configuration at one pose only: ``along`` starts at the posture nearest to the seed and
    uses the label only without one. Singular postures (a whole family reaches the pose) are not listed.
    """

    branches = 16  # a general arm of six rotary joints has at most 16 (Primrose 1986)

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._newton = Newton(robot)
        self._conditioning = Conditioning(robot)
        self._postures = PostureSearch(robot, self._newton, self._conditioning)

    def __reduce__(self) -> tuple[type[IterativeInverse], tuple[Robot]]:
        """Pickled as its robot: the stored postures of a search are megabytes that every process can draw itself."""
        return IterativeInverse, (self.robot,)

    def all(self, pose: Floats, *, limits: bool = True) -> list[tuple[int, Floats]]:
        found = self._postures.every(np.asarray(pose, dtype=float))
        return [(k, turned) for k, q in enumerate(found) for turned in turns(self.robot, q, limits=limits)]

    def along(self, poses: Poses, branch: int | Ints, seed: Floats | None = None) -> InverseSolution:
        path = checked_path(self.robot, poses)
        labels = checked_branch(self, branch, len(path))
        if seed is not None and np.ndim(seed) == 2:
            if np.shape(seed) != (len(path), self.robot.n):
                raise RobotError(f"seed has the shape {np.shape(seed)}, expected ({len(path)}, {self.robot.n})")
            q, error = self._newton.solve(path, np.array(seed, dtype=float))
            return self._solution(
                nearest_turn(q, np.asarray(seed)), error, "no posture found from the given one"
            )
        if not len(path):
            return self._solution(np.zeros((0, self.robot.n)), np.zeros((0, 2)), "")
        if seed is None and np.any(labels != labels[0]):
            raise RobotError(
                f"robot {self.robot.name}: one branch for the whole path, a branch is not labelled by pose"
            )
        start = self._start(placement(path.rotation[0], path.origin[0]), int(labels[0]), seed)
        if start is None:
            nothing = np.tile(np.zeros(self.robot.n) if seed is None else seed, (len(path), 1))
            return self._solution(
                nothing, np.full((len(path), 2), np.inf), "the first pose has no such posture"
            )
        q, error = Follower(self._newton, [path], np.zeros(1, dtype=np.int64)).follow(start[None])
        return self._solution(
            continuous(self.robot, q[0], seed), error[0], "out of reach, or beyond such a pose of the path"
        )

    def followed(self, paths: Sequence[Poses], which: Ints, start: Floats) -> tuple[Floats, Bools]:
        """Postures from many starts at once, each along one of several paths of N poses.

        Args:
            paths: which move alike, as a tool does that is turned about its axis: they share their knots.
            which: (S,) the path of each start. start: (S, n) rad, postures of its first pose.

        Returns:
            (S, N, n) rad, whole turns as they came out; (S, N) which poses are followed, all of them from the first on.
        """
        checked = [checked_path(self.robot, path) for path in paths]
        q, error = Follower(self._newton, checked, which).follow(start)
        return q, np.asarray(np.logical_and.accumulate(error.max(axis=2) < EXACT, axis=1))

    def reached(self, poses: Poses, *, thorough: bool = True) -> Bools:
        return self._postures.reached(checked_path(self.robot, poses), thorough=thorough)

    def configuration(self, q: Floats) -> Ints:
        labels = []
        for row in np.atleast_2d(q):
            found = self._postures.every(self.robot.pose(row))
            apart = [np.abs(nearest_turn(row - other, np.zeros(self.robot.n))).max() for other in found]
            if not apart or min(apart) > 1e3 * SAME:
                raise RobotError(
                    f"robot {self.robot.name}: {np.degrees(row).round(3)} deg is singular: it has no branch"
                )
            labels.append(int(np.argmin(apart)))
        return np.array(labels, dtype=np.int64)

    def singularity(self, q: Floats, *, jacobian: bool = True) -> dict[str, Floats]:
        return {"jacobian": self._conditioning(np.atleast_2d(q))} if jacobian else {}

    def _solution(self, q: Floats, error: Floats, reason: str) -> InverseSolution:
        solved = error.max(axis=1, initial=0.0) < EXACT
        singular = self._conditioning(q) <= SINGULAR
        reasons = {reason: ~solved, "singular": solved & singular}
        reach = np.where(solved, 0.0, -error[:, 0])
        return InverseSolution(
            q=q,
            ok=solved & ~singular,
            limit_margin=limit_margin(self.robot, q),
            reach=reach,
            wrist=self._wrist(q),
            reasons=reasons,
        )

    def _wrist(self, q: Floats) -> Floats:
        """|sin| of the angle between axes 4 and 6."""
        _, jacobian = self._newton.evaluate(q)
        return np.asarray(np.linalg.norm(np.cross(jacobian[:, 3:, 3], jacobian[:, 3:, 5]), axis=1))

    def _start(self, pose: Floats, branch: int, seed: Floats | None) -> Floats | None:
        if seed is not None and seed.ndim == 1 and pose_error(self.robot, seed, pose) < EXACT:
            return np.asarray(seed)
        found = self._postures.every(pose)
        if seed is not None:
            apart = [float(np.abs(nearest_turn(q, seed) - seed).max()) for q in found]
            return nearest_turn(found[int(np.argmin(apart))], np.asarray(seed)) if found else None
        return found[branch] if branch < len(found) else None
