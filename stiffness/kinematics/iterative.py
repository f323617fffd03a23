"""Inverse kinematics by Newton steps, for arms whose wrist axes do not meet in a point.

Every branch of one pose: ``posture_search``. Along a path: knots one after the other, each started from the one
before, then all poses between them at once, each started from the knots around it.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
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
from stiffness.kinematics.waypoints import densified, knots_of
from stiffness.poses import PoseArray, Poses
from stiffness.robot.robot import Robot, placement

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_SLIP = 0.3  # rad: a solution farther than this from its prediction may be on another branch


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
        q, error = self._follow(path, start)
        return self._solution(
            continuous(self.robot, q, seed), error, "out of reach, or beyond such a pose of the path"
        )

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

    def _follow(self, path: Poses, start: Floats) -> tuple[Floats, Floats]:
        """Angles (N, n) and what is left (N, 2), infinite from the first pose that does not follow."""
        dense, rows = densified(path)
        q = np.empty((len(dense), self.robot.n))
        error = np.full((len(dense), 2), np.inf)
        q[0] = start
        reached = self._reach_knots(dense, q, knots_of(dense))
        last = reached[-1]
        q[last:] = q[last]
        between = np.arange(last + 1)
        guess = np.stack([np.interp(between, reached, q[reached, j]) for j in range(self.robot.n)], axis=1)
        solved, error[: last + 1] = self._newton.solve(dense.take(slice(last + 1)), guess)
        slipped = np.abs(solved - guess).max(axis=1) > _SLIP
        error[: last + 1][slipped] = np.inf
        q[: last + 1] = solved
        return q[rows], error[rows]

    def _reach_knots(self, path: PoseArray, q: Floats, knots: Ints) -> list[int]:
        """Fill in ``q`` at the knots, as far as one follows from the other; the rows that were filled in."""
        reached = [0]
        for a, b in pairwise(knots.tolist()):
            got = self._step(path, q[a], a, b)
            if got is not None:
                q[b] = got
                reached.append(b)
                continue
            for k in range(a + 1, b + 1):  # to the very pose where it ends
                got = self._step(path, q[k - 1], k - 1, k)
                if got is None:
                    break
                q[k] = got
                reached.append(k)
            break
        return reached

    def _step(self, path: PoseArray, q: Floats, a: int, b: int) -> Floats | None:
        """Angles at pose b from those at pose a; by way of the pose half-way when the step is too long."""
        got, error = self._newton.solve(path.take(slice(b, b + 1)), q[None])
        if error.max() < EXACT and np.abs(got[0] - q).max() < _SLIP:
            return np.asarray(got[0])
        if b - a < 2:
            # Near a singularity a joint may well turn far between neighbours: the caller has its own bounds.
            near = error.max() < EXACT and np.abs(got[0] - q).max() < np.pi / 2
            return np.asarray(got[0]) if near else None
        middle = self._step(path, q, a, (a + b) // 2)
        return None if middle is None else self._step(path, middle, (a + b) // 2, b)
