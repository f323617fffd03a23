"""Collider: which postures of an arm collide, for any number of postures at once.

Spheres that cover one body against a box that holds the other give a lower bound of their distance for all postures in
a few array operations; only what these leave open is looked at by coal (Pan, Chitta, Manocha, FCL: A general purpose
library for collision and proximity queries, ICRA 2012; coal is its successor).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.scene.body import Body
from compensator.scene.carrier_frames import STILL, CarrierFrames, link_frames
from compensator.scene.coal_shape import Standing, apart, coal_place, coal_shape, looked
from compensator.scene.pairs import Pair
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

BLOCK = 4096  # postures at once


class Collider:
    """The bodies around and on one arm, ready to be asked; it does not change.

    Args:
        bodies: all; pairs: those of them that are looked at.
    """

    def __init__(self, robot: Robot, bodies: Sequence[Body], pairs: Sequence[Pair]) -> None:
        self.robot, self.bodies, self.pairs = robot, tuple(bodies), tuple(pairs)

    def __repr__(self) -> str:
        return f"Collider({self.robot.name}, {len(self.bodies)} bodies, {len(self.pairs)} pairs)"

    @cached_property
    def shapes(self) -> tuple[Any, ...]:
        """What coal makes of every body."""
        return tuple(coal_shape(b.shape) for b in self.bodies)

    def collides(
        self,
        q: Floats,
        *,
        workobject: Frame,
        world: Frame = STILL,
        tool: int | None = None,
        cutting: bool = True,
        margin: float = 0.0,
    ) -> Bools:
        """(N,) whether something touches at joint angles ``q`` (N, n) rad.

        Args:
            workobject: in the base, one or (N); world: of the floor, one or (N) where a rail moves the base.
            tool: number of the tool that is on; None: tools that hold for every number.
            cutting: the cutter may be in what is sacrificial.
            margin: m, as near as this counts as touching.
        """
        out = np.zeros(len(q), dtype=np.bool_)
        active = self._active(tool, cutting)
        for begin in range(0, len(q), BLOCK):
            rows = slice(begin, begin + BLOCK)
            frames = CarrierFrames(link_frames(self.robot, q[rows]), _some(workobject, rows), _some(world, rows))
            out[rows] = self._block(frames, active, len(q[rows]), margin)
        return out

    def first_touching(
        self, q: Floats, *, workobject: Frame, world: Frame = STILL, tool: int | None = None, cutting: bool = True
    ) -> tuple[str, str] | None:
        """Names of two bodies that touch at one of N postures (N, n) rad, the one on the arm first; None: none do.

        Args:
            workobject, world, tool, cutting: as in ``collides``.
        """
        if not len(q):
            return None
        frames = CarrierFrames(link_frames(self.robot, q), workobject, world)
        for pair in self._active(tool, cutting):
            inner, outer = (frames.of(self.bodies[k]) for k in (pair.inner, pair.outer))
            near = np.flatnonzero(self.bound(pair, inner, outer, len(q)) <= 0.0)
            if any(self.touch(pair, _one(inner, k), _one(outer, k)) for k in near.tolist()):
                return self.bodies[pair.outer].name, self.bodies[pair.inner].name
        return None

    def _active(self, tool: int | None, cutting: bool) -> list[Pair]:
        return [p for p in self.pairs if p.tool in (None, tool) and not (p.cut and cutting)]

    def _block(self, frames: CarrierFrames, pairs: Sequence[Pair], n: int, margin: float) -> Bools:
        hit = np.zeros(n, dtype=np.bool_)
        placed = {k: frames.of(self.bodies[k]) for k in {k for p in pairs for k in (p.inner, p.outer)}}
        for pair in pairs:
            open_ = np.flatnonzero(~hit)
            a, b = (_some_rows(placed[k], open_) for k in (pair.inner, pair.outer))
            near = open_[self.bound(pair, a, b, len(open_)) <= margin]
            for k in near.tolist():
                hit[k] = self.touch(pair, _one(placed[pair.inner], k), _one(placed[pair.outer], k), margin)
        return hit

    def bound(self, pair: Pair, inner: Frame, outer: Frame, n: int) -> Floats:
        """(N,) m: the bodies of a pair are no nearer than this; frames of their shapes, one or (N) each."""
        first, second = self.bodies[pair.inner].shape, self.bodies[pair.outer].shape
        if np.prod(first.held.half + first.held.radius) < np.prod(second.held.half + second.held.radius):
            first, second, inner, outer = second, first, outer, inner
        relative = outer.relative_to(inner)
        rotation = np.broadcast_to(relative.rotation, (n, 3, 3))
        middle = second.cover[:, :3] @ np.swapaxes(rotation, 1, 2) + np.broadcast_to(relative.origin, (n, 3))[:, None]
        beyond = np.maximum(np.abs(middle - first.held.middle) - first.held.half, 0.0)
        distance = np.sqrt(np.einsum("nsk,nsk->ns", beyond, beyond)) - second.cover[:, 3]
        return np.asarray(distance.min(axis=1) - first.held.radius)

    def touch(self, pair: Pair, inner: Frame, outer: Frame, margin: float = 0.0) -> bool:
        """Whether the bodies of a pair are within ``margin`` (m) of each other; frames of their shapes."""
        return self.look(pair, inner, outer, margin)[0]

    def look(self, pair: Pair, inner: Frame, outer: Frame, margin: float = 0.0) -> tuple[bool, float]:
        """As ``touch``; and a lower bound of the distance, m, where they are not."""
        return looked(*self._stand(pair, inner, outer), margin)

    def distance(self, pair: Pair, inner: Frame, outer: Frame) -> float:
        """Distance of the bodies of a pair, m; negative where they touch. A thousand times dearer than ``touch``."""
        return apart(*self._stand(pair, inner, outer))

    def _stand(self, pair: Pair, inner: Frame, outer: Frame) -> tuple[Standing, Standing]:
        first = self.shapes[pair.inner], coal_place(inner.rotation, inner.origin)
        return first, (self.shapes[pair.outer], coal_place(outer.rotation, outer.origin))


def _some(frame: Frame, rows: slice) -> Frame:
    return frame.take(rows) if frame.origin.ndim == 2 else frame


def _some_rows(frame: Frame, rows: npt.NDArray[np.intp]) -> Frame:
    return frame.take(rows) if frame.origin.ndim == 2 else frame


def _one(frame: Frame, k: int) -> Frame:
    return frame.take(k) if frame.origin.ndim == 2 else frame
