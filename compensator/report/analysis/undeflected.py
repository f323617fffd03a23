"""The undeflected arm at the postures of a session: plain kinematics, for figures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.robot.robot import Robot
from stiffness.rotation import from_rotation_vector
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class UndeflectedArm:
    """N postures, in the base.

    Attributes:
        links: (N, n + 1) frames, the base first.
        axis, pivot: (N, n, 3) direction of each joint's axis, and a point on it, m.
    """

    links: Frame
    axis: Floats
    pivot: Floats

    def link(self, number: int) -> Frame:
        """(N,) frames of one link: 0 the base, -1 the flange."""
        return Frame(self.links.rotation[:, number], self.links.origin[:, number])

    def link_of_each(self, number: npt.NDArray[np.integer]) -> Frame:
        """(N,) frames of link ``number`` (N,), another one in every posture."""
        every = np.arange(len(number))
        return Frame(self.links.rotation[every, number], self.links.origin[every, number])


def undeflected(robot: Robot, q: Floats) -> UndeflectedArm:
    """The arm at joint angles (N, n) rad."""
    at = Frame(np.tile(np.eye(3), (len(q), 1, 1)), np.zeros((len(q), 3)))
    links, axis, pivot = [at], [], []
    for k in range(robot.n):
        at = at.then(Frame.of(robot.before[k]))
        axis.append(at.along(robot.axis[k]))
        pivot.append(at.origin)
        turned = from_rotation_vector(q[:, k, None] * robot.axis[k])
        at = Frame(at.rotation @ turned, at.origin).then(Frame.of(robot.after[k]))
        links.append(at)
    every = Frame(np.stack([f.rotation for f in links], 1), np.stack([f.origin for f in links], 1))
    return UndeflectedArm(every, np.stack(axis, 1), np.stack(pivot, 1))
