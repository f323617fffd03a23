"""Poses put between two others: at flank changes and just before corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from toolpaths.axis_ways import AxisWays
from toolpaths.frame import Frame
from toolpaths.rotation import (
    matrix_from_quaternion,
    matrix_from_unit_quaternion,
    quaternion_from_matrix,
    slerp,
    slerp_quaternion,
)
from toolpaths.toolpath import CUT, Rows, Toolpath

Floats = npt.NDArray[np.float64]

CORNER = np.cos(np.radians(15.0))  # a sharper turn of the feed gets a pose before it
BEFORE_CORNER = 5e-5  # m
FACET = 1e-3  # m; shorter segments are facets of a curve: the change may be smeared over them


def with_poses_between(toolpath: Toolpath, segment: Rows, fraction: Floats) -> Toolpath:
    """Put poses into segments (``segment`` k runs from pose k to k + 1).

    Args:
        segment, fraction: (M,) each, ascending; 0 < fraction < 1.

    Returns:
        The new toolpath; pose m of those put in is at ``rows_between(segment)[m]``. Events stay right before the pose
        of the file that follows them.
    """
    end = segment + 1
    row = (1 - fraction) * toolpath.row[segment] + fraction * toolpath.row[end]
    ways = toolpath.ways
    if ways is None or ways.table is None:
        position, orientation = _between(toolpath, segment, fraction)
    else:
        position, orientation = _between_on_table(toolpath, ways, segment, fraction=fraction, row=row)
    grown = toolpath.with_points(end, row, position, orientation)
    before = np.searchsorted(end, np.arange(len(toolpath) + 1), side="right")  # how many stand before each old pose
    events = tuple(replace(e, pose=e.pose + int(before[e.pose])) for e in toolpath.events)
    return replace(grown, events=events)


def _between(toolpath: Toolpath, segment: Rows, fraction: Floats) -> tuple[Floats, Floats]:
    """Positions (M, 3), and quaternions (M, 4) or tool axes (M, 3), straight between the ends."""
    end, t = segment + 1, fraction[:, None]
    position = (1 - t) * toolpath.position[segment] + t * toolpath.position[end]
    if toolpath.quaternion is None:
        return position, slerp(toolpath.axis[segment], toolpath.axis[end], fraction)
    return position, slerp_quaternion(toolpath.quaternion[segment], toolpath.quaternion[end], fraction)


def _between_on_table(
    toolpath: Toolpath, ways: AxisWays, segment: Rows, *, fraction: Floats, row: Floats
) -> tuple[Floats, Floats]:
    """As ``_between``, straight on the part that a table turns meanwhile: at ``row`` (M,)."""
    ends, t = (segment, segment + 1), fraction[:, None]
    begin, last, there = (_part(ways, at) for at in (toolpath.row[ends[0]], toolpath.row[ends[1]], row))
    a, b = begin.inward(toolpath.position[ends[0]]), last.inward(toolpath.position[ends[1]])
    position = there.at((1 - t) * a + t * b)
    if toolpath.quaternion is None:
        axis = toolpath.axis_on_part
        return position, there.along(slerp(axis[ends[0]], axis[ends[1]], fraction))
    first, second = (
        quaternion_from_matrix(np.swapaxes(p.rotation, 1, 2) @ matrix_from_unit_quaternion(toolpath.quaternion[k]))
        for p, k in zip((begin, last), ends, strict=True)
    )
    on_part = matrix_from_quaternion(slerp_quaternion(first, second, fraction))
    return position, quaternion_from_matrix(there.rotation @ on_part)


def _part(ways: AxisWays, row: Floats) -> Frame:
    return ways.part_at(row) or Frame.identity()


def rows_between(segment: Rows) -> Rows:
    """(M,) where the poses that ``between`` puts into segments stand in its path."""
    return segment + 1 + np.arange(len(segment))


def with_poses_before_corners(toolpath: Toolpath, position: Floats | None = None) -> Toolpath:
    """A pose just before every sharp corner of a cut.

    A wrench in path axes turns with the feed that LEAVES a pose; without a pose before the corner its change
    would be smeared over the segment that arrives. ``position``: (N, 3) m on the part, where that is another feed.
    """
    sharp, length = sharp_corners(toolpath, position), _lengths(toolpath, position)
    segment = np.flatnonzero(sharp & (length[:-1] > FACET) & (length[1:] > 1e-9))
    if not len(segment):
        return toolpath
    return with_poses_between(toolpath, segment, 1 - BEFORE_CORNER / length[segment])


def with_poses_after_corners(toolpath: Toolpath, position: Floats | None = None) -> Toolpath:
    """A pose just after every sharp corner of a cut, for a wrench that turns with the feed that ARRIVES at a pose."""
    sharp, length = sharp_corners(toolpath, position), _lengths(toolpath, position)
    segment = np.flatnonzero(sharp & (length[1:] > FACET) & (length[:-1] > 1e-9) & (toolpath.kind[2:] == CUT)) + 1
    if not len(segment):
        return toolpath
    return with_poses_between(toolpath, segment, BEFORE_CORNER / length[segment])


def sharp_corners(toolpath: Toolpath, position: Floats | None = None) -> npt.NDArray[np.bool_]:
    """(N - 2,) whether the cut turns sharply at the poses between the ends; ``position``: as above."""
    step = np.diff(toolpath.on_part if position is None else position, axis=0)
    if len(step) < 2:
        return np.zeros(0, dtype=bool)
    unit = step / np.maximum(np.linalg.norm(step, axis=1), 1e-12)[:, None]
    cosine = np.sum(unit[1:] * unit[:-1], axis=1)
    return np.asarray((cosine < CORNER) & (toolpath.kind[1:-1] == CUT))


def _lengths(toolpath: Toolpath, position: Floats | None) -> Floats:
    """(N - 1,) m of the moves; one at least."""
    step = np.diff(toolpath.on_part if position is None else position, axis=0)
    return np.linalg.norm(step, axis=1) if len(step) > 1 else np.zeros(1)
