"""Residuals of a load state as motion: rotation of a joint, or displacement of a place, by least squares."""

from __future__ import annotations

import numpy as np

from compensator.report.analysis.session_residuals import Bools, Floats, Index, SessionResiduals

STEADY = 0.3  # of the largest lever: below, a state determines a rotation badly
SINGULAR = 0.05  # of the largest singular value: motions that the reflectors determine worse are taken as zero


def joint_rotation(one: SessionResiduals, rows: Index, j: int, vectors: Floats) -> tuple[Floats, Bools]:
    """Rotation (S,) rad of a joint in every state, and which states determine it.

    Args:
        rows: readings, and ``vectors`` (M, 3) m of each, in the base.
    """
    lever = lever_of(one, rows, j)
    of, count = one.session.states.of[rows], len(one.session.states)
    square = np.bincount(of, (lever**2).sum(axis=1), count)
    along = np.bincount(of, (lever * vectors).sum(axis=1), count)
    readings = np.maximum(np.bincount(of, minlength=count), 1)
    told = square / readings > STEADY**2 * np.max(square / readings, initial=0.0)
    return np.where(told, along / np.where(told, square, 1.0), 0.0), told & (square > 0)


def lever_of(one: SessionResiduals, rows: Index, j: int) -> Floats:
    """(M, 3) m/rad: how readings move when a joint turns."""
    moved = np.cross(one.arm.axis[rows, j], one.reflector[rows] - one.arm.pivot[rows, j])
    return np.where((one.link[rows] > j)[:, None], moved, 0.0)


def place_displacement(
    one: SessionResiduals, rows: Index, place: int, vectors: Floats
) -> tuple[Floats, float, Bools]:
    """Displacement (S, 6) m and rad of a place in every state, in its axes; its typical lever, m; which states have it.

    Args:
        place: 0 base ... n flange.
        rows: readings, and ``vectors`` (M, 3) m of each, in the base.
    """
    axes, origin = one.arm.links.rotation[rows, place], one.arm.links.origin[rows, place]
    arm = np.einsum("nji,nj->ni", axes, one.reflector[rows] - origin)
    mine = one.link[rows] >= place
    lever = float(np.sqrt(np.mean((arm[mine] ** 2).sum(axis=1)))) if mine.any() else 1.0
    local = np.einsum("nji,nj->ni", axes, vectors)
    rotated = np.stack([np.cross(np.eye(3)[c], arm) for c in range(3)], axis=2) / lever
    design = np.concatenate([np.tile(np.eye(3), (len(arm), 1, 1)), rotated], axis=2)
    of, count = one.session.states.of[rows], len(one.session.states)
    out, told = np.zeros((count, 6)), np.zeros(count, dtype=bool)
    for k in range(count):
        of_state = np.flatnonzero((of == k) & mine)
        if len(of_state) > 1:
            solved = np.linalg.lstsq(design[of_state].reshape(-1, 6), local[of_state].reshape(-1), rcond=SINGULAR)[0]
            out[k], told[k] = solved / np.repeat([1.0, lever], 3), True
    return out, lever, told
