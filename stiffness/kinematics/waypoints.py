"""Waypoints: poses inserted into a path where it moves far, and the knots at which Newton steps begin anew."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.poses import PoseArray, Poses
from stiffness.rotation import from_rotation_vector, rotation_vector

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_KNOT = (4096, 0.05, 0.1)  # poses, m and rad from one knot to the next at most


def inserted(poses: Poses) -> Ints:
    """(N - 1,) in how many parts each move is divided, 1: nothing is put in."""
    turn, move = _moves(poses)
    parts = np.maximum(np.linalg.norm(move, axis=1) / _KNOT[1], np.linalg.norm(turn, axis=1) / _KNOT[2])
    return np.asarray(np.maximum(np.ceil(parts), 1).astype(np.int64))


def densified(poses: Poses, parts: Ints) -> tuple[PoseArray, Ints]:
    """The path with each move divided into ``parts`` (N - 1,) on the straight line; rows of the given poses."""
    rotation, origin = poses.rotation, poses.origin
    rows = np.concatenate([[0], np.cumsum(parts)])
    if rows[-1] == len(parts):
        return PoseArray(rotation, origin), rows
    turn, move = _moves(poses)
    r, p = np.empty((rows[-1] + 1, 3, 3)), np.empty((rows[-1] + 1, 3))
    r[rows], p[rows] = rotation, origin
    for k in np.flatnonzero(parts > 1):
        share = np.arange(1, parts[k])[:, None] / parts[k]
        inner = slice(rows[k] + 1, rows[k + 1])
        p[inner] = origin[k] + share * move[k]
        r[inner] = from_rotation_vector(share * turn[k]) @ rotation[k]
    return PoseArray(r, p), rows


def shares(poses: Poses) -> Floats:
    """(N - 1,) which share of the way from one knot to the next each move is."""
    turn, move = _moves(poses)
    return np.asarray(
        np.maximum(np.linalg.norm(move, axis=1) / _KNOT[1], np.linalg.norm(turn, axis=1) / _KNOT[2])
    )


def knots_of(share: Floats) -> Ints:
    """Rows from the first to the last pose, no two farther apart than _KNOT; ``share`` (N - 1,) of every move."""
    way = np.concatenate([[0.0], np.cumsum(np.maximum(share, 1 / _KNOT[0]))])
    rows = np.flatnonzero(np.diff(np.floor(way))) + 1
    return np.unique(np.concatenate([[0], rows, [len(share)]])).astype(np.int64)


def _moves(poses: Poses) -> tuple[Floats, Floats]:
    """From each pose to the next: turns (N - 1, 3) rad and ways (N - 1, 3) m."""
    rotation = poses.rotation
    return rotation_vector(rotation[1:] @ rotation[:-1].swapaxes(1, 2)), np.diff(poses.origin, axis=0)
