"""Postures of a placement: every turn and arm configuration along the path, and which of them an arm can take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.free_turn import about_z
from compensator.path.motion_bounds import MotionBounds
from compensator.path.tcp_inverse import TcpInverse
from compensator.place.choices import choices
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
        reached: (C,) share of the poses within reach; of arms without a closed form of those that follow the first.
        reachable: False if the reach alone forbids all of them.
        within: (C,) all poses within the limits.
        margin: (C,) the smallest, as ``MotionBounds.margin``.
        rotation: (C, P, 3, 3) of the TCP in the base; origin: (P, 3) m.
    """

    q: Floats
    turn: Floats
    branch: npt.NDArray[np.int64]
    reached: Floats
    reachable: bool
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
    robot, poses, at = inverse.robot, len(study.path), workobject.then(study.tcp)
    rotation = at.rotation[None] @ about_z(study.turns)[:, None]  # (T, P, 3, 3)
    found = choices(study.path, inverse, [Frame(one, at.origin) for one in rotation])
    q, within = _in_limits(robot, _without_jumps(np.where(found.ok[..., None], found.q, _middle(robot))))
    margin = np.full(len(q), -np.inf)
    good = np.flatnonzero(found.ok.all(axis=1) & within)
    if len(good):
        margin[good] = bounds.margin(q[good].reshape(-1, robot.n)).reshape(len(good), poses).min(axis=1)
    return PlacedPostures(
        q=q, turn=study.turns[found.turn], branch=found.branch, reached=found.ok.mean(axis=1),
        reachable=found.reachable, within=within, margin=margin, rotation=rotation[found.turn], origin=at.origin,
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
