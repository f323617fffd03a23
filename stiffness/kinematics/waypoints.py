"""Waypoints: poses inserted into a path where it moves far, and the knots at which Newton steps begin anew."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.poses import PoseArray, Poses
from stiffness.rotation import from_rotation_vector, rotation_vector

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_KNOT = (4096, 0.05, 0.1)  # poses, m and rad from one knot to the next at most


def densified(poses: Poses) -> tuple[PoseArray, Ints]:
    """The path with poses put in, on the straight line, where it moves far; rows of the given poses."""
    rotation, origin = poses.rotation, poses.origin
    turn = rotation_vector(rotation[1:] @ rotation[:-1].swapaxes(1, 2))
    move = np.diff(origin, axis=0)
    parts = np.maximum(np.linalg.norm(move, axis=1) / _KNOT[1], np.linalg.norm(turn, axis=1) / _KNOT[2])
    parts = np.maximum(np.ceil(parts), 1).astype(np.int64)
    rows = np.concatenate([[0], np.cumsum(parts)])
    if rows[-1] == len(move):
        return PoseArray(rotation, origin), rows
    r, p = np.empty((rows[-1] + 1, 3, 3)), np.empty((rows[-1] + 1, 3))
    r[rows], p[rows] = rotation, origin
    for k in np.flatnonzero(parts > 1):
        share = np.arange(1, parts[k])[:, None] / parts[k]
        inner = slice(rows[k] + 1, rows[k + 1])
        p[inner] = origin[k] + share * move[k]
        r[inner] = from_rotation_vector(share * turn[k]) @ rotation[k]
    return PoseArray(r, p), rows


def knots_of(poses: Poses) -> Ints:
    """Rows from the first to the last pose, no two farther apart than _KNOT."""
    rotation, origin = poses.rotation, poses.origin
    turn = np.linalg.norm(rotation_vector(rotation[1:] @ rotation[:-1].swapaxes(1, 2)), axis=1)
    share = np.maximum(np.linalg.norm(np.diff(origin, axis=0), axis=1) / _KNOT[1], turn / _KNOT[2])
    way = np.concatenate([[0.0], np.cumsum(np.maximum(share, 1 / _KNOT[0]))])
    rows = np.flatnonzero(np.diff(np.floor(way))) + 1
    return np.unique(np.concatenate([[0], rows, [len(origin) - 1]])).astype(np.int64)
