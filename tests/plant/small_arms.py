"""Arms small enough for a hand calculation, and the text of a URDF of the plant's own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .arm import Arm, Tool
from .geometry import Array, placement, shift


def chain(
    before: list[Array],
    axis: Sequence[Sequence[float]],
    after: list[Array],
    *,
    mass: ArrayLike | None = None,
    com: ArrayLike | None = None,
    tool: Tool | None = None,
    mount_rpy: ArrayLike = (0, 0, 0),
) -> Arm:
    """An arm from placements; masses default to none at all (0 kg)."""
    n = len(axis)
    return Arm(
        name="small",
        joint_names=tuple(f"j{k + 1}" for k in range(n)),
        before=np.array(before),
        axis=np.array(axis, dtype=float),
        after=np.array(after),
        lower=np.full(n, -np.pi),
        upper=np.full(n, np.pi),
        mass=np.zeros(n) if mass is None else np.array(mass, dtype=float),
        com=np.zeros((n, 3)) if com is None else np.array(com, dtype=float),
        tool=tool or Tool(),
        mount_rpy=np.array(mount_rpy, dtype=float),
    )


def planar(lengths: list[float], **more: Any) -> Arm:
    """Joints about -y (positive lifts), links along x, in the xz plane: pose all zero = stretched along x."""
    n = len(lengths)
    return chain([np.eye(4)] * n, [[0, -1, 0]] * n, [shift((length, 0, 0)) for length in lengths], **more)


def six_axis(**more: Any) -> Arm:
    """A 6-axis arm of its own proportions, spherical wrist, about 2.3 m reach."""
    before = [
        placement((0, 0, 0.41)),
        placement((0.29, 0, 0.27), (0, 0, 0.0)),
        placement((0, 0, 1.05)),
        placement((0.35, 0, 0.16)),
        placement((0.66, 0, 0)),
        placement((0.17, 0, 0)),
    ]
    axis = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]]
    after = [np.eye(4)] * 5 + [placement((0.06, 0, 0), (0, np.pi / 2, 0))]
    mass = [290.0, 210.0, 150.0, 60.0, 30.0, 12.0]
    com = [[0.1, 0.02, 0.1], [0.03, -0.1, 0.5], [0.1, 0.01, 0.1], [0.3, 0, 0], [0.05, 0, 0], [0, 0, -0.02]]
    return chain(before, axis, after, **{"mass": mass, "com": com, **more})


URDF = """<?xml version="1.0"?>
<robot name="own">
  <link name="world"/>
  <link name="pedestal"/>
  <link name="base"/>
  <link name="arm"><inertial><origin xyz="0.2 0.01 0.03" rpy="0 0 0"/><mass value="20"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="motor"><inertial><origin xyz="0 0 0.1"/><mass value="5"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="rod"/>
  <link name="hand"><inertial><origin xyz="0.05 0 0"/><mass value="3"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool0"/>
  <joint name="stand" type="fixed"><parent link="world"/><child link="pedestal"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.1 -0.2 0.3"/></joint>
  <joint name="frame" type="fixed"><parent link="world"/><child link="base"/>
    <origin xyz="-0.4 0.1 0.2" rpy="0.2 0.1 -0.5"/></joint>
  <joint name="shoulder" type="revolute"><parent link="pedestal"/><child link="arm"/>
    <origin xyz="0 0.1 0.5" rpy="0 0.3 0"/><axis xyz="0 0 -1"/>
    <limit lower="-2" upper="2.5" effort="1" velocity="1"/></joint>
  <joint name="bolt" type="fixed"><parent link="arm"/><child link="motor"/>
    <origin xyz="0.4 0 0" rpy="0 0 1"/></joint>
  <joint name="linkage" type="continuous"><parent link="arm"/><child link="rod"/>
    <axis xyz="0 1 0"/><mimic joint="elbow" multiplier="-1"/></joint>
  <joint name="elbow" type="continuous"><parent link="motor"/><child link="hand"/>
    <origin xyz="0.2 0.1 0" rpy="0.5 0 0.1"/><axis xyz="0 2 1"/></joint>
  <joint name="tail" type="fixed"><parent link="hand"/><child link="tool0"/>
    <origin xyz="0.1 0 0.02" rpy="0 1.2 0.3"/></joint>
</robot>
"""
