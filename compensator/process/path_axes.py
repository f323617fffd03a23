"""Path axes: the frame that goes with the feed, at every pose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]


def path_axes(position: Floats, rotation: Floats, kind: npt.NDArray[np.uint8] | None = None) -> Floats:
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
    z = rotation[:, :, 2]
    feed = np.zeros_like(position)
    feed[:-1] = np.diff(position, axis=0)
    # a pose that repeats the one before leaves with the next real move
    moving = np.linalg.norm(feed, axis=1) > 1e-9
    leaving = _next(moving)
    feed = feed[leaving]
    across = feed - z * np.sum(feed * z, axis=1, keepdims=True)
    length = np.linalg.norm(across, axis=1)
    good = length > 1e-6 * np.maximum(np.linalg.norm(feed, axis=1), 1e-12)
    if not good.any():
        return rotation.copy()
    if kind is not None:
        cut = good & (kind[np.minimum(leaving + 1, len(kind) - 1)] == CUT)
        good = cut if cut.any() else good
    x = (across / np.where(good, length, 1.0)[:, None])[_last(good)]
    x = x - z * np.sum(x * z, axis=1, keepdims=True)  # kept from another pose: normal to this one's z
    x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-12)
    return np.stack([x, np.cross(z, x), z], axis=2)


def _last(good: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Index of the last good row up to each row; the first good one for rows before it."""
    index = np.where(good, np.arange(len(good)), -1)
    index = np.maximum.accumulate(index)
    return np.where(index < 0, int(np.argmax(good)), index)


def _next(good: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Index of the next good row from each row on; the last good one for rows after it."""
    index = _last(good[::-1])[::-1]
    return len(good) - 1 - index
