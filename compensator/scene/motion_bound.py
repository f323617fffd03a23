"""Motion bound: how far the farthest point of one body can move against another along a path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from compensator.scene.body import WORKOBJECT, WORLD, Body
from compensator.scene.pairs import Pair, depth
from compensator.scene.shape import Shape3
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]


def motion_along(
    robot: Robot, bodies: Sequence[Body], pair: Pair, *, q: Floats, moving: Mapping[str, Frame]
) -> Floats:
    """(N,) m: how far any point of the outer body can have moved against the inner one up to each pose; no less.

    Args:
        q: (N, n) rad. moving: carrier -> (N) frames, of those that move beside the arm.
    """
    outer = bodies[pair.outer]
    way = np.zeros(len(q) - 1)
    for j in range(robot.n)[pair.joints]:  # one joint at a time: a path may be long
        way += np.abs(np.diff(q[:, j])) * lever(robot, j, depth(outer, robot.n), outer)
    for k in (pair.inner, pair.outer):
        carrier = bodies[k].carrier
        if isinstance(carrier, str) and carrier in moving and carrier in (WORKOBJECT, WORLD):
            way += _own_way(moving[carrier], bodies[k])
    return np.concatenate([[0.0], np.cumsum(way)])


def lever(robot: Robot, joint: int, link: int, body: Body) -> float:
    """How far a point of ``body`` on ``link`` can be from the axis of a joint (0 the first), m, in any posture."""
    way = 0.0
    for k in range(joint, link):
        way += float(np.linalg.norm(robot.after[k][:3, 3]))
        if k > joint:
            way += float(np.linalg.norm(robot.before[k][:3, 3]))
    return way + farthest(body.shape, body.placement)


def farthest(shape: Shape3, placement: Frame) -> float:
    """Largest distance of a point of a shape from the origin of its carrier, m."""
    held = shape.held
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = placement.at(held.middle + signs * held.half)
    return float(np.linalg.norm(corners, axis=1).max()) + held.radius


def _own_way(frames: Frame, body: Body) -> Floats:
    """(N - 1,) m that the farthest point of a body moves with its carrier between poses."""
    shift = np.linalg.norm(np.diff(frames.origin, axis=0), axis=1)
    before, after = frames.rotation[:-1], frames.rotation[1:]
    trace = np.einsum("nij,nij->n", before, after)
    angle = np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
    return np.asarray(shift + angle * farthest(body.shape, body.placement))
