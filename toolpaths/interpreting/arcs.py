"""Arcs of robot programs: the circle through three points, and its points where the arc becomes poses."""

from __future__ import annotations

from typing import NoReturn

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.reading.arc_points import arc_points, chord_count
from toolpaths.reading.track import LIMIT, most_poses
from toolpaths.rotation import slerp_quaternion
from toolpaths.toolpath import Floats, Toolpath

Ints64 = npt.NDArray[np.int64]
_FLAT = 1e-9  # sine below which three points of an arc are on a line


def with_arc_points(toolpath: Toolpath, arcs: Ints64, via: Floats, chord: float) -> Toolpath:
    """A toolpath of whole moves, with quaternions, with the points of those that are arcs put in.

    Args:
        arcs: (K,) the poses that an arc from the pose before leads to.
        via: (K, 3) m, what they pass.
        chord: m, within which the points stay.

    Raises:
        ReadError: points on a line, or arcs that would fill the memory.
    """
    turned = toolpath.quaternion
    if turned is None or not len(arcs):
        return toolpath
    ends = toolpath.position
    center, normal, sweep, _, flat = circle_through(ends[arcs - 1], via, ends[arcs])
    if flat.any():
        problem = "start, via point and end of the arc are on one line"
        _refuse(toolpath, int(arcs[np.argmax(flat)]), problem, "Use a straight move, or two arcs.")
    radius = np.linalg.norm(ends[arcs] - center, axis=1)
    too_wide = not (radius <= LIMIT).all()
    if too_wide or (total := int(chord_count(radius, sweep, chord).sum())) > most_poses(len(ends)):
        at = int(arcs[np.argmax(radius)])
        problem = f"an arc of radius {radius.max():g} m" + ("" if too_wide else f"; all arcs make {total} poses")
        _refuse(toolpath, at, problem, "Use a straight move instead.")
    points = arc_points(ends[arcs - 1], end=ends[arcs], center=center, normal=normal, sweep=sweep, chord=chord)
    end = arcs[points.arc]
    quaternion = slerp_quaternion(turned[end - 1], turned[end], points.fraction)
    return toolpath.with_points(end, toolpath.row[end] - 1 + points.fraction, points.position, quaternion)


def _refuse(toolpath: Toolpath, pose: int, problem: str, remedy: str) -> NoReturn:
    source = toolpath.source if toolpath.file is None else toolpath.sources[toolpath.file[pose]]
    raise ReadError(source, int(toolpath.line[pose]), problem, remedy)


def with_arcs(toolpath: Toolpath) -> Toolpath:
    """A toolpath whose poses are all known by now, with the points of the arcs that started from joint angles.

    Raises:
        ReadError: as ``with_arc_points``.
    """
    setting = toolpath.setting
    if setting is None or not setting.arcs:
        return toolpath
    at = np.searchsorted(toolpath.row, np.array(list(setting.arcs), dtype=np.float64))
    via = np.array([point for point, _ in setting.arcs.values()])
    chord = min(tolerance for _, tolerance in setting.arcs.values())
    return with_arc_points(toolpath, at.astype(np.int64), via, chord)


def circle_through(
    start: Floats, via: Floats, end: Floats
) -> tuple[Floats, Floats, Floats, Floats, npt.NDArray[np.bool_]]:
    """Circles through three points (K, 3) each: center, normal (K, 3), sweep (K,) rad start to end, share of the sweep
    (K,) at ``via``, and (K,) whether the points are on a line."""
    a, b = via - start, end - start
    normal = np.cross(a, b)
    size = np.linalg.norm(normal, axis=1)
    flat = ~(size > _FLAT * np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        lever = np.sum(a * a, axis=1)[:, None] * b - np.sum(b * b, axis=1)[:, None] * a
        center = start + np.cross(lever, normal) / (2.0 * size * size)[:, None]
        normal = normal / size[:, None]
    out = start - center
    angles = []
    for point in (via, end):
        arm = point - center
        sine = np.sum(np.cross(out, arm) * normal, axis=1)
        angles.append(np.arctan2(sine, np.sum(out * arm, axis=1)) % (2.0 * np.pi))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = angles[0] / angles[1]
    return center, normal, angles[1], share, flat | ~(angles[1] > 0.0)
