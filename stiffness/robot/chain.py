"""Chain: what a robot file says, before it becomes a Robot. What the fields mean stands in ``Robot``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.robot.reducer import Reducer

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Chain:
    """Placements, limits and masses of a serial arm, as in ``Robot``."""

    joint_names: tuple[str, ...]
    before: Floats
    axis: Floats
    after: Floats
    lower: Floats
    upper: Floats
    velocity: Floats
    mass: Floats | None
    com: Floats | None
    mass_problem: str
    assumptions: tuple[str, ...]
    sources: tuple[str, ...]
    base: str
    tip: str
    reducers: tuple[Reducer | None, ...] | None = None


def placement(rotation: Floats, origin: npt.ArrayLike) -> Floats:
    """(4, 4) homogeneous matrix."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = origin
    return matrix


def rpy_rotation(roll: float, pitch: float, yaw: float) -> Floats:
    """R = Rz(yaw) Ry(pitch) Rx(roll), rad."""
    cr, sr = _cos_sin(roll)
    cp, sp = _cos_sin(pitch)
    cy, sy = _cos_sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _cos_sin(angle: float) -> tuple[float, float]:
    # cos(pi/2) is 6e-17: exact quarter turns keep zeros in the symbolic chain.
    c, s = float(np.cos(angle)), float(np.sin(angle))
    return (0.0 if abs(c) < 1e-15 else c), (0.0 if abs(s) < 1e-15 else s)
