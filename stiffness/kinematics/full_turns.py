"""Full turns: the multiple of 2 pi that is added to a joint angle, within limits and along a path."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]

TURN = 2 * np.pi
_LIMIT = 1e-9  # rad: a posture this little beyond a limit is on the limit


def limit_margin(robot: Robot, q: Floats) -> Floats:
    """(N, n) rad from the nearer joint limit; negative beyond it."""
    below = q - robot.lower
    return np.asarray(np.minimum(below, robot.upper - q, out=below))


def nearest_turn(q: Floats, target: Floats) -> Floats:
    """``q`` moved by multiples of 2 pi to lie next to ``target``."""
    return q - TURN * np.round((q - target) / TURN)


def fits_limits(robot: Robot, q: Floats) -> npt.NDArray[np.bool_]:
    """(...,) whether postures (..., n) are within the limits at some turn of each joint."""
    low, high = robot.lower - _LIMIT, robot.upper + _LIMIT
    with np.errstate(invalid="ignore"):
        least = np.where(np.isfinite(low), q + TURN * np.ceil((low - q) / TURN), q)
    return np.asarray(((least <= high) | ~np.isfinite(low + high)).all(axis=-1))


def turns(robot: Robot, q: Floats, *, limits: bool) -> list[Floats]:
    """Every posture that differs from ``q`` (n,) by full turns and is within limits, in order."""
    if not limits:
        return [nearest_turn(q, np.zeros(robot.n))]
    choices = []
    for angle, low, high in zip(nearest_turn(q, np.zeros(robot.n)), robot.lower, robot.upper, strict=True):
        first, last = np.ceil((low - angle - _LIMIT) / TURN), np.floor((high - angle + _LIMIT) / TURN)
        whole = [0.0] if np.isinf(low) or np.isinf(high) else np.arange(first, last + 1)
        within = [angle + TURN * k for k in whole if low - _LIMIT <= angle + TURN * k <= high + _LIMIT]
        choices.append(np.clip(within, low, high))
    grid = np.meshgrid(*choices, indexing="ij")
    return list(np.stack([g.ravel() for g in grid], axis=1))


def continuous(robot: Robot, q: Floats, seed: Floats | None) -> Floats:
    """Choose the turns of raw angles (N, n) along a path; ``seed`` as in ``Inverse.along``."""
    if len(q) == 0:
        return q
    if seed is not None:
        seed = np.asarray(seed, dtype=float)
        if seed.shape not in ((robot.n,), q.shape) or not np.isfinite(seed).all():
            raise RobotError(f"seed {seed.shape}: expected ({robot.n},) or {q.shape}, and finite numbers")
        if seed.shape == q.shape:
            return nearest_turn(q, seed)
    raw, q = q, np.empty_like(q)
    for one, joint in zip(raw.T, q.T, strict=True):  # joint by joint: memory stays small
        joint[0] = one[0]
        joint[1:] = one[1:] - TURN * np.cumsum(np.round(np.diff(one) / TURN))
    if seed is not None:
        q += nearest_turn(q[0], seed) - q[0]
        return q
    # No start is given: the turn whose whole range of motion stands best between the limits.
    middle = np.where(np.isfinite(robot.lower + robot.upper), (robot.lower + robot.upper) / 2, 0.0)
    centre = (q.min(axis=0) + q.max(axis=0)) / 2
    q += nearest_turn(centre, middle) - centre
    return q
