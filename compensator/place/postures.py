"""Postures of a placement: every turn and arm configuration along the path, and which of them an arm can take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.free_turn import about_z
from compensator.path.motion_bounds import MotionBounds
from compensator.path.tcp_inverse import TcpInverse
from compensator.place.study import Study
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
FULL = 2 * np.pi
MOST_TURNS = np.arange(-2, 3)  # whole turns of a joint that are tried


@dataclass(frozen=True, repr=False, eq=False)
class PlacedPostures:
    """C choices: a turn and a configuration each.

    Attributes:
        q: (C, P, n) rad, without jumps, within the limits where they can be.
        turn: (C,) rad; branch: (C,).
        reached: (C,) share of the poses within reach. within: (C,) all poses within the limits.
        margin: (C,) the smallest, as ``MotionBounds.margin``.
        rotation: (C, P, 3, 3) of the TCP in the base; origin: (P, 3) m.
    """

    q: Floats
    turn: Floats
    branch: npt.NDArray[np.int64]
    reached: Floats
    within: Bools
    margin: Floats
    rotation: Floats
    origin: Floats

    @property
    def usable(self) -> npt.NDArray[np.intp]:
        """Choices that the arm can take."""
        return np.flatnonzero((self.reached == 1.0) & self.within & (self.margin >= 0.0))


def placed_postures(study: Study, inverse: TcpInverse, bounds: MotionBounds, workobject: Frame) -> PlacedPostures:
    """All choices at one placement."""
    robot, poses, branches = inverse.robot, len(study.path), inverse.inverse.branches
    at = workobject.then(study.tcp)
    rotation = at.rotation[None] @ about_z(study.turns)[:, None]  # (T, P, 3, 3)
    count = branches * len(study.turns)
    turned = np.tile(rotation, (branches, 1, 1, 1))
    label = np.repeat(np.arange(branches), len(study.turns))
    rows = np.tile(np.arange(poses), count)
    tcp = Frame(turned.reshape(-1, 3, 3), np.tile(at.origin, (count, 1)))
    middle = np.broadcast_to(_middle(robot), (len(rows), robot.n))
    found = inverse.along(study.path.take(rows), tcp, np.repeat(label, poses), middle)
    ok = found.ok.reshape(count, poses)
    q = _without_jumps(np.where(found.ok[:, None], found.q, middle).reshape(count, poses, robot.n))
    q, within = _in_limits(robot, q)
    margin = np.full(count, -np.inf)
    good = np.flatnonzero(ok.all(axis=1) & within)
    if len(good):
        margin[good] = bounds.margin(q[good].reshape(-1, robot.n)).reshape(len(good), poses).min(axis=1)
    return PlacedPostures(
        q=q, turn=np.tile(study.turns, branches), branch=label, reached=ok.mean(axis=1), within=within, margin=margin,
        rotation=turned, origin=at.origin,
    )  # fmt: skip


def _middle(robot: Robot) -> Floats:
    """(n,) rad, of the limits; 0 where there are none."""
    sum_ = np.where(np.isfinite(robot.lower + robot.upper), robot.lower + robot.upper, 0.0)
    return np.asarray(0.5 * sum_)


def _without_jumps(q: Floats) -> Floats:
    """(C, P, n) with each pose at the whole turn nearest to the one before."""
    jumps = np.zeros_like(q)
    np.cumsum(np.round(np.diff(q, axis=1) / FULL), axis=1, out=jumps[:, 1:])
    return np.asarray(q - FULL * jumps)


def _in_limits(robot: Robot, q: Floats) -> tuple[Floats, Bools]:
    """(C, P, n) with whole joints turned so that they stand best between their limits; (C,) whether all fit."""
    low, high = q.min(axis=1)[..., None] + FULL * MOST_TURNS, q.max(axis=1)[..., None] + FULL * MOST_TURNS
    room = np.minimum(low - robot.lower[:, None], robot.upper[:, None] - high)  # (C, n, turns)
    room = np.where(np.isfinite(room), room, -np.abs(MOST_TURNS))  # without limits: as it is
    best = room.argmax(axis=2)
    free = ~np.isfinite(robot.lower + robot.upper)
    within = (room.max(axis=2) >= 0.0) | free
    return q + FULL * MOST_TURNS[best][:, None], within.all(axis=1)
