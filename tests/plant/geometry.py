"""Rigid motions of the plant: its own few formulas, shared with nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def rot_x(angle: float) -> Array:
    """(4,4) turn about x, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


def rot_y(angle: float) -> Array:
    """(4,4) turn about y, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])


def rot_z(angle: float) -> Array:
    """(4,4) turn about z, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def shift(xyz: ArrayLike) -> Array:
    """(4,4) translation, m."""
    out = np.eye(4)
    out[:3, 3] = np.asarray(xyz, dtype=float)
    return out


def placement(xyz: ArrayLike = (0, 0, 0), rpy: ArrayLike = (0, 0, 0)) -> Array:
    """(4,4) from m and fixed-axis roll, pitch, yaw in rad."""
    roll, pitch, yaw = np.asarray(rpy, dtype=float)
    return shift(xyz) @ rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)


def rigid_inverse(T: Array) -> Array:
    """Inverse of a rigid (4,4)."""
    out = np.eye(4)
    out[:3, :3] = T[:3, :3].T
    out[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return out


def rotation_vector(R: Array) -> Array:
    """(3,) axis times angle of a (3,3) rotation, rad; angles up to just below pi."""
    twice_sine = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = np.linalg.norm(twice_sine) / 2
    angle = np.arctan2(sine, (np.trace(R) - 1) / 2)
    factor = 0.5 if sine < 1e-9 else angle / (2 * sine)
    out: Array = twice_sine * factor
    return out


def turn(vector: ArrayLike) -> Array:
    """(3,3) rotation about a (3,) vector by its length in rad (Rodrigues)."""
    v = np.asarray(vector, dtype=float)
    angle = float(np.linalg.norm(v))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = v / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    out: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return out


def between(start: Array, end: Array, share: float) -> Array:
    """(4,4) pose at `share` (0..1) of a linear move: straight position, slerp orientation."""
    out = np.eye(4)
    out[:3, 3] = (1 - share) * start[:3, 3] + share * end[:3, 3]
    out[:3, :3] = start[:3, :3] @ turn(share * rotation_vector(start[:3, :3].T @ end[:3, :3]))
    return out


def pose_error(actual: Array, wanted: Array) -> tuple[float, float]:
    """Distance (m) and angle (rad) between two (4,4) poses."""
    angle = np.linalg.norm(rotation_vector(wanted[:3, :3].T @ actual[:3, :3]))
    return float(np.linalg.norm(actual[:3, 3] - wanted[:3, 3])), float(angle)
