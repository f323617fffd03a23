"""Path walk: one pair of bodies along a path, in steps that the motion of the farthest point bounds.

After a look that finds a clearance d, nothing can touch before the farthest point has moved d: the next look is there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from compensator.scene.body import BASE, TOOL, WORKOBJECT, WORLD, Body
from compensator.scene.collider import Collider
from compensator.scene.motion_bound import motion_along
from compensator.scene.pairs import Pair
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

MOST_CONTACTS = 200  # looks in contact, after which a pair is left: it is refused anyway
WORST = 3  # places of a pair that are measured


@dataclass(frozen=True, repr=False, eq=False)
class ArmPath:
    """Where the arm goes.

    Attributes:
        q: (N, n) rad. workobject: in the base. moving: carrier -> (N) frames, of those that move beside the arm.
    """

    q: Floats
    workobject: Frame
    moving: Mapping[str, Frame] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.q)

    @property
    def table_turns(self) -> bool:
        """Whether the part turns on the way."""
        part = self.moving.get(WORKOBJECT)
        return part is not None and part.rotation.ndim > 2 and bool(np.ptp(part.rotation, axis=0).any())


@dataclass(frozen=True)
class Approach:
    """How near a pair comes.

    Attributes:
        pair: which. looks: how often it was looked at.
        contacts: poses (the move that ends there) with a contact, ascending. near: those within the margin without one.
        worst: (lower bound of the distance, m, and place on the path) where it is smallest.
        least: (distance in m, pose) at the worst place that was measured; None: none was.
    """

    pair: Pair
    looks: int
    contacts: tuple[int, ...]
    near: tuple[int, ...]
    worst: tuple[tuple[float, float], ...]
    least: tuple[float, int] | None = None

    @property
    def bound(self) -> float:
        """m: nowhere is the pair nearer than this, where it does not touch."""
        return self.worst[0][0] if self.worst else np.inf


class PathWalk:
    """Looks along one path.

    Args:
        margin, step: m; within the margin the farthest point moves a step between two looks.
    """

    def __init__(self, collider: Collider, path: ArmPath, *, margin: float, step: float) -> None:
        self.collider, self.path, self.margin, self.step = collider, path, margin, step
        self._model, self._data, _ = collider.robot._pinocchio
        self._stands = [_stand(body, collider.robot, path) for body in collider.bodies]

    def approach(self, pair: Pair, active: Bools) -> Approach:
        """Go along the path with one pair.

        Args:
            active: (N,) moves, by the pose they end at, on which the pair counts.
        """
        bodies, path = self.collider.bodies, self.path
        way = motion_along(self.collider.robot, bodies, pair, q=path.q, moving=path.moving)
        margin, last = self.margin if pair.margin else 0.0, len(self.path) - 1
        contacts, near, seen = list[int](), list[int](), list[tuple[float, float]]()
        at, looks, touched = _next_active(0.0, active), 0, 0
        while at is not None and touched < MOST_CONTACTS:
            inner, outer = self._places(pair, at)
            hit, clear = self.collider.look(pair, inner, outer)
            pose, looks = _move(at), looks + 1
            if hit:
                touched += 1
                contacts.append(pose)
            elif clear < margin and self.collider.look(pair, inner, outer, margin)[0]:
                near.append(pose)
            seen.append((0.0 if hit else clear, at))
            if at >= last:
                break
            ahead = 0.0 if hit else clear if clear < margin else clear - margin
            at = _next_active(_further(way, at, max(self.step, ahead)), active)
        return Approach(pair, looks, contacts=_once(contacts), near=_once(near), worst=tuple(sorted(seen)[:WORST]))

    def measured(self, approach: Approach) -> Approach:
        """With the distance at its worst places, where it does not touch."""
        if approach.contacts or not approach.worst:
            return approach
        pair = approach.pair
        found = [(self.collider.distance(pair, *self._places(pair, at)), _move(at)) for _, at in approach.worst]
        return replace(approach, least=min(found))

    def _places(self, pair: Pair, at: float) -> tuple[Frame, Frame]:
        last = len(self.path.q) - 1
        begin = min(int(at), last)
        end, share = min(begin + 1, last), at - begin
        q = self.path.q[begin] + share * (self.path.q[end] - self.path.q[begin])
        pin.forwardKinematics(self._model, self._data, q)
        return self._place(pair.inner, begin, end, share), self._place(pair.outer, begin, end, share)

    def _place(self, index: int, begin: int, end: int, share: float) -> Frame:
        stand = self._stands[index]
        if stand.moving is not None:
            return _between(stand.moving, begin, end, share).then(stand.there)
        if stand.link is None:
            return stand.there
        link, behind = stand.link
        pose = self._data.oMi[link]
        rotation, origin = _then(pose.rotation, pose.translation, behind)
        return Frame(*_then(rotation, origin, stand.there))


@dataclass(frozen=True, eq=False)
class _Stand:
    """What carries a body: a ``link`` (1 is what joint 1 turns) and its frame behind the joint, a ``moving`` frame, or
    nothing that moves; and where the body is ``there``."""

    there: Frame
    link: tuple[int, Frame] | None = None
    moving: Frame | None = None


def _stand(body: Body, robot: Robot, path: ArmPath) -> _Stand:
    carrier = body.carrier
    if isinstance(carrier, str) and carrier in path.moving:
        return _Stand(body.placement, moving=path.moving[carrier])
    if carrier == WORKOBJECT:
        return _Stand(path.workobject.then(body.placement))
    if carrier in (WORLD, BASE):
        return _Stand(body.placement)
    link = robot.n if carrier == TOOL else int(carrier)
    return _Stand(body.placement, link=(link, Frame.of(robot.after[link - 1])))


def _then(rotation: Floats, origin: Floats, inner: Frame) -> tuple[Floats, Floats]:
    """``Frame.then`` of one frame, in a third of its time: a path is looked at ten thousand times."""
    return rotation @ inner.rotation, inner.origin @ rotation.T + origin


def _move(at: float) -> int:
    """The pose that the move ends at which a place is on."""
    return int(np.ceil(at - 1e-12))


def _once(poses: list[int]) -> tuple[int, ...]:
    return tuple(dict.fromkeys(poses))


def _further(way: Floats, at: float, distance: float) -> float:
    """The place on the path (in poses) where the farthest point has moved ``distance`` (m) from ``at``."""
    last = len(way) - 1
    begin = int(at)
    here = way[begin] + (at - begin) * (way[min(begin + 1, last)] - way[begin])
    k = int(way.searchsorted(here + distance, side="right"))
    if k > last:
        return float(last)
    gone = here + distance - way[k - 1]
    return k - 1 + float(gone / (way[k] - way[k - 1]))


def _next_active(at: float, active: Bools) -> float | None:
    """``at``, or the begin of the next move that counts; None: there is none."""
    move = _move(at)
    if active[move]:
        return at
    k = int(np.argmax(active[move:]))
    if not active[move + k]:
        return None
    return float(max(move + k - 1, 0))


def _between(frames: Frame, begin: int, end: int, share: float) -> Frame:
    """Between two of N frames, the origin straight and the rotation about one axis."""
    a, b = frames.rotation[begin], frames.rotation[end]
    rotation = a if share == 0.0 else a @ pin.exp3(share * pin.log3(a.T @ b))
    return Frame(rotation, frames.origin[begin] + share * (frames.origin[end] - frames.origin[begin]))
