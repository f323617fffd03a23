"""Postures that a lab can take up: inside the limits with room to spare, above the floor, clear of the base, bent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.errors import StiffnessError
from stiffness.kinematics.jacobian import Conditioning, half_reach
from stiffness.robot.robot import Robot
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]

MARGIN = np.radians(5.0)  # from a joint limit: room for an approach from either side
FLOOR = 0.1  # m above the base plane for every link from the second, and for the TCP
COLUMN = 0.2  # of the length of the chain: how far TCP and flange stay away from axis 1
BENT = 0.05  # smallest singular value of the Jacobian, lengths over half the reach
BATCH = 2000
BATCHES = 50


@dataclass(frozen=True, repr=False)
class PosturePool:
    """``q`` (M, n) rad, ``approach`` (M, n) sign of the last move of every joint, ``rotation`` (M, 3, 3) of the TCP."""

    q: Floats
    approach: Floats
    rotation: Floats

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"PosturePool({len(self)})"


def link_frames(robot: Robot, q: Floats) -> Floats:
    """(n, M, 4, 4) link frames L_1 ... L_n of the nominal arm in the base."""
    out, pose = [], np.tile(np.eye(4), (len(q), 1, 1))
    for k in range(robot.n):
        turn = np.tile(np.eye(4), (len(q), 1, 1))
        turn[:, :3, :3] = Rotation.from_rotvec(q[:, k, None] * robot.axis[k]).as_matrix()
        pose = pose @ robot.before[k] @ turn @ robot.after[k]
        out.append(pose)
    return np.array(out)


def reachable_postures(robot: Robot, tool: Tool, count: int, seed: int) -> PosturePool:
    """Random postures, the same for the same seed.

    Raises:
        StiffnessError: hardly any posture is free.
    """
    rng = np.random.default_rng(seed)
    low, high = np.maximum(robot.lower, -np.pi) + MARGIN, np.minimum(robot.upper, np.pi) - MARGIN
    if np.any(low >= high):
        raise StiffnessError(f"robot {robot.name}: joint {int(np.argmax(low >= high)) + 1} moves less than 10 deg")
    bent, aside = Conditioning(robot), COLUMN * 2 * half_reach(robot)
    found: list[Floats] = []
    for _ in range(BATCHES):
        q = rng.uniform(low, high, (BATCH, robot.n))
        frames = link_frames(robot, q)
        tcp = frames[-1] @ np.append(tool.position, 1.0)
        height = np.minimum(frames[1:, :, 2, 3].min(axis=0), tcp[:, 2])
        away = np.minimum(np.hypot(tcp[:, 0], tcp[:, 1]), np.hypot(frames[-1, :, 0, 3], frames[-1, :, 1, 3]))
        found.append(q[(height > FLOOR) & (away > aside) & (bent(q) > BENT)])
        if sum(map(len, found)) >= count:
            break
    q = np.concatenate(found)[:count]
    if len(q) < min(count, 20):
        raise StiffnessError(
            f"robot {robot.name}: only {len(q)} of {BATCH * BATCHES} random postures are above the floor, clear of the "
            "base and bent; check the tool (m) and the robot's base frame (z up)"
        )
    approach = rng.choice([-1.0, 1.0], size=q.shape)
    return PosturePool(q, approach, link_frames(robot, q)[-1][:, :3, :3] @ tool.rotation)
