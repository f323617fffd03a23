"""What the plant did along a path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .geometry import Array, pose_error
from .joints import Memory


@dataclass(frozen=True)
class Walk:
    """What the plant did, one row per pose; every pose in the robot's base frame."""

    q_cmd: Array  # (N,n) rad
    wrench: Array  # (N,6) on the robot, base axes, about the TCP
    q_act: Array  # (N,n) rad, true joint angles
    torque: Array  # (N,n) N*m, of gravity and environment on each joint
    play: Array  # (N,n) rad
    direction: Array  # (N,n) last rotation
    elastic: Array  # (N,6*places) m and rad, coordinates of the elastic places
    links: Array  # (N,n+1,4,4) link frames, true
    rigid: Array  # (N,n+1,4,4) link frames of the rigid arm at q_cmd
    sag: Array  # (N,n+1,4,4) link frames without process, as the controller knows it: rigid or sagged
    tcp: Array  # (N,4,4) as reported
    nominal: Array  # (N,4,4) TCP of the rigid arm at q_cmd
    knot: Array  # (N,) True where the row is a commanded pose, not one between two
    memory: Memory  # after the last pose: hand it to the next walk as `start`

    def points(self, link: int, at: ArrayLike) -> Array:
        """(N,3) m: a point given in the frame of a link, as reported (calibrated_out: less its sag)."""
        return reported(self.links[:, link], self.rigid[:, link], self.sag[:, link], at)

    @property
    def deflection(self) -> Array:
        """(N,3) m, actual minus commanded TCP."""
        return self.tcp[:, :3, 3] - self.nominal[:, :3, 3]

    def errors(self, wanted: Array) -> tuple[Array, Array]:
        """Distances (N,) m and angles (N,) rad to wanted TCP poses (N,4,4)."""
        pairs = [pose_error(T, W) for T, W in zip(self.tcp, wanted, strict=True)]
        return np.array([p for p, _ in pairs]), np.array([a for _, a in pairs])


def reported(true: Array, rigid: Array, sag: Array, at: ArrayLike) -> Array:
    """(...,3) m: where a point of a link (frames (...,4,4)) is, less the way that it has sagged."""
    point = np.append(np.asarray(at, dtype=float), 1.0)
    out: Array = ((true + (rigid - sag)) @ point)[..., :3]
    return out
