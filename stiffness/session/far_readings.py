"""Far readings: rows of a session so far from the rigid arm that no elasticity explains them, found before any fit."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.session.rigid_arm import placed, rigid_points
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

FARTHER = 0.05  # m from a rigid arm, beyond the others of its reflector: no elastic arm does that
APART = 20.0  # robust standard deviations of the distances of a reflector, where its robot is not that of the file
PLACINGS = 20  # re-weighted placements of a tracker
NEAR = 1e-3  # m: readings that are nearer than this count alike in a placement


def far_rows(session: Session) -> Bools:
    """(N,) readings far from the rigid arm and from the other readings of their reflector.

    Trackers are placed by least absolute distances, which a few wrong readings do not move, however wrong they are.
    """
    s = session.samples
    if session.numbers_each == 1:  # a length, a deviation: no position
        return np.zeros(len(s), dtype=bool)
    points = rigid_points(robot=session.robot, reflectors=session.reflectors, samples=s, q=s.q, scale=1.0)
    off = s.position - points
    for block in np.unique(s.block) if not session.registered else ():
        rows = s.block == block
        off[rows] = _placed_robustly(points[rows], s.position[rows]) - points[rows]
    distance = np.linalg.norm(off, axis=1)
    far = np.zeros(len(s), dtype=bool)
    for k in np.unique(s.reflector):
        rows = s.reflector == k
        middle = np.median(distance[rows])
        spread = 1.4826 * np.median(np.abs(distance[rows] - middle))  # of a normal distribution: one sd
        far[rows] = distance[rows] > middle + max(FARTHER, APART * float(spread))
    return far


def _placed_robustly(points: Floats, position: Floats) -> Floats:
    """As ``placed``, with the least sum of distances (iteratively re-weighted)."""
    seen = placed(points, position)
    for _ in range(PLACINGS):
        weight = 1 / np.maximum(np.linalg.norm(seen - points, axis=1), NEAR)
        seen = placed(points, position, weight)
    return seen
