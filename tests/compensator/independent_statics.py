"""The statics once more, in numpy on Pinocchio's kinematics: nothing of it is the product's.

    dq = tau / K + a tanh(tau / T),  tau = J(q + dq)^T W + g(q + dq)
    displacement = C F,                      F the generalised force of the six coordinates of the flange spring

solved by sweeps from zero. The displacement moves what hangs on the flange by d, then turns it by the rotation vector
phi; its generalised force comes from virtual work, by central differences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from stiffness.robot.robot import Robot
from tests.compensator.posture_toolpaths import frame

Array = np.ndarray


@dataclass(frozen=True)
class Arm:
    """An elastic arm with a tool."""

    robot: Robot
    tool: Mapping[str, Any]
    effects: Mapping[str, Mapping[str, Any]]
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0)
    calibrated_out: bool = False
    compliance: Array = field(default_factory=lambda: np.zeros((6, 6)))

    @property
    def gravity(self) -> Array:
        """(3,) m/s2 in the base: -z of the world."""
        return Rotation.from_euler("xyz", self.mount, degrees=True).inv().apply([0, 0, -9.80665])

    def tcp(self, q: Array, wrench: Array) -> Array:
        """(4, 4) of the TCP under a wrench (6,) in base axes about it, commanded joints q (6,)."""
        pose = self._loaded(q, wrench)
        if not self.calibrated_out:
            return pose
        sag, nominal = self._loaded(q, np.zeros(6)), self.robot.pose(q) @ frame(self.tool)
        out = pose.copy()
        out[:3, :3] = pose[:3, :3] @ sag[:3, :3].T @ nominal[:3, :3]
        out[:3, 3] = pose[:3, 3] - sag[:3, 3] + nominal[:3, 3]
        return out

    def _loaded(self, q: Array, wrench: Array) -> Array:
        dq, displacement = np.zeros(6), np.zeros(6)
        for _ in range(15):
            hand = self.robot.pose(q + dq)
            loads = self._loads(hand @ moved(displacement), wrench)
            tau = self._torque(q + dq, hand[:3, 3], loads)
            dq = self._wind_up(tau)
            if self.compliance.any():
                displacement = self.compliance @ self._generalised(hand, displacement, wrench)
        return self.robot.pose(q + dq) @ moved(displacement) @ frame(self.tool)

    def _loads(self, hand: Array, wrench: Array) -> list[tuple[Array, Array, Array]]:
        """(point, force, moment) in the base beyond the spring: process, tool, and the last link, which it moves."""
        out = [((hand @ frame(self.tool))[:3, 3], wrench[:3], wrench[3:])]
        weights = [(self.robot.mass[-1], self.robot.com[-1])]
        if self.tool.get("mass"):
            weights.append((self.tool["mass"], np.array(self.tool["com"]) / 1e3))
        out += [((hand @ np.append(com, 1.0))[:3], mass * self.gravity, np.zeros(3)) for mass, com in weights]
        return out

    def _torque(self, q: Array, origin: Array, loads: list[tuple[Array, Array, Array]]) -> Array:
        jacobian = self.robot.jacobian(q)
        total = self.robot.gravity_torque(q, self.gravity)
        unsprung = (self.robot.pose(q) @ np.append(self.robot.com[-1], 1.0))[:3]  # is among the loads already
        loads = [*loads, (unsprung, -self.robot.mass[-1] * self.gravity, np.zeros(3))]
        for point, force, moment in loads:
            total = total + jacobian.T @ np.concatenate([force, moment + np.cross(point - origin, force)])
        return total

    def _wind_up(self, tau: Array) -> Array:
        dq = tau / np.array(self.effects["joint-stiffness"]["k_nm_per_rad"])
        if hard := self.effects.get("joint-hardening"):
            dq = dq + np.array(hard["windup_rad"]) * np.tanh(tau / np.array(hard["knee_nm"]))
        return dq

    def _generalised(self, hand: Array, displacement: Array, wrench: Array) -> Array:
        force, h = np.zeros(6), 1e-6
        now = self._loads(hand @ moved(displacement), wrench)
        for k, step in enumerate(h * np.eye(6)):
            more, less = hand @ moved(displacement + step), hand @ moved(displacement - step)
            turn = Rotation.from_matrix(more[:3, :3] @ less[:3, :3].T).as_rotvec()
            ends = zip(now, self._loads(more, wrench), self._loads(less, wrench), strict=True)
            force[k] = sum(f @ (a[0] - b[0]) + m @ turn for (_, f, m), a, b in ends) / (2 * h)
        return force


def moved(displacement: Array) -> Array:
    """(4, 4): by d, then turned by the rotation vector."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_rotvec(displacement[3:]).as_matrix(), displacement[:3]
    return pose


def compliance(p: Mapping[str, Any]) -> Array:
    """(6, 6) from the diagonal and the rows below it."""
    c = np.diag([*p["linear_m_per_n"], *p["angular_rad_per_nm"]]).astype(float)
    below = iter(p.get("coupling", [0.0] * 15))
    for row in range(1, 6):
        for column in range(row):
            c[row, column] = c[column, row] = next(below)
    return c
