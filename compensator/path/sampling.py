"""Poses put between two others: at flank changes and just before corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.path.free_turn import slerp_axis, slerp_quaternion
from toolpaths.toolpath import CUT, Event, Toolpath

Floats = npt.NDArray[np.float64]

CORNER = np.cos(np.radians(15.0))  # a sharper turn of the feed gets a pose before it
BEFORE_CORNER = 5e-5  # m
FACET = 1e-3  # m; shorter segments are facets of a curve: the change may be smeared over them


def between(
    toolpath: Toolpath, segment: npt.NDArray[np.intp], fraction: Floats
) -> tuple[Toolpath, npt.NDArray[np.bool_]]:
    """Put poses into segments (``segment`` k runs from pose k to k + 1).

    Args:
        segment, fraction: (M,) each, ascending; 0 < fraction < 1.

    Returns:
        The new toolpath, and a mask of the poses that were put in. They carry feed, kind, tool and
        line of the pose that ends the segment.
    """
    n, m = len(toolpath), len(segment)
    at = segment + 1 + np.arange(m)  # rows of the new poses in the result
    added = np.zeros(n + m, dtype=bool)
    added[at] = True
    end = segment + 1
    t = fraction[:, None]

    def mixed(old: npt.NDArray[np.generic], new: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
        out = np.empty((n + m, *old.shape[1:]), dtype=old.dtype)
        out[~added], out[added] = old, new
        return out

    position = (1 - t) * toolpath.position[segment] + t * toolpath.position[end]
    row = (1 - fraction) * toolpath.row[segment] + fraction * toolpath.row[end]
    axis = slerp_axis(toolpath.axis[segment], toolpath.axis[end], fraction)
    quaternion = toolpath.quaternion
    new_quaternion = None
    if quaternion is not None:
        turned = slerp_quaternion(quaternion[segment], quaternion[end], fraction)
        new_quaternion = mixed(quaternion, turned)
    where = np.flatnonzero(~added)
    events = tuple(Event(int(where[e.pose]) if e.pose < n else n + m, e.word, e.line) for e in toolpath.events)
    return replace(
        toolpath,
        position=mixed(toolpath.position, position),  # type: ignore[arg-type]
        axis=mixed(toolpath.axis, axis),  # type: ignore[arg-type]
        quaternion=new_quaternion,  # type: ignore[arg-type]
        feed=mixed(toolpath.feed, toolpath.feed[end]),  # type: ignore[arg-type]
        kind=mixed(toolpath.kind, toolpath.kind[end]),  # type: ignore[arg-type]
        tool=mixed(toolpath.tool, toolpath.tool[end]),  # type: ignore[arg-type]
        line=mixed(toolpath.line, toolpath.line[end]),  # type: ignore[arg-type]
        row=mixed(toolpath.row, row),  # type: ignore[arg-type]
        events=events,
    ), added


def corners(toolpath: Toolpath) -> Toolpath:
    """A pose just before every sharp corner of a cut.

    A wrench in path axes turns with the feed that LEAVES a pose; without a pose before the corner its change
    would be smeared over the segment that arrives.
    """
    step = np.diff(toolpath.position, axis=0)
    length = np.linalg.norm(step, axis=1)
    if len(step) < 2:
        return toolpath
    unit = step / np.maximum(length, 1e-12)[:, None]
    cosine = np.sum(unit[1:] * unit[:-1], axis=1)
    long_enough = (length[:-1] > FACET) & (length[1:] > 1e-9)
    sharp = (cosine < CORNER) & long_enough & (toolpath.kind[1:-1] == CUT)
    segment = np.flatnonzero(sharp)
    if not len(segment):
        return toolpath
    return between(toolpath, segment, 1 - BEFORE_CORNER / length[segment])[0]
