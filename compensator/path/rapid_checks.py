"""What can be seen of a toolpath's moves in the air without a stock: rapids into what is cut, a file that begins in it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from compensator.path.pose_text import place
from toolpaths.finding import WARNING, Finding
from toolpaths.toolpath import CUT, Floats, Toolpath

Bools = npt.NDArray[np.bool_]

EDGE = 1e-4  # m: a rapid this near to a face of the box runs along it
AXIAL = np.cos(np.radians(8.0))  # a move nearer to the tool axis goes along it
TOP = 2  # the face of the box that the tool looks at: its third axis is the mean tool axis


def rapid_findings(path: Toolpath) -> Iterator[Finding]:
    """Warnings: rapids that enter the box of what is cut from the side, and a file that begins with a cut."""
    if not np.any(path.kind == CUT):
        return
    if path.kind[0] == CUT and path.language != "csv":  # a table has no moves, its first row is a place
        what = "the file begins with a cut: where it comes from is not known, the arm goes to its end by a joint move"
        yield Finding(WARNING, place(path, 0), what, "Put a rapid in front of it, or say [machine] start (G-code)")
    for k in np.flatnonzero(_from_the_side(path)).tolist():
        what = "a rapid enters the box of what is cut from the side"
        yield Finding(WARNING, place(path, k), what, "See that nothing stands there, or retract before it")


def _from_the_side(path: Toolpath) -> Bools:
    """(N,) whether the rapid to the pose enters the box not from the tool's side, nor along the tool."""
    axes = _tool_axes(path.axis)
    position, axis = path.position @ axes, path.axis @ axes
    step = np.diff(position, axis=0, prepend=position[:1])
    length = np.linalg.norm(step, axis=1)
    along = np.sum(step * axis, axis=1) / np.maximum(length, 1e-12)
    low, high = _box_of_cuts(path, position, along)
    inner, outer = (low + EDGE, high - EDGE), (low - EDGE, high + EDGE)
    with np.errstate(divide="ignore", invalid="ignore"):
        begin = position - step
        shares = np.stack([(face - begin) / step for face in inner])
    still = step == 0.0
    between = (begin > inner[0]) & (begin < inner[1])
    outside = ((begin < outer[0]) | (begin > outer[1])).any(axis=1)
    near = np.where(still, np.where(between, -np.inf, np.inf), shares.min(axis=0))
    far = np.where(still, np.inf, shares.max(axis=0))
    entered, left = near.max(axis=1), far.min(axis=1)
    face = near.argmax(axis=1)
    from_above = (face == TOP) & (begin[:, TOP] > high[TOP])
    rapid = (path.kind != CUT) & (length > 0.0) & outside
    rapid[0] = False
    return np.asarray(rapid & (entered > 0.0) & (entered < np.minimum(left, 1.0)) & ~from_above & (along > -AXIAL))


def _tool_axes(axis: Floats) -> Floats:
    """(3, 3) columns: a system whose third axis is the mean tool axis."""
    mean = axis.mean(axis=0)
    size = float(np.linalg.norm(mean))
    z = mean / size if size > 0.1 else np.array([0.0, 0.0, 1.0])
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _box_of_cuts(path: Toolpath, position: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Corners of the box.

    It holds the ends of cuts, and the starts of those that go across the tool; retracts along the tool cut nothing. It
    reaches up to where the lowest plunge begins that a rapid came down to: from there on there may be material.
    """
    cut, down = path.kind == CUT, along <= -AXIAL
    across = cut & (np.abs(along) < AXIAL)
    starts = np.flatnonzero(across[1:])
    plunges = np.flatnonzero((cut & down)[1:] & (down & ~cut)[:-1])
    ends = position[cut & ~(along >= AXIAL)]
    corners = np.concatenate([ends, position[starts]]) if len(ends) + len(starts) else position[cut]
    low, high = corners.min(axis=0), corners.max(axis=0)
    high[TOP] = np.min(position[plunges, TOP], where=position[plunges, TOP] > high[TOP], initial=np.inf)
    if not np.isfinite(high[TOP]):
        high[TOP] = corners[:, TOP].max()
    return low, high
