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
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

RAMP = 0.024  # s: two of the 12 ms in which KUKA's KR C interpolates, one of the 24 ms of ABB's path planner
_BLOCK = 16384  # poses at a time, so that memory stays small
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
    length = np.linalg.norm(np.diff(toolpath.on_part, axis=0, prepend=toolpath.on_part[:1]), axis=1)
    timed = (toolpath.kind == CUT) & (length > _SHORTEST) & (feed > 0)
    timed[:1] = False
    lasts = np.divide(length, feed, out=np.full(len(length), _APART), where=timed)
    time, stretch = np.cumsum(lasts), np.cumsum(~timed)
    first = np.flatnonzero(~timed)
    ends = np.append(first[1:], len(time)) - 1
    begin, end = time[first][stretch - 1], time[ends][stretch - 1]
    before, after = np.maximum(time - RAMP, begin), np.minimum(time + RAMP, end)
    corner = time[1:-1][sharp_corners(toolpath)]
    cornered = np.searchsorted(corner, time + RAMP) > np.searchsorted(corner, time - RAMP, side="right")
    whole = (time - RAMP >= begin) & (time + RAMP <= end) & ~cornered
    speed, acceleration = np.empty_like(q), np.empty_like(q)
    for k in range(0, len(q), _BLOCK):
        b = slice(k, k + _BLOCK)
        back, on = q[b] - _at(before[b], time, q), _at(after[b], time, q) - q[b]
        speed[b] = np.maximum(_per(np.abs(back), time[b] - before[b]), _per(np.abs(on), after[b] - time[b]))
        acceleration[b] = np.where(whole[b, None], np.abs(on - back) / RAMP**2, 0.0)
    return JointMotion(speed, acceleration, stretch, time)


def _at(moment: Floats, time: Floats, q: Floats) -> Floats:
    """(N, n) angles at moments (N,), straight between poses."""
    k = np.clip(np.searchsorted(time, moment), 1, len(time) - 1) if len(time) > 1 else np.zeros(len(moment), np.intp)
    share = _per((moment - time[k - 1])[:, None], time[k] - time[k - 1])
    return np.asarray(q[k - 1] + share * (q[k] - q[k - 1]))


def _per(way: Floats, span: Floats) -> Floats:
    """Rows of ``way`` over ``span`` (N,); 0 where that is 0."""
    return np.divide(way, span[:, None], out=np.zeros_like(way), where=span[:, None] > 1e-12)
