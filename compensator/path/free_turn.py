"""The turn about the tool axis that a CAM file leaves open."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from compensator.path.cheapest_turn import cheapest_turn
from toolpaths.columns import blocks
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_unit_quaternion
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

KEYS = 250  # poses that the dynamic program decides on; the turn is linear in between
GRID = 72  # turns per pose, 5 deg apart
BEND = 0.2  # price of a grid step squared, beside exp(-4 margin) of a posture
FASTEST = 3  # grid steps that the turn may change between two keys


def reference_rotation(toolpath: Toolpath) -> Floats:
    """TCP rotation (N, 3, 3) in the work object: the file's, or one with z = -axis and a continuous x.

    x is a fixed direction projected normal to z, the one of x, y, z that stays farthest from the
    axis; where the axis passes every one of them x is carried along without turning about z.
    """
    return reference_rotations(toolpath)(np.arange(len(toolpath)))


def reference_rotations(toolpath: Toolpath) -> Callable[[Rows], Floats]:
    """``reference_rotation`` of some poses: rows (K,) -> (K, 3, 3)."""
    if (given := toolpath.quaternion) is not None:
        return lambda rows: matrix_from_unit_quaternion(given[rows])
    axis, guide = toolpath.axis, steadiest_guide(toolpath)
    if guide is None:
        carried = _carried(-axis)
        return lambda rows: _with_axes(carried[rows], -axis[rows])
    best = int(np.argmax(guide))

    def guided(rows: Rows) -> Floats:
        z = -axis[rows]
        x = guide - z * z[:, best : best + 1]
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        return _with_axes(x, z)

    return guided


def steadiest_guide(toolpath: Toolpath) -> Floats | None:
    """(3,) the one of x, y, z that stays farthest from the tool axes; None: they pass every one of them."""
    axis = toolpath.axis
    nearest = np.max([np.abs(axis[b]).max(axis=0) for b in blocks(len(axis))], axis=0)
    best = int(np.argmin(nearest))
    return None if nearest[best] >= 0.97 else np.eye(3)[best]


def _with_axes(x: Floats, z: Floats) -> Floats:
    return np.stack([x, np.cross(z, x), z], axis=2)


def _carried(z: Floats) -> Floats:
    """x (N, 3) normal to z, each the one before with the least turn."""
    x = np.empty_like(z)
    guide = np.eye(3)[int(np.argmin(np.abs(z[0])))]
    changed = np.concatenate([[True], np.any(z[1:] != z[:-1], axis=1)])
    for k in np.flatnonzero(changed):
        guide = guide - z[k] * (guide @ z[k])
        guide /= np.linalg.norm(guide)
        x[k] = guide
    return np.asarray(x[np.maximum.accumulate(np.where(changed, np.arange(len(z)), 0))])


def about_tool_axis(tcp: Frame, turn: float | Floats) -> Frame:
    """TCP frames (N) turned about their own z by one angle or (N,), rad."""
    angle = np.asarray(turn)
    if angle.ndim == 0 or angle.strides == (0,):  # one for all
        same = about_z(float(angle.flat[0]))
        return tcp.turned(lambda rows: same)
    return tcp.turned(lambda rows: about_z(angle[rows]))


def about_z(angle: float | Floats) -> Floats:
    """Rotation(s) about z: (3, 3), or (N, 3, 3) for an array."""
    c, s = np.cos(angle), np.sin(angle)
    zero, one = np.zeros_like(c), np.ones_like(c)
    return np.stack([np.stack([c, -s, zero], -1), np.stack([s, c, zero], -1), np.stack([zero, zero, one], -1)], -2)


def varying_turn(
    toolpath: Toolpath, margins: Callable[[npt.NDArray[np.intp], Floats], Floats]
) -> Floats | None:
    """Turn (N,) rad along the path that stays inside the reach, by dynamic programming.

    Args:
        margins: (rows, turns) -> (rows, turns) margin, -inf where a turn cannot be reached.

    Returns:
        None where no continuous turn exists on the grid.
    """
    rows = np.unique(np.linspace(0, len(toolpath) - 1, KEYS).astype(np.intp))
    turns = np.linspace(0, 2 * np.pi, GRID, endpoint=False)
    margin = margins(rows, turns)
    # the price of a posture falls with its margin; turning costs as well
    price = np.where(margin > -np.inf, np.exp(-4 * np.clip(margin, -1, 1)), np.inf)
    columns = cheapest_turn(price, lambda _, step: BEND * step * step, FASTEST)
    return None if columns is None else np.interp(np.arange(len(toolpath)), rows, columns * (2 * np.pi / GRID))
