"""Path axes: the frame that goes with the feed, at every pose."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from toolpaths.columns import blocks
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Kinds = npt.NDArray[np.uint8]


def path_axes(position: Floats, rotation: Floats, kind: Kinds | None = None) -> Floats:
    """The ``path`` frame at every pose.

    z = TCP z; x = direction of the feed that leaves the pose, normal to z; y = z cross x. Where the feed is
    along z the last x is kept, and the first poses take the next x that exists.

    Args:
        position: (N, 3); rotation: (N, 3, 3) of the TCP, in any one frame.
        kind: (N,) RAPID or CUT of the move that ends at the pose. A rapid is no feed: where one leaves, the last x
            is kept. None: all moves are feeds.

    Returns:
        (N, 3, 3), in the same frame. Poses of a path that never moves across z keep the TCP's own x.
    """
    return axes_along(Frame(rotation, position), kind)(np.arange(len(position)))


def axes_along(tcp: Frame, kind: Kinds | None = None, z: Floats | None = None) -> Callable[[Rows], Floats]:
    """``path_axes`` of TCP frames (N), of some poses: rows (K,) -> (K, 3, 3); ``z`` (N, 3) of them, if it is known."""
    position, count, direction = tcp.origin, tcp.count, tcp.z if z is None else z
    moving, good = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    # a pose that repeats the one before leaves with the next real move
    moving[:-1] = np.linalg.norm(np.diff(position, axis=0), axis=1) > 1e-9
    leaving = _next(moving)

    def across(rows: Rows, z: Floats) -> tuple[Floats, Floats]:
        """The feed that leaves each of these poses, and the part of it that is normal to ``z``."""
        k = leaving[rows]
        feed = position[np.minimum(k + 1, count - 1)] - position[k]
        return feed, feed - z * np.sum(feed * z, axis=1, keepdims=True)

    for b in blocks(count):
        feed, normal = across(np.arange(b.start, b.stop), direction[b])
        good[b] = np.linalg.norm(normal, axis=1) > 1e-6 * np.maximum(np.linalg.norm(feed, axis=1), 1e-12)
    if not good.any():
        return lambda rows: tcp.take(rows).rotation.copy()
    if kind is not None:
        cut = good & (kind[np.minimum(leaving + 1, len(kind) - 1)] == CUT)
        good = cut if cut.any() else good
    last = _last(good)

    def axes(rows: Rows) -> Floats:
        z, there = direction[rows], last[rows]
        _, normal = across(there, direction[there])
        x = normal / np.linalg.norm(normal, axis=1)[:, None]
        x = x - z * np.sum(x * z, axis=1, keepdims=True)  # kept from another pose: normal to this one's z
        x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-12)
        return np.stack([x, np.cross(z, x), z], axis=2)

    return axes


def _last(good: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Index of the last good row up to each row; the first good one for rows before it."""
    index = np.where(good, np.arange(len(good)), -1)
    index = np.maximum.accumulate(index)
    return np.where(index < 0, int(np.argmax(good)), index)


def _next(good: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Index of the next good row from each row on; the last good one for rows after it."""
    index = _last(good[::-1])[::-1]
    return len(good) - 1 - index
