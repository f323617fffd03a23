"""Geometry of the local method: links, axes and reflectors of the rigid arm, and joint torques of a load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.robot.robot import STANDARD_GRAVITY, Robot
from stiffness.session.file import SessionTool

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class Stance:
    """The rigid arm at joint angles ``q`` (n,), in base axes.

    Attributes:
        links: (n+1, 4, 4) link frames, 0 the base.
        axis, origin: (n, 3) unit vector of every joint and a point (m) on it.
    """

    q: Floats
    links: Floats
    axis: Floats
    origin: Floats

    def point(self, link: int, position: Floats) -> Floats:
        """(3,) m in the base, of a position (3,) in the frame of a link."""
        return np.asarray(self.links[link, :3, :3] @ position + self.links[link, :3, 3])

    def jacobian(self, link: int, point: Floats) -> Floats:
        """(6, n) of a point (3,) m in the base that moves with a link: linear rows (m/rad) first."""
        columns = np.hstack([np.cross(self.axis, point - self.origin), self.axis])
        columns[link:] = 0.0
        return np.asarray(columns.T)


@dataclass(frozen=True, repr=False, eq=False)
class Force:
    """A wrench (6,) N and N*m as a sensor shows it: its axes are those of the TCP where ``in_tool``, else of the
    base; its moment is about ``point`` (3,) m in the frame of ``point_link``; it acts on ``link``."""

    wrench: Floats
    link: int
    in_tool: bool
    point: Floats
    point_link: int


class LocalArm:
    """A robot with its tool."""

    def __init__(self, robot: Robot, tool: SessionTool) -> None:
        self.robot, self.tool = robot, tool

    def __repr__(self) -> str:
        return f"LocalArm({self.robot.name}, {self.tool.name})"

    @property
    def weighed(self) -> bool:
        """Whether gravity is known."""
        return self.robot.mass is not None

    def stance(self, q: Floats) -> Stance:
        """The arm at joint angles (n,) rad."""
        frame, links, axes, origins = np.eye(4), [np.eye(4)], [], []
        for before, axis, after, angle in zip(self.robot.before, self.robot.axis, self.robot.after, q, strict=True):
            frame = frame @ before
            axes.append(frame[:3, :3] @ axis)
            origins.append(frame[:3, 3])
            turn = np.eye(4)
            turn[:3, :3] = Rotation.from_rotvec(angle * axis).as_matrix()
            frame = frame @ turn @ after
            links.append(frame)
        return Stance(np.asarray(q), np.array(links), np.array(axes), np.array(origins))

    def at_rest(self, q: Floats, stiffness: Floats | None) -> Floats:
        """(n,) rad, where the arm stands without load: commanded plus what the joints whose stiffness (n,) is known
        give way to gravity; NaN: not known."""
        if stiffness is None or not self.weighed:
            return q
        free = Force(wrench=np.zeros(6), link=self.robot.n, in_tool=False, point=np.zeros(3), point_link=self.robot.n)
        return np.asarray(q + np.nan_to_num(self.balance(q, free) / stiffness))

    def turns(self, at: Stance, force: Force) -> Floats:
        """(n, 6): torque on every joint per unit of every number that the sensor shows, J^T in sensor axes."""
        jacobian = at.jacobian(force.link, at.point(force.point_link, force.point))
        if not force.in_tool:
            return np.asarray(jacobian.T)
        axes = at.links[-1, :3, :3] @ self.tool.rotation
        return np.hstack([jacobian[:3].T @ axes, jacobian[3:].T @ axes])

    def in_base(self, at: Stance, force: Force) -> Floats:
        """(6,) the wrench in base axes, about its own point."""
        axes = at.links[-1, :3, :3] @ self.tool.rotation if force.in_tool else np.eye(3)
        return np.concatenate([axes @ force.wrench[:3], axes @ force.wrench[3:]])

    def balance(self, q: Floats, force: Force) -> Floats:
        """(n,) N*m, the generalised force of a load and, where masses are known, of gravity at joint angles q."""
        at = self.stance(q)
        torque = self.turns(at, force) @ force.wrench
        if self.weighed:
            torque = torque + self.robot.gravity_torque(q)
        if self.tool.mass and self.tool.com is not None:
            lever = at.jacobian(self.robot.n, at.point(self.robot.n, self.tool.com))[:3]
            torque = torque + lever.T @ (self.tool.mass * np.array(STANDARD_GRAVITY))
        return np.asarray(torque)
