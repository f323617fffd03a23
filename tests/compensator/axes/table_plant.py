"""A table that turns while an elastic arm cuts: a joint of its own in Pinocchio, under a written RAPID or KRL program.

The controller keeps the user frame where its mechanical unit is, goes straight in the work object on it, and finds the
joint angles by its own kinematics; then the arm yields. Nothing is the product's.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation, Slerp

from tests.compensator.axes.rail_plant import Written, pose

Array = np.ndarray
_NUMBERS = r"\[([-\d.,]+)\]"
_COORDINATED = re.compile(rf'wobj:=\[FALSE,FALSE,"(\w+)",\[\[0,0,0\],\[1,0,0,0\]\],\[{_NUMBERS},{_NUMBERS}\]\]')
_MOVE = re.compile(rf"MoveL \[{_NUMBERS},{_NUMBERS},\[[-\d,]+\],\[([-+\dE.,]+)\]\],(\w+)")
_FRAME = r"X (\S+?),Y (\S+?),Z (\S+?),A (\S+?),B (\S+?),C ([-\d.]+)"
_EK = re.compile(rf"\$BASE=EK\(MACHINE_DEF\[(\d+)\]\.ROOT,MACHINE_DEF\[\1\]\.MECH_TYPE,{{FRAME: {_FRAME}}}\)")
_LIN = re.compile(rf"LIN {{{_FRAME},S \d+,T \d+,E2 (\S+?)}}")


@dataclass(frozen=True)
class Coordinated:
    """A program: what carries the work object, where that is on it (4, 4), targets in it, table (N,) deg, cuts (N,),
    and the first axis (N,) mm, NaN where there is none."""

    unit: str
    on_unit: Array
    target: Array
    angle: Array
    cut: Array
    rail: Array

    @classmethod
    def read(cls, path: Path, axis: int = 1) -> Coordinated:
        """RAPID, by its words."""
        text = path.read_text()
        found = _COORDINATED.search(text)
        assert found is not None
        rows = _MOVE.findall(text)
        target = np.array([_rapid(p, q) for p, q, _, _ in rows])
        angle = np.array([float(e.split(",")[axis]) for _, _, e, _ in rows])
        rail = np.array([np.nan if e.startswith("9E9") else float(e.split(",")[0]) for _, _, e, _ in rows])
        cut = np.array([speed != "vrapid" for *_, speed in rows])
        return cls(found[1], _rapid(found[2], found[3]), target, angle, cut, rail)

    @classmethod
    def read_krl(cls, path: Path) -> Coordinated:
        """KRL, by its words; what cuts is not looked at."""
        text = path.read_text()
        found = _EK.search(text)
        assert found is not None
        rows = np.array([[float(v) for v in row] for row in _LIN.findall(text)])
        target = np.array([_kuka(row) for row in rows])
        on_unit = _kuka([float(v) for v in found.groups()[1:]])
        return cls(found[1], on_unit, target, rows[:, 6], np.ones(len(rows), dtype=bool), np.full(len(rows), np.nan))

    def on_table(self, unit: Array) -> Written:
        """In the world, with a unit at (4, 4) that turns about its z."""
        world = turned_about_z(unit, self.angle) @ self.on_unit
        return Written(world, self.target, np.column_stack([self.rail, self.angle]), self.cut)

    def between(self, share: float) -> Coordinated:
        """As the controller goes on from target to target: straight in the work object, the table evenly."""
        a, b = self.target[:-1], self.target[1:]
        target = a + share * (b - a)
        for k, both in enumerate(zip(a, b, strict=True)):
            turns = Rotation.from_matrix(np.array(both)[:, :3, :3])
            target[k, :3, :3] = Slerp([0.0, 1.0], turns)(share).as_matrix()
        angle = self.angle[:-1] + share * np.diff(self.angle)
        rail = self.rail[:-1] + share * np.diff(self.rail)
        return replace(self, target=target, angle=angle, cut=self.cut[1:] & self.cut[:-1], rail=rail)


def turned_about_z(unit: Array, angle: Array) -> Array:
    """(N, 4, 4) of a mechanical unit at (4, 4) whose joint stands at angles (N,) deg: forward kinematics."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3(unit), "table")
    data, out = model.createData(), []
    for value in np.radians(angle):
        pin.forwardKinematics(model, data, np.array([value]))
        out.append(data.oMi[joint].homogeneous.copy())
    return np.array(out)


def _rapid(position: str, quaternion: str) -> Array:
    numbers = [float(v) for v in quaternion.split(",")]
    return pose([float(v) for v in position.split(",")], Rotation.from_quat(numbers, scalar_first=True))


def _kuka(row: Sequence[float] | Array) -> Array:
    """Of X, Y, Z in mm, and A, B, C in deg about z, the new y, the new x."""
    return pose(np.asarray(row[:3]), Rotation.from_euler("ZYX", row[3:6], degrees=True))
