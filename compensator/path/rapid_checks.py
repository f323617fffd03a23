"""What can be seen without a stock: rapids that run into what is cut, a file that begins in it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.cleared import ClearedGround
from compensator.path.pose_text import place
from toolpaths.finding import WARNING, Finding
from toolpaths.toolpath import CUT, Floats, Toolpath

Bools = npt.NDArray[np.bool_]

EDGE = 1e-4  # m: a rapid this near to a side or the top of the box runs along it
STEP = 2e-3  # m between the places of a rapid that are looked at
MOST_PLACES = 500  # along one rapid
AXIAL = np.cos(np.radians(8.0))  # a move nearer to the tool axis goes along it
TOP = 2  # the face of the box that the tool looks at: its third axis is the mean tool axis


def rapid_findings(path: Toolpath) -> Iterator[Finding]:
    """Warnings: rapids sideways through the box of what is cut, where nothing was cut before; a cut to begin with."""
    if not np.any(path.kind == CUT):
        return
    if path.kind[0] == CUT and path.language != "csv":  # a table has no moves, its first row is a place
        what = "the file begins with a cut: where it comes from is not known, the arm goes to its end by a joint move"
        yield Finding(WARNING, place(path, 0), what, "Put a rapid in front of it, or say [machine] start (G-code)")
    for k, begins_inside in _through_material(path):
        what = "a rapid enters the box of what is cut from the side"
        if begins_inside:
            what = "a rapid goes sideways inside the box of what is cut, where nothing was cut before"
        yield Finding(WARNING, place(path, k), what, "See that nothing stands there, or retract before it")


@dataclass(frozen=True)
class CutBox:
    """The box of what is cut.

    Attributes:
        axes: (3, 3) columns, in the work object: the third is the mean tool axis.
        low, high: (3,) m, corners along the axes.
    """

    axes: Floats
    low: Floats
    high: Floats

    def depth(self, point: Floats, margin: float) -> float:
        """How far below its top a point (3,) of the work object lies, m; negative beside it by more than ``margin``."""
        at = point @ self.axes
        beside = (at < self.low - margin)[:TOP].any() or (at > self.high + margin)[:TOP].any()
        return -1.0 if beside else float(self.high[TOP] - at[TOP])


def box_of_cuts(path: Toolpath) -> CutBox:
    """The box that holds the ends of cuts, and the starts of those that go across the tool.

    Retracts along the tool cut nothing. It reaches up to where the lowest plunge begins that a rapid came down to:
    from there on there may be material.
    """
    axes = _tool_axes(path.axis)
    position, along = path.position @ axes, _along_the_tool(path)
    cut, down = path.kind == CUT, along <= -AXIAL
    starts = np.flatnonzero((cut & (np.abs(along) < AXIAL))[1:])
    came_down = down & ~cut
    came_down[0] = not cut[0]
    plunges = position[np.flatnonzero((cut & down)[1:] & came_down[:-1]), TOP]
    ends = position[cut & ~(along >= AXIAL)]
    corners = np.concatenate([ends, position[starts]]) if len(ends) + len(starts) else position[cut]
    low, high = corners.min(axis=0), corners.max(axis=0)
    plunges = plunges[plunges > high[TOP]]
    if len(plunges):
        high[TOP] = plunges.min()
    return CutBox(axes, low, high)


def _through_material(path: Toolpath) -> list[tuple[int, bool]]:
    """Rapids sideways through the box where no cut was before, and whether they begin inside; in their order."""
    if (path.kind == CUT).all():
        return []
    box = box_of_cuts(path)
    position = path.position @ box.axes
    begin, cut = np.concatenate([position[:1], position[:-1]]), path.kind == CUT
    aside, inside = _from_the_side(path, box)
    rows = np.flatnonzero(aside | inside)
    if not len(rows):
        return []
    ground, done, found = ClearedGround(box.low, box.high), 0, list[tuple[int, bool]]()
    for k in rows.tolist():
        cuts = done + np.flatnonzero(cut[done:k])
        ground.cut(begin[cuts], position[cuts])
        done = k
        places = _places_within(box, begin[k], position[k])
        if len(places) and not ground.clear(places).all():
            found.append((k, bool(inside[k])))
    return found


def _places_within(box: CutBox, begin: Floats, end: Floats) -> Floats:
    """(M, 3) points of a move in the box, below its top."""
    count = int(np.clip(np.linalg.norm(end - begin) / STEP, 2, MOST_PLACES))
    points = begin + np.linspace(0, 1, count)[:, None] * (end - begin)
    return np.asarray(points[_within(box, points)])


def _within(box: CutBox, points: Floats) -> Bools:
    """(M,) points in the box, below its top; its sides and its floor belong to it."""
    high = np.append(box.high[:TOP] + EDGE, box.high[TOP] - EDGE)
    return np.asarray(((points > box.low - EDGE) & (points < high)).all(axis=1))


def _from_the_side(path: Toolpath, box: CutBox) -> tuple[Bools, Bools]:
    """Whether the rapid to each pose enters the box not from the tool's side, nor along the tool, (N,); and whether it
    begins in there and goes sideways, across a tool that stands as in most cuts."""
    position = path.position @ box.axes
    step = np.diff(position, axis=0, prepend=position[:1])
    begin = position - step
    inner, outer = (box.low + EDGE, box.high - EDGE), (box.low - EDGE, box.high + EDGE)
    inner[0][TOP] -= 2 * EDGE  # a rapid on the floor is in the material
    still = step == 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.stack([(face - begin) / step for face in inner])
    between = (begin > inner[0]) & (begin < inner[1])
    near = np.where(still, np.where(between, -np.inf, np.inf), shares.min(axis=0))
    far = np.where(still, np.inf, shares.max(axis=0))
    entered, left = near.max(axis=1), far.min(axis=1)
    from_above = (near.argmax(axis=1) == TOP) & (begin[:, TOP] > box.high[TOP])
    outside = ((begin < outer[0]) | (begin > outer[1])).any(axis=1)
    rapid = (path.kind != CUT) & ~still.all(axis=1)
    rapid[0] = False
    enters = outside & (entered > 0.0) & (entered < np.minimum(left, 1.0)) & ~from_above
    along = _along_the_tool(path)
    upright = path.axis @ box.axes[:, TOP] > AXIAL
    sideways = _within(box, begin) & (np.abs(along) < AXIAL) & upright
    return np.asarray(rapid & enters & (along > -AXIAL)), np.asarray(rapid & sideways)


def _along_the_tool(path: Toolpath) -> Floats:
    """(N,) cosine between the move to each pose and the tool axis there."""
    step = np.diff(path.position, axis=0, prepend=path.position[:1])
    length = np.linalg.norm(step, axis=1)
    return np.asarray(np.sum(step * path.axis, axis=1) / np.maximum(length, 1e-12))


def _tool_axes(axis: Floats) -> Floats:
    """(3, 3) columns: a system whose third axis is the mean tool axis."""
    mean = axis.mean(axis=0)
    size = float(np.linalg.norm(mean))
    z = mean / size if size > 0.1 else np.array([0.0, 0.0, 1.0])
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
