"""Follower: postures along paths by Newton steps, each from the posture before; many starts side by side.

Knots one after the other, each started from the one before, then all poses between them at once, each started from
the knots around it. Where a step is too long it goes by way of the pose half-way.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stiffness.kinematics.inverse import EXACT
from stiffness.kinematics.newton import Newton
from stiffness.kinematics.waypoints import densified, inserted, knots_of, shares
from stiffness.poses import PoseArray, Poses

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Rows = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

_SLIP = 0.3  # rad: a solution farther than this from its prediction may be on another branch


class Follower:
    """Follows S starts, each along one of several paths of N poses, over the same knots.

    Args:
        paths: of N flange poses each, which move alike. which: (S,) the path of each start.
    """

    def __init__(self, newton: Newton, paths: Sequence[Poses], which: Ints) -> None:
        self._newton, self._which = newton, which
        parts = np.max([inserted(path) for path in paths], axis=0)
        dense = [densified(path, parts) for path in paths]
        self._rows = dense[0][1]
        self._rotation = _stacked([d.rotation for d, _ in dense])  # (paths, D, 3, 3)
        self._origin = _stacked([d.origin for d, _ in dense])
        self._knots = knots_of(np.max([shares(d) for d, _ in dense], axis=0))

    def __repr__(self) -> str:
        return f"Follower({len(self._which)} starts, {len(self._rows)} poses)"

    def follow(self, start: Floats) -> tuple[Floats, Floats]:
        """Angles (S, N, n) from starts (S, n), and what is left (S, N, 2), m and rad, infinite from the first pose that
        does not follow."""
        count, poses = len(start), self._origin.shape[1]
        q, reached = np.empty((count, poses, start.shape[1])), np.zeros((count, poses), dtype=np.bool_)
        q[:, 0], reached[:, 0] = start, True
        self._reach_knots(q, reached)
        at = [np.flatnonzero(r) for r in reached]
        last = np.array([a[-1] for a in at], dtype=np.intp)
        guess = np.empty_like(q)
        for s, knots in enumerate(at):
            for j in range(q.shape[2]):  # stays at the last one that was reached
                guess[s, :, j] = np.interp(np.arange(poses), knots, q[s, knots, j])
        before = np.arange(poses) <= last[:, None]
        rows, at_pose = np.nonzero(before)
        solved, left = self._newton.solve(self._poses(rows, at_pose), guess[rows, at_pose])
        left[np.abs(solved - guess[rows, at_pose]).max(axis=1) > _SLIP] = np.inf
        error, q = np.full((count, poses, 2), np.inf), guess
        q[rows, at_pose], error[rows, at_pose] = solved, left
        return q[:, self._rows], error[:, self._rows]

    def _poses(self, starts: Rows, at: Rows | int) -> PoseArray:
        """(K) where starts (K,) are to be at their poses ``at``."""
        path = self._which[starts]
        return PoseArray(self._rotation[path, at], self._origin[path, at])

    def _reach_knots(self, q: Floats, reached: Bools) -> None:
        """Fill in ``q`` at the knots as far as one follows from the other; ``reached``: what was filled in."""
        going = np.arange(len(q))
        for a, b in pairwise(self._knots.tolist()):
            if not len(going):
                return
            got, ok = self._step(going, q[going, a], a, b)
            ends, going = going[~ok], going[ok]
            q[going, b], reached[going, b] = got[ok], True
            for k in range(a + 1, b + 1):  # to the very pose where it ends
                if not len(ends):
                    break
                got, ok = self._step(ends, q[ends, k - 1], k - 1, k)
                ends = ends[ok]
                q[ends, k], reached[ends, k] = got[ok], True

    def _step(self, starts: Rows, q: Floats, a: int, b: int) -> tuple[Floats, Bools]:
        """Angles (K, n) at pose b from those at pose a, by way of the pose half-way where that is too long a step;
        (K,) which are there."""
        got, error = self._newton.solve(self._poses(starts, b), q)
        solved, way = error.max(axis=1) < EXACT, np.abs(got - q).max(axis=1)
        if b - a < 2:
            # Near a singularity a joint may well turn far between neighbours: the caller has its own bounds.
            return got, solved & (way < np.pi / 2)
        ok = solved & (way < _SLIP)
        left = np.flatnonzero(~ok)
        if len(left):
            middle, half = self._step(starts[left], q[left], a, (a + b) // 2)
            left = left[half]
            if len(left):
                got[left], ok[left] = self._step(starts[left], middle[half], (a + b) // 2, b)
        return got, ok


def _stacked(arrays: Sequence[Floats]) -> Floats:
    """One array of all; of a single one no copy: it may be a million poses."""
    return arrays[0][None] if len(arrays) == 1 else np.stack(arrays)
