"""Levers: how far the TCP goes when one joint turns, of the nominal arm, over many postures."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.robot.robot import Robot
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]


def tcp_levers(robot: Robot, tool: Tool, q: Floats) -> Floats:
    """(N, n, 3) m/rad of the TCP in base axes by each joint at the postures ``q`` (N, n) rad."""
    pose = np.tile(np.eye(4), (len(q), 1, 1))
    axes, origins = [], []
    for k in range(robot.n):
        pose = pose @ robot.before[k]
        axes.append(pose[:, :3, :3] @ robot.axis[k])
        origins.append(pose[:, :3, 3])
        turn = np.tile(np.eye(4), (len(q), 1, 1))
        turn[:, :3, :3] = Rotation.from_rotvec(q[:, k, None] * robot.axis[k]).as_matrix()
        pose = pose @ turn @ robot.after[k]
    tcp = (pose @ np.append(tool.position, 1.0))[:, :3]
    return np.stack([np.cross(a, tcp - o) for a, o in zip(axes, origins, strict=True)], axis=1)
