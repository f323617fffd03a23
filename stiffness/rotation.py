"""Rotations in numbers: roll, pitch, yaw and rotation vectors to matrices and back, cross products as matrices."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_TURN = 2 * np.pi


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


def skew(vector: Floats) -> Floats:
    """(N, 3, 3) matrices [v]x of vectors (N, 3): [v]x u = v x u."""
    x, y, z = vector.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)


def antisymmetric(matrix: Floats) -> Floats:
    """(..., 3) vector of M - M^T, so that [v]x = M - M^T: 2 sin(angle) axis for a rotation matrix (..., 3, 3)."""
    m = matrix
    return np.stack([m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], axis=-1)


def rotation_vector(rotation: Floats) -> Floats:
    """(N, 3) rotation vectors, rad, of rotation matrices (N, 3, 3)."""
    m = rotation
    spin = antisymmetric(m) / 2
    sine, cosine = np.linalg.norm(spin, axis=1), (np.trace(m, axis1=1, axis2=2) - 1) / 2
    angle = np.arctan2(sine, cosine)
    scale = np.where(sine > 1e-9, angle / np.maximum(sine, 1e-300), 1.0)
    vector = spin * scale[:, None]
    half = (sine <= 1e-6) & (cosine < 0)  # near half a turn the axis stands in the symmetric part
    for k in np.flatnonzero(half):
        symmetric = (m[k] + np.eye(3)) / 2
        column = symmetric[:, int(np.argmax(np.diag(symmetric)))]
        vector[k] = angle[k] * column / np.linalg.norm(column)
    return np.asarray(vector)


def from_rotation_vector(vector: Floats) -> Floats:
    """(N, 3, 3) rotation matrices of rotation vectors (N, 3) rad (Rodrigues)."""
    angle = np.linalg.norm(vector, axis=1)[:, None, None]
    cross = skew(vector)
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / _TURN) ** 2 * (cross @ cross))
