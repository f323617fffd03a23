"""The arm as a MuJoCo model: its body tree, and the generalised forces that MuJoCo works out for it.

Coordinates x: the n joint angles, then for every elastic place three slides and three hinges along the axes
of the link frame they sit in (x, y, z; the hinges turn one after the other). Forces come from MuJoCo alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from .arm import Arm
from .geometry import Array

TINY = 1e-12  # kg and kg*m2 of bodies without a mass of their own: MuJoCo wants more than zero
PLACE = 6  # coordinates per elastic place


@dataclass(frozen=True)
class Load:
    """A dead load of the environment on the robot: base axes, about a point that moves with the link."""

    link: int  # 0 = base ... n = flange and tool
    at: Array  # (3,) m, in that link's frame
    force: Array  # (3,) N
    moment: Array  # (3,) N*m


class Scene:
    """One arm in MuJoCo, with elastic places at the links in `places` (0 = base ... n = flange)."""

    def __init__(self, arm: Arm, places: Sequence[int] = (), gravity: bool = True) -> None:
        if gravity and arm.mass is None:
            raise ValueError(f"{arm.name}: masses unknown; use gravity_on=False or Arm.with_masses")
        self.arm = arm
        self.places = tuple(sorted(places))
        self.model = self._build(gravity).compile()
        self.data = mujoco.MjData(self.model)
        self._links = [self.model.body(f"link{k}").id for k in range(arm.n + 1)]
        columns = [self.model.joint(f"q{k}").dofadr[0] for k in range(arm.n)]
        columns += [self.model.joint(f"e{k}_{i}").dofadr[0] for k in self.places for i in range(PLACE)]
        self._columns = np.array(columns)
        self._force = np.zeros(self.model.nv)
        self.move(np.zeros(self.size))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self._columns)

    def _build(self, gravity: bool) -> mujoco.MjSpec:
        arm, spec = self.arm, mujoco.MjSpec()
        spec.compiler.degree = False
        spec.option.gravity = arm.gravity if gravity else np.zeros(3)
        body = self._body(spec.worldbody, "link0", np.eye(4))
        self._elastic(body, 0)
        for k in range(arm.n):
            body = self._body(body, f"joint{k}", arm.before[k])
            body.add_joint(name=f"q{k}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=arm.axis[k])
            body = self._body(body, f"link{k + 1}", arm.after[k])
            if arm.mass is not None and arm.com is not None and arm.mass[k] > 0:
                body.mass, body.ipos = arm.mass[k], arm.com[k]
            self._elastic(body, k + 1)
        tool = self._body(body, "tool", np.eye(4))
        if arm.tool.mass > 0:
            tool.mass, tool.ipos = arm.tool.mass, arm.tool.com
        return spec

    @staticmethod
    def _body(parent: mujoco.MjsBody, name: str, pose: Array) -> mujoco.MjsBody:
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, np.ascontiguousarray(pose[:3, :3]).ravel())
        body = parent.add_body(name=name, pos=pose[:3, 3], quat=quat)
        body.explicitinertial, body.mass, body.inertia = True, TINY, [TINY] * 3
        return body

    def _elastic(self, body: mujoco.MjsBody, k: int) -> None:
        if k not in self.places:
            return
        kinds = [mujoco.mjtJoint.mjJNT_SLIDE] * 3 + [mujoco.mjtJoint.mjJNT_HINGE] * 3
        for i, kind in enumerate(kinds):
            body.add_joint(name=f"e{k}_{i}", type=kind, axis=np.eye(3)[i % 3])

    def move(self, x: Array) -> None:
        """Put the arm at the coordinates x (size,), at rest."""
        self.data.qpos[self._columns] = x  # hinges and slides only: qpos and dof addresses agree
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)

    def link(self, k: int) -> Array:
        """(4,4) pose of link frame k in the base, where `move` put it."""
        T = np.eye(4)
        T[:3, :3] = self.data.xmat[self._links[k]].reshape(3, 3)
        T[:3, 3] = self.data.xpos[self._links[k]]
        return T

    def links(self) -> Array:
        """(n+1,4,4) all link frames in the base."""
        return np.array([self.link(k) for k in range(self.arm.n + 1)])

    def tcp(self) -> Array:
        """(4,4) TCP in the base."""
        return self.link(self.arm.n) @ self.arm.tool.pose

    def forces(self, loads: Sequence[Load]) -> Array:
        """(size,) generalised force of gravity and loads at the present posture, N*m (and N for slides)."""
        mujoco.mj_rne(self.model, self.data, 0, self._force)  # at rest: minus the force of gravity
        total = -self._force
        for load in loads:
            T = self.link(load.link)
            point = T[:3, :3] @ load.at + T[:3, 3]
            mujoco.mj_applyFT(
                self.model, self.data, load.force, load.moment, point, self._links[load.link], total
            )
        out: Array = total[self._columns]
        return out

    def jacobian(self) -> Array:
        """(6,n) of the TCP, base axes, linear rows first, for the joints."""
        jacp, jacr = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        mujoco.mj_jac(self.model, self.data, jacp, jacr, self.tcp()[:3, 3], self._links[self.arm.n])
        return np.vstack([jacp, jacr])[:, self._columns[: self.arm.n]]

    def potential(self) -> float:
        """Potential energy of all masses, J, by MuJoCo."""
        mujoco.mj_energyPos(self.model, self.data)
        return float(self.data.energy[0])
