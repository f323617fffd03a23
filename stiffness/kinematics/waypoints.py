"""Paths of poses: what lies between two of them, and where to stop on the way."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_TURN = 2 * np.pi
_KNOT = (4096, 0.05, 0.1)  # poses, m and rad from one knot to the next at most


def rotation_vector(rotation: Floats) -> Floats:
    """(N, 3) rotation vectors, rad, of rotation matrices (N, 3, 3)."""
    m = rotation
    spin = np.stack([m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]], axis=1) / 2
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


def densified(rotation: Floats, origin: Floats) -> tuple[Floats, Floats, Ints]:
    """The path with poses put in, on the straight line, where it moves far; rows of the given poses."""
    turn = rotation_vector(rotation[1:] @ rotation[:-1].swapaxes(1, 2))
    move = np.diff(origin, axis=0)
    parts = np.maximum(np.linalg.norm(move, axis=1) / _KNOT[1], np.linalg.norm(turn, axis=1) / _KNOT[2])
    parts = np.maximum(np.ceil(parts), 1).astype(np.int64)
    rows = np.concatenate([[0], np.cumsum(parts)])
    if rows[-1] == len(move):
        return rotation, origin, rows
    r, p = np.empty((rows[-1] + 1, 3, 3)), np.empty((rows[-1] + 1, 3))
    r[rows], p[rows] = rotation, origin
    for k in np.flatnonzero(parts > 1):
        share = np.arange(1, parts[k])[:, None] / parts[k]
        inner = slice(rows[k] + 1, rows[k + 1])
        p[inner] = origin[k] + share * move[k]
        r[inner] = _from_vectors(share * turn[k]) @ rotation[k]
    return r, p, rows


def _from_vectors(vector: Floats) -> Floats:
    """(N, 3, 3) rotation matrices of rotation vectors (Rodrigues)."""
    angle = np.linalg.norm(vector, axis=1)[:, None, None]
    x, y, z = vector.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    return np.asarray(
        np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / _TURN) ** 2 * (cross @ cross)
    )


def knots_of(rotation: Floats, origin: Floats) -> Ints:
    """Rows from the first to the last pose, no two farther apart than _KNOT."""
    turn = np.linalg.norm(rotation_vector(rotation[1:] @ rotation[:-1].swapaxes(1, 2)), axis=1)
    share = np.maximum(np.linalg.norm(np.diff(origin, axis=0), axis=1) / _KNOT[1], turn / _KNOT[2])
    way = np.concatenate([[0.0], np.cumsum(np.maximum(share, 1 / _KNOT[0]))])
    rows = np.flatnonzero(np.diff(np.floor(way))) + 1
    return np.unique(np.concatenate([[0], rows, [len(origin) - 1]])).astype(np.int64)
