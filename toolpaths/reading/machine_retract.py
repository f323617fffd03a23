"""Retracts to places of the machine: they are no poses, so the way that is left must lead around what is cut.

A controller draws the tool back along its axis to the end of the travel, and brings it back along its axis. Where the
straight way between the poses around such a retract runs through the box of all cuts, poses are put in that do the
same, as far out as needed; where it does not, the way stays straight.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, Floats, Toolpath

FACE = 1e-6  # m
CLEAR = 0.01  # m that the way keeps from the box of what is cut
STEPS = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0)  # of the diagonal of the box: how far out it is tried


class MachineRetract(NamedTuple):
    """A retract of the file: how many moves come before it, its line, its words."""

    moves: int
    line: int
    words: str


def around_the_cuts(path: Toolpath, retracts: list[MachineRetract]) -> Toolpath:
    """The path with poses put in where a retract would otherwise lead through what is cut.

    Raises:
        ReadError: no way along the tool axes leads around it.
    """
    after = {int(np.searchsorted(path.row, r.moves - 1e-9)): r for r in reversed(retracts)}
    inner = sorted(k for k in after if 0 < k < len(path))
    cut = _cuts(path)
    if not inner or not len(cut):
        return path
    before, to = np.array(inner) - 1, np.array(inner)
    box = _box(path, np.union1d(cut, np.maximum(cut - 1, 0)))  # where cuts begin, and where they end
    inside = _through(path.position[before], path.position[to], _box(path, cut))
    inside |= _through(path.position[before], path.position[to], _inset(box))
    ends, rows, places, axes = [], [], [], []
    for k in to[inside]:
        for share, (place, axis) in zip((1 / 3, 2 / 3), _detour(path, int(k), box, after[int(k)]), strict=True):
            ends.append(k)
            rows.append(path.row[k - 1] + share * (path.row[k] - path.row[k - 1]))
            places.append(place)
            axes.append(axis)
    if not ends:
        return path
    return path.with_points(np.array(ends), np.array(rows), np.array(places), np.array(axes))


def _cuts(path: Toolpath) -> npt.NDArray[np.intp]:
    """Poses that end a cut; moves that only draw back along the tool axis are none."""
    step = np.diff(path.position, axis=0, prepend=path.position[:1])
    along = np.einsum("ij,ij->i", step, path.axis)
    back = (along > 0) & (np.linalg.norm(step - along[:, None] * path.axis, axis=1) <= 1e-9)
    return np.flatnonzero((path.kind == CUT) & ~back)


def _box(path: Toolpath, poses: npt.NDArray[np.intp]) -> Floats:
    """(2, 3) lowest and highest corner of poses."""
    return np.array([path.position[poses].min(axis=0), path.position[poses].max(axis=0)])


def _inset(box: Floats) -> Floats:
    """Without its faces: cuts begin there, on the clearance plane."""
    inset = np.minimum((box[1] - box[0]) / 2, FACE)
    return np.array([box[0] + inset, box[1] - inset])


def _through(start: Floats, end: Floats, box: Floats) -> npt.NDArray[np.bool_]:
    """(N,) whether straight ways (N, 3) touch the box."""
    way = end - start
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.stack([(box[0] - start) / way, (box[1] - start) / way])
    enter, leave = t.min(axis=0), t.max(axis=0)
    still, within = way == 0, (start >= box[0]) & (start <= box[1])
    enter, leave = np.where(still, np.where(within, -np.inf, np.inf), enter), np.where(still, np.inf, leave)
    return np.asarray(np.maximum(enter.max(axis=1), 0.0) <= np.minimum(leave.min(axis=1), 1.0))


def _detour(path: Toolpath, k: int, box: Floats, retract: MachineRetract) -> list[tuple[Floats, Floats]]:
    """Place and tool axis of both poses to put in before pose ``k``."""
    axes = path.axis[[k - 1, k]]
    diagonal = float(np.linalg.norm(box[1] - box[0]))
    wide = box + CLEAR / 2 * np.array([[-1.0], [1.0]])
    corners = np.array([[box[i, 0], box[j, 1], box[m, 2]] for i in (0, 1) for j in (0, 1) for m in (0, 1)])
    top = (corners @ axes.T).max(axis=0) + CLEAR
    height = np.einsum("ij,ij->i", path.position[[k - 1, k]], axes)
    for step in STEPS:
        out = path.position[[k - 1, k]] + np.maximum(top + step * diagonal - height, 0.0)[:, None] * axes
        if not _through(out[:1], out[1:], wide)[0]:
            return [(out[0], axes[0]), (out[1], axes[1])]
    problem = f"{retract.words} is no place in the work object, and no way along the tool axes leads around what is cut"
    raise ReadError(path.source, retract.line, problem, "Add rapids around the part between the two poses.")
