"""Poses put between two others: at flank changes and just before corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from toolpaths.rotation import slerp, slerp_quaternion
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
    t = fraction[:, None]
    position = (1 - t) * toolpath.position[segment] + t * toolpath.position[end]
    row = (1 - fraction) * toolpath.row[segment] + fraction * toolpath.row[end]
    if toolpath.quaternion is None:
        orientation = slerp(toolpath.axis[segment], toolpath.axis[end], fraction)
    else:
        orientation = slerp_quaternion(toolpath.quaternion[segment], toolpath.quaternion[end], fraction)
    grown = toolpath.with_points(end, row, position, orientation)
    before = np.searchsorted(end, np.arange(len(toolpath) + 1), side="right")  # how many stand before each old pose
    events = tuple(replace(e, pose=e.pose + int(before[e.pose])) for e in toolpath.events)
    return replace(grown, events=events)


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
