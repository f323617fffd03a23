"""Carrier frames: where base, links, tool and work object stand, for one posture or many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.scene.body import BASE, TOOL, WORKOBJECT, WORLD, Body
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
STILL = Frame(np.eye(3), np.zeros(3))


@dataclass(frozen=True, repr=False, eq=False)
class CarrierFrames:
    """Frames in the base at N postures.

    Attributes:
        links: n + 1 frames (N), of the base and the links outward.
        workobject: one, or (N). world: of the floor; one, or (N) where a rail moves the base.
    """

    links: tuple[Frame, ...]
    workobject: Frame
    world: Frame = STILL

    def of(self, body: Body) -> Frame:
        """(N) frames of the shape of a body, or one where it stands still."""
        if body.carrier == WORKOBJECT:
            return self.workobject.then(body.placement)
        if body.carrier == WORLD:
            return self.world.then(body.placement)
        if body.carrier == BASE:
            return body.placement
        link = len(self.links) - 1 if body.carrier == TOOL else int(body.carrier)
        return self.links[link].then(body.placement)


def link_frames(robot: Robot, q: Floats) -> tuple[Frame, ...]:
    """n + 1 frames (N) of base and links at joint angles (N, n) rad."""
    rotation, origin = np.tile(np.eye(3), (len(q), 1, 1)), np.zeros((len(q), 3))
    out = [Frame(rotation, origin)]
    sine, cosine = np.sin(q), np.cos(q)
    for k in range(robot.n):
        before, after, (x, y, z) = robot.before[k], robot.after[k], robot.axis[k]
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turn = np.eye(3) + sine[:, k, None, None] * cross + (1.0 - cosine[:, k, None, None]) * (cross @ cross)
        origin = origin + rotation @ before[:3, 3]
        rotation = rotation @ before[:3, :3] @ turn
        origin = origin + rotation @ after[:3, 3]
        rotation = rotation @ after[:3, :3]
        out.append(Frame(rotation, origin))
    return tuple(out)
