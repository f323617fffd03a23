"""An elastic arm on a rail, the part on a table, in Pinocchio: rail and table are joints of their own.

A written RAPID program is run: the controller holds rail and table where the program has them and finds the joint
angles of each target in the fixed work object by its own kinematics; then the arm yields. Nothing is the product's.

    dq = tau / K,  tau = J(q + dq)^T W - g(q + dq)
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from tests.plant.arm import Arm

Array = np.ndarray
_NUMBERS = r"\[([-\d.,]+)\]"
_MOVE = re.compile(rf"MoveL \[{_NUMBERS},{_NUMBERS},\[[-\d,]+\],\[([-+\dE.,]+)\]\],(\w+)")


def pose(xyz: Sequence[float] | Array, turn: Rotation) -> Array:
    """(4, 4) of mm."""
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = turn.as_matrix(), np.asarray(xyz) / 1e3
    return out


@dataclass(frozen=True)
class Written:
    """A RAPID program: work object (4, 4), targets (N, 4, 4) in it, axes (N, 6), NaN where there is none, cuts (N,)."""

    work: Array
    target: Array
    axes: Array
    cut: Array

    @classmethod
    def read(cls, path: Path) -> Written:
        """By the words of RAPID."""
        text = path.read_text()
        frame = re.search(rf'wobj:=\[FALSE,TRUE,"",\[{_NUMBERS},{_NUMBERS}\],\[\[0,0,0\],\[1,0,0,0\]\]\]', text)
        assert frame is not None
        rows = [(_of(p, q), _axes(e), speed) for p, q, e, speed in _MOVE.findall(text)]
        target, axes, speed = zip(*rows, strict=True)
        return cls(_of(*frame.groups()), np.array(target), np.array(axes), np.array([s != "vrapid" for s in speed]))


def _of(position: str, quaternion: str) -> Array:
    numbers = [float(v) for v in quaternion.split(",")]
    return pose([float(v) for v in position.split(",")], Rotation.from_quat(numbers, scalar_first=True))


def _axes(text: str) -> list[float]:
    return [np.nan if v == "9E9" else float(v) for v in text.split(",")]


@dataclass(frozen=True)
class RailPlant:
    """The arm on rails (directions in base axes), stiffness (n,) N*m/rad."""

    arm: Arm
    rails: Sequence[Sequence[float]]
    stiffness: Array

    def model(self) -> tuple[pin.Model, int]:
        """With the TCP as its last frame."""
        arm, model, parent = self.arm, pin.Model(), 0
        model.gravity.linear = arm.gravity
        for k, way in enumerate(self.rails):
            rail = pin.JointModelPrismaticUnaligned(np.array(way))
            parent = model.addJoint(parent, rail, pin.SE3.Identity(), f"r{k}")
        behind = np.eye(4)
        for k in range(arm.n):
            place = pin.SE3(behind @ arm.before[k])
            parent = model.addJoint(parent, pin.JointModelRevoluteUnaligned(arm.axis[k]), place, arm.joint_names[k])
            behind = arm.after[k]
            if arm.mass is not None and arm.com is not None:
                at = pin.SE3(behind)
                model.appendBodyToJoint(parent, pin.Inertia(float(arm.mass[k]), arm.com[k], np.zeros((3, 3))), at)
        tool = pin.Inertia(arm.tool.mass, np.array(arm.tool.com, dtype=float), np.zeros((3, 3)))
        model.appendBodyToJoint(parent, tool, pin.SE3(behind))
        frame = pin.Frame("tcp", parent, 0, pin.SE3(behind @ arm.tool.pose), pin.FrameType.OP_FRAME)
        return model, model.addFrame(frame)

    def run(self, written: Written, places: Array, wrench: Array, start: Array) -> tuple[Array, Array]:
        """(N, 4, 4) of the TCP in the world, and (N, n) rad commanded.

        Args:
            places: (N, R) m of the rails. wrench: (N, 6) about the TCP, base axes. start: (n,) rad near the first pose.
        """
        model, frame = self.model()
        data, rails, q = model.createData(), len(self.rails), np.array(start)
        tcp, commanded = [], []
        for target, place, load in zip(written.work @ written.target, places, wrench, strict=True):
            q = _inverse(model, data, frame, target=pin.SE3(target), held=place, seed=q)
            turned = q.copy()
            for _ in range(30):
                whole = np.concatenate([place, turned])
                jacobian = pin.computeFrameJacobian(model, data, whole, frame, pin.LOCAL_WORLD_ALIGNED)
                torque = jacobian.T @ load - pin.computeGeneralizedGravity(model, data, whole)
                turned = q + torque[rails:] / self.stiffness
            pin.framesForwardKinematics(model, data, np.concatenate([place, turned]))
            tcp.append(data.oMf[frame].homogeneous.copy())
            commanded.append(q)
        return np.array(tcp), np.array(commanded)


def _inverse(model: pin.Model, data: pin.Data, frame: int, *, target: pin.SE3, held: Array, seed: Array) -> Array:
    """(n,) rad of the arm, rails held, by Newton."""
    q = np.array(seed)
    for _ in range(200):
        whole = np.concatenate([held, q])
        pin.framesForwardKinematics(model, data, whole)
        off = pin.log6(data.oMf[frame].actInv(target)).vector
        if np.abs(off).max() < 1e-12:
            return q
        jacobian = pin.computeFrameJacobian(model, data, whole, frame, pin.LOCAL)[:, len(held) :]
        step = np.linalg.solve(jacobian, off)
        q = q + step * min(1.0, 0.3 / np.abs(step).max())
    raise AssertionError("the controller finds no joint angles")
