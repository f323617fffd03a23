"""Joint speeds and accelerations of a path at its programmed feeds.

Both are means over RAMP: a controller runs a path in such steps and rounds what lies in one of them, so that the
points of a curve are no corners. At the corners of the toolpath itself every controller slows down or cuts them: no
acceleration is counted there. Moves of no length turn the tool at a speed of the controller's own; there, and at
rapids, a new stretch begins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.added_poses import sharp_corners
from toolpaths.columns import blocks
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

RAMP = 0.024  # s: two of the 12 ms in which KUKA's KR C interpolates, one of the 24 ms of ABB's path planner
_SHORTEST = 1e-9  # m: a shorter move only turns
_APART = 10 * RAMP  # between two stretches on one axis of time


@dataclass(frozen=True, repr=False, eq=False)
class JointMotion:
    """How the joints move along a path.

    Attributes:
        speed: (N, n) rad/s, the larger one of before and after a pose; 0 outside of cuts.
        acceleration: (N, n) rad/s2; 0 outside of cuts, and within RAMP of the end of one or of a corner.
        stretch: (N,) number of the stretch of cuts that a pose belongs to, ascending; the pose that a stretch starts
            from is in it.
        time: (N,) s, ascending within a stretch.
    """

    speed: Floats
    acceleration: Floats
    stretch: npt.NDArray[np.intp]
    time: Floats

    def __repr__(self) -> str:
        return f"JointMotion({len(self.time)} poses)"


def joint_motion(toolpath: Toolpath, q: Floats, feed: Floats) -> JointMotion:
    """Speeds and accelerations of joint angles along a path.

    Args:
        q: (N, n) rad. feed: (N,) m/s of the move that ends at each pose.
    """
    moments = PathMoments(toolpath, feed)
    speed, acceleration = np.empty_like(q), np.empty_like(q)
    for b in blocks(len(q)):
        speed[b], acceleration[b] = moments.motion(q, b)
    return JointMotion(speed, acceleration, moments.stretch, moments.time)


class PathMoments:
    """When a path is where at its feeds, and the moments around every pose that joint motion is measured between.

    Args:
        feed: (N,) m/s of the move that ends at each pose.

    Attributes:
        stretch, time: as in ``JointMotion``.
    """

    def __init__(self, toolpath: Toolpath, feed: Floats) -> None:
        position = toolpath.on_part
        length = np.linalg.norm(np.diff(position, axis=0, prepend=position[:1]), axis=1)
        timed = (toolpath.kind == CUT) & (length > _SHORTEST) & (feed > 0)
        timed[:1] = False
        lasts = np.divide(length, feed, out=np.full(len(length), _APART), where=timed)
        self.time, self.stretch = np.cumsum(lasts), np.cumsum(~timed)
        self._first = np.flatnonzero(~timed)
        self._ends = np.append(self._first[1:], len(self.time)) - 1
        self._corner = self.time[1:-1][sharp_corners(toolpath)]

    def __repr__(self) -> str:
        return f"PathMoments({len(self.time)} poses)"

    def motion(self, q: Floats, b: slice) -> tuple[Floats, Floats]:
        """Speed and acceleration (K, n) of joint angles (N, n) rad at the poses of a block, as in ``JointMotion``."""
        at, corner, part = self.time[b], self._corner, self.stretch[b] - 1
        begin, end = self.time[self._first[part]], self.time[self._ends[part]]
        before, after = np.maximum(at - RAMP, begin), np.minimum(at + RAMP, end)
        cornered = np.searchsorted(corner, at + RAMP) > np.searchsorted(corner, at - RAMP, side="right")
        whole = (at - RAMP >= begin) & (at + RAMP <= end) & ~cornered
        back, on = q[b] - _at(before, self.time, q), _at(after, self.time, q) - q[b]
        speed = np.maximum(_per(np.abs(back), at - before), _per(np.abs(on), after - at))
        return speed, np.where(whole[:, None], np.abs(on - back) / RAMP**2, 0.0)


def _at(moment: Floats, time: Floats, q: Floats) -> Floats:
    """(N, n) angles at moments (N,), straight between poses."""
    k = np.clip(np.searchsorted(time, moment), 1, len(time) - 1) if len(time) > 1 else np.zeros(len(moment), np.intp)
    share = _per((moment - time[k - 1])[:, None], time[k] - time[k - 1])
    return np.asarray(q[k - 1] + share * (q[k] - q[k - 1]))


def _per(way: Floats, span: Floats) -> Floats:
    """Rows of ``way`` over ``span`` (N,); 0 where that is 0."""
    return np.divide(way, span[:, None], out=np.zeros_like(way), where=span[:, None] > 1e-12)
