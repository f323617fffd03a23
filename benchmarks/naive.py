"""The naive loop that everything is measured against: Pinocchio and scipy.optimize, pose after pose.

Written as an engineer would who knows the physics and not the product: Pinocchio for kinematics and
gravity, a fixed point for the equilibrium, ``scipy.optimize.root`` with the Jacobian of the arm for the command,
every solve started from the one before. No formula is shared with ``stiffness``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from scipy.optimize import least_squares, root

from stiffness.robot.robot import Robot
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]

SETTLED = 1e-11  # rad and m: last change of an equilibrium; the next would be a hundredth of it
SWEEPS = 50
TOLERANCE = 1e-9  # relative, of the last step of scipy's solve: what is left then is below 1e-11


class NaiveArm:
    """One arm with joint springs, and hardening and a spring at the flange where the model has them.

    Args:
        values: effect -> parameter -> numbers, as in a model file.
        gravity: (3,) m/s2 in the base.
        calibrated_out: the controller takes the sag of arm and tool off.
    """

    def __init__(
        self,
        robot: Robot,
        values: Mapping[str, Mapping[str, Floats]],
        tool: Tool,
        *,
        gravity: Floats,
        calibrated_out: bool = False,
    ) -> None:
        if robot.mass is None or robot.com is None:
            raise ValueError(f"{robot.name} has no masses")
        self.calibrated_out = calibrated_out
        self._gravity = np.asarray(gravity, dtype=float)
        self._stiffness = values["joint-stiffness"]["k_nm_per_rad"]
        hardening = values.get("joint-hardening")
        self._windup = None if hardening is None else hardening["windup_rad"]
        self._knee = None if hardening is None else hardening["knee_nm"]
        spring = values.get("tool-compliance")
        self._compliance = None if spring is None else _matrix(spring)
        self._tcp = pin.SE3(tool.rotation, tool.position)
        self._model, self._frame = _model(robot, self._gravity)
        self._data = self._model.createData()
        # what hangs outward of the flange's spring: the last link and the tool
        parts = [(float(robot.mass[-1]), robot.com[-1])]
        if tool.mass and tool.com is not None:
            parts.append((tool.mass, tool.com))
        self._outer_mass = sum(m for m, _ in parts)
        self._outer_com = sum(m * np.asarray(c) for m, c in parts) / self._outer_mass
        self._last = {False: np.zeros(robot.n + 6), True: np.zeros(robot.n + 6)}

    def forward(self, q: Floats, wrench: Floats) -> tuple[Floats, Floats]:
        """Rotation (3, 3) and position (3,) of the deflected TCP at a command (n,); wrench about the TCP, base."""
        at = self._deflected(q, wrench)
        if not self.calibrated_out:
            return at.rotation, at.translation
        sag, rigid = self._deflected(q, np.zeros(6), sag=True), self._flange(q) * self._tcp
        rotation = at.rotation @ sag.rotation.T @ rigid.rotation
        return rotation, at.translation - sag.translation + rigid.translation

    def command(self, rotation: Floats, position: Floats, wrench: Floats, start: Floats) -> Floats:
        """Command (n,) whose deflected TCP stands at a pose; ``start`` is where the search begins."""
        options = {"xtol": TOLERANCE}
        solution = root(self._miss(rotation, position, wrench), start, jac=self._jacobian, options=options)
        return np.asarray(solution.x)

    def command_by_least_squares(self, rotation: Floats, position: Floats, wrench: Floats, start: Floats) -> Floats:
        """The same with scipy's least_squares, which many take first."""
        miss = self._miss(rotation, position, wrench)
        solution = least_squares(miss, start, jac=self._jacobian, xtol=TOLERANCE, ftol=TOLERANCE, gtol=None)
        return np.asarray(solution.x)

    def _miss(self, rotation: Floats, position: Floats, wrench: Floats) -> Callable[[Floats], Floats]:
        """Position and rotation vector (6,) from the wanted pose to the deflected one."""

        def miss(q: Floats) -> Floats:
            r, p = self.forward(q, wrench)
            return np.concatenate([p - position, -r @ pin.log3(r.T @ rotation)])

        return miss

    def closed_form(self, actual: Floats, wrench: Floats) -> Floats:
        """Command (n,) for known ACTUAL joint angles: joint springs alone need no search."""
        tau = self._torque(actual, self._flange(actual), wrench)
        return np.asarray(actual - tau / self._stiffness)

    def _jacobian(self, q: Floats) -> Floats:
        """(6, n) of the rigid TCP: near enough for the search."""
        j = pin.computeFrameJacobian(self._model, self._data, q, self._frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        flange = self._data.oMf[self._frame]
        j[:3] -= pin.skew(flange.rotation @ self._tcp.translation) @ j[3:]
        return np.asarray(j)

    def _deflected(self, q: Floats, wrench: Floats, *, sag: bool = False) -> pin.SE3:
        """Pose of the deflected TCP: torque -> deflection -> torque until nothing changes, from the last one."""
        dq, displacement = np.split(self._last[sag], [len(q)])
        for _ in range(SWEEPS):
            inner = self._flange(q + dq)
            outer = inner if self._compliance is None else inner * pin.SE3(pin.exp3(displacement[3:]), displacement[:3])
            tau = self._torque(q + dq, outer, wrench)
            new = tau / self._stiffness
            if self._windup is not None and self._knee is not None:
                new = new + self._windup * np.tanh(tau / self._knee)
            change = np.abs(new - dq).max()
            dq = new
            if self._compliance is not None:
                force, moment = self._at_flange(outer, wrench)
                load = np.concatenate(
                    [inner.rotation.T @ force, pin.Jexp3(displacement[3:]) @ (inner.rotation.T @ moment)]
                )
                new = self._compliance @ load
                change = max(change, np.abs(new - displacement).max())
                displacement = new
            if change < SETTLED:
                break
        self._last[sag] = np.concatenate([dq, displacement])
        inner = self._flange(q + dq)
        if self._compliance is not None:
            inner = inner * pin.SE3(pin.exp3(displacement[3:]), displacement[:3])
        return inner * self._tcp

    def _flange(self, q: Floats) -> pin.SE3:
        pin.framesForwardKinematics(self._model, self._data, q)
        return self._data.oMf[self._frame].copy()

    def _at_flange(self, flange: pin.SE3, wrench: Floats) -> tuple[Floats, Floats]:
        """Force and moment about the flange's origin of process, tool and last link."""
        weight = self._outer_mass * self._gravity
        lever, com = flange.rotation @ self._tcp.translation, flange.rotation @ self._outer_com
        force = wrench[:3] + weight
        return force, wrench[3:] + pin.skew(lever) @ wrench[:3] + pin.skew(com) @ weight

    def _torque(self, q: Floats, flange: pin.SE3, wrench: Floats) -> Floats:
        """(n,) of gravity and process at joint angles ``q``, with the flange where its spring leaves it."""
        force, moment = self._at_flange(flange, wrench)
        j = pin.computeFrameJacobian(self._model, self._data, q, self._frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        inner = self._data.oMf[self._frame]
        moment = moment + pin.skew(flange.translation - inner.translation) @ force
        weight = pin.computeGeneralizedGravity(self._model, self._data, q)
        return np.asarray(j[:3].T @ force + j[3:].T @ moment - weight)


def _matrix(spring: Mapping[str, Floats]) -> Floats:
    """(6, 6) of the spring at the flange."""
    c = np.zeros((6, 6))
    c[np.tril_indices(6, -1)] = spring["coupling"]
    return c + c.T + np.diag(np.concatenate([spring["linear_m_per_n"], spring["angular_rad_per_nm"]]))


def _model(robot: Robot, gravity: Floats) -> tuple[pin.Model, int]:
    """Pinocchio's arm with the masses of all links but the last, and the index of its flange."""
    model = pin.Model()
    parent, placement = 0, np.eye(4)
    for k in range(robot.n):
        joint = pin.JointModelRevoluteUnaligned(np.array(robot.axis[k]))
        parent = model.addJoint(parent, joint, pin.SE3(placement @ robot.before[k]), f"joint{k}")
        placement = np.array(robot.after[k])
        if k < robot.n - 1 and robot.mass is not None and robot.com is not None:
            com = placement[:3, :3] @ robot.com[k] + placement[:3, 3]
            body = pin.Inertia(robot.mass[k], com, np.zeros((3, 3)))
            model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    model.gravity.linear = gravity
    frame = model.addFrame(pin.Frame("flange", parent, pin.SE3(placement), pin.FrameType.OP_FRAME))
    return model, frame
