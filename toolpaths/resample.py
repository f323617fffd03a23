"""Long moves become short ones: positions along the straight line, orientations along the shortest turn."""

from __future__ import annotations

import math

import numpy as np

from toolpaths.errors import ReadError, ToolpathError
from toolpaths.rotation import slerp, slerp_quaternion
from toolpaths.toolpath import Floats, Rows, Toolpath

ANGLE = math.radians(0.1)
MOST_POSES = 2_000_000  # or four for each pose of the file: beyond, a run takes minutes and more than 4 GB
_ROUNDING = 1e-6  # a move may be longer than allowed by this share, so that sampling twice changes nothing
_OPPOSITE = math.pi - 1e-4  # rad; two axes this far apart have no shortest turn


def resample(path: Toolpath, *, spacing: float, angle: float = ANGLE) -> Toolpath:
    """Put poses into long moves, rapids included; every pose of ``path`` stays as it is.

    Where the tool axis (or, if given, the orientation) turns, a move turns by at most ``theta`` with
    ``theta^2 / 8 <= angle``: a controller that takes another way between the same two orientations strays
    by no more than that (the sagitta of an arc of radius 1). Poses put in carry feed, kind, tool and line of
    the move's end, and the fraction of the way in ``row``. Sampling a sampled path changes nothing.

    Args:
        path: any toolpath.
        spacing: largest distance between poses, m.
        angle: how far the orientation between poses may stray, rad.

    Raises:
        ToolpathError: the tool axis reverses within one move (which way is unknown), or too many poses.
        ValueError: ``spacing`` or ``angle`` is not positive.
    """
    if not (spacing > 0.0 and angle > 0.0):
        raise ValueError(f"spacing = {spacing}, angle = {angle}: both must be above 0")
    if len(path) < 2:
        return path
    turn = _turns(path)
    length = np.linalg.norm(np.diff(path.position, axis=0), axis=1)
    with np.errstate(over="ignore"):
        parts = np.maximum(length / spacing, turn / math.sqrt(8.0 * angle))
    most, poses = max(MOST_POSES, 4 * len(path)), float(np.maximum(parts, 1.0).sum())
    if poses > most:
        by_turn = turn.sum() / math.sqrt(8.0 * angle) > length.sum() / spacing
        wanted, enough = f"a spacing of {spacing * 1e3:g} mm", f"{spacing * poses / most * 1e3:.2g} mm"
        if by_turn:
            wanted, enough = f"an angle of {_deg(angle)}", _deg(angle * (poses / most) ** 2)
        what = f"{wanted} makes {poses:,.0f} poses; at most {most:,} are computed in one run"
        raise ToolpathError(f"{path.source}: {what}: take more than {enough}, or split the file")
    count = np.maximum(np.ceil(parts - _ROUNDING), 1.0).astype(np.intp)
    return path if count.max() == 1 else in_parts(path, count)


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.2g} deg"


def _turns(path: Toolpath) -> Floats:
    """Angle (N - 1,) rad between neighbours; from the chord, which is exact for small angles too."""
    if path.quaternion is not None:
        a, b = path.quaternion[:-1], path.quaternion[1:]
        chord = np.minimum(np.linalg.norm(b - a, axis=1), np.linalg.norm(b + a, axis=1))
        quarter: Floats = 4.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
        return quarter
    chord = np.linalg.norm(np.diff(path.axis, axis=0), axis=1)
    turn: Floats = 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
    if turn.max() > _OPPOSITE:
        line = int(path.line[int(np.argmax(turn)) + 1])
        problem = "the tool axis turns to its opposite within one move: which way round is not known"
        raise ReadError(path.source, line, problem, "Put a pose with an axis between the two before it.")
    return turn


def in_parts(path: Toolpath, count: Rows) -> Toolpath:
    """The path with move m (from pose m to m + 1) in ``count[m]`` parts."""
    move = np.repeat(np.arange(len(count)), count - 1)
    first = np.concatenate([[0], np.cumsum(count - 1)])[:-1]  # of the poses of each move
    share = (np.arange(len(move)) - first[move] + 1) / count[move]
    position = path.position[move] + share[:, None] * (path.position[move + 1] - path.position[move])
    row = path.row[move] + share * (path.row[move + 1] - path.row[move])
    if path.quaternion is None:
        orientation = slerp(path.axis[move], path.axis[move + 1], share)
    else:
        orientation = slerp_quaternion(path.quaternion[move], path.quaternion[move + 1], share)
    return path.with_points(move + 1, row, position, orientation)
