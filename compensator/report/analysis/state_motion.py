"""Residuals of a load state as motion: rotation of a joint, or motion of a place, by least squares."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.diagnosis import Bools, Floats, Looked

Index = npt.NDArray[np.intp]
STEADY = 0.3  # of the largest lever: below, a state says little of a rotation
SINGULAR = 0.05  # of the largest singular value: motions that reflectors tell less of are taken as none


def turn(seen: Looked, rows: Index, j: int, vectors: Floats) -> tuple[Floats, Bools]:
    """Rotation (S,) rad of a joint in every state, least squares over its readings, and which states tell."""
    lever = lever_of(seen, rows, j)
    of, count = seen.session.states.of[rows], len(seen.session.states)
    square = np.bincount(of, (lever**2).sum(axis=1), count)
    along = np.bincount(of, (lever * vectors).sum(axis=1), count)
    readings = np.maximum(np.bincount(of, minlength=count), 1)
    told = square / readings > STEADY**2 * np.max(square / readings, initial=0.0)
    return np.where(told, along / np.where(told, square, 1.0), 0.0), told & (square > 0)


def lever_of(seen: Looked, rows: Index, j: int) -> Floats:
    """(M, 3) m/rad: how readings move when a joint turns."""
    g, s = seen.geometry, seen.session
    link = np.array([r.link for r in s.reflectors])[s.samples.reflector[rows]]
    moved = np.cross(g.axis[rows, j], g.point[rows] - g.pivot[rows, j])
    return np.where((link > j)[:, None], moved, 0.0)


def twist(seen: Looked, rows: Index, number: int, vectors: Floats) -> tuple[Floats, float, Bools]:
    """Motion (S, 6) m and rad of a place in every state, in its axes; its typical lever, m; which states tell."""
    g, s = seen.geometry, seen.session
    link = np.array([r.link for r in s.reflectors])[s.samples.reflector[rows]]
    axes, origin = g.rotation[rows, number], g.origin[rows, number]
    arm = np.einsum("nji,nj->ni", axes, g.point[rows] - origin)
    mine = link >= number
    lever = float(np.sqrt(np.mean((arm[mine] ** 2).sum(axis=1)))) if mine.any() else 1.0
    local = np.einsum("nji,nj->ni", axes, vectors)
    rotated = np.stack([np.cross(np.eye(3)[c], arm) for c in range(3)], axis=2) / lever
    design = np.concatenate([np.tile(np.eye(3), (len(arm), 1, 1)), rotated], axis=2)
    of, count = s.states.of[rows], len(s.states)
    out, told = np.zeros((count, 6)), np.zeros(count, dtype=bool)
    for k in range(count):
        of_state = np.flatnonzero((of == k) & mine)
        if len(of_state) > 1:
            solved = np.linalg.lstsq(design[of_state].reshape(-1, 6), local[of_state].reshape(-1), rcond=SINGULAR)[0]
            out[k], told[k] = solved / np.repeat([1.0, lever], 3), True
    return out, lever, told


def place_number(where: str, joints: int) -> int:
    """0 base ... n flange of a place in words; -1 for what is none."""
    names = {"base": 0, "tool": joints} | {f"link-{k}": k for k in range(1, joints)}
    return names.get(where, -1)
