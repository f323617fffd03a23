"""Rotations in numbers: roll, pitch, yaw and rotation vectors to matrices and back, cross products as matrices."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


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
