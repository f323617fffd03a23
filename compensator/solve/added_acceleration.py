"""What corrections add to the accelerations of the joints at the programmed feed: a flank change is a jump that the arm
really makes; all else should add nothing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.joint_motion import RAMP, PathMoments
from compensator.path.pose_text import place
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import SAME_STATE
from compensator.solve.motion_limits import Largest, feeds
from stiffness.memory.preload import PreloadState
from toolpaths.columns import blocks
from toolpaths.finding import NOTE, Finding

Floats = npt.NDArray[np.float64]

MORE = 0.1  # of the largest acceleration of the joint on the nominal path: what is added is told from there on
FELT = np.radians(1.0)  # rad/s2: less is none


@dataclass(frozen=True, repr=False, eq=False)
class AddedAcceleration:
    """Acceleration of the corrected path beyond that of the nominal one, in the cuts.

    Attributes:
        elsewhere, at_flanks: (n,) rad/s2, the most of every joint, away from flank changes and within RAMP of them.
        pose: (n,) where it is most, away from them.
        nominal: (n,) rad/s2, the largest of the nominal path.
    """

    elsewhere: Floats
    at_flanks: Floats
    pose: npt.NDArray[np.intp]
    nominal: Floats

    def __repr__(self) -> str:
        return f"AddedAcceleration({np.round(np.degrees(self.elsewhere), 2).tolist()} deg/s2 away from flank changes)"

    def findings(self, c: Compensation) -> Iterator[Finding]:
        """A note of the joints that a correction accelerates where no flank changes, at the worst pose."""
        joints = np.flatnonzero((self.elsewhere > FELT) & (self.elsewhere > MORE * self.nominal))
        if not len(joints):
            return
        listed = ", ".join(f"joint {j + 1} by {np.degrees(self.elsewhere[j]):.0f}" for j in joints.tolist())
        worst = int(joints[np.argmax(self.elsewhere[joints])])
        what = (
            f"corrections accelerate joints where no flank changes, as where the force jumps: {listed} deg/s2 beyond "
            "the nominal path"
        )
        yield Finding(NOTE, place(c.path.toolpath, int(self.pose[worst])), what)


def added_acceleration(c: Compensation) -> AddedAcceleration | None:
    """Of a corrected path; None where nothing is corrected."""
    if not c.is_corrected or not len(c):
        return None
    toolpath, default = c.path.toolpath, c.job.placement.program.default_feed / 60e3
    moments, none = PathMoments(toolpath, feeds(toolpath, default)), np.full(c.path.q.shape[1], np.nan)
    near, (largest, at_flanks, elsewhere) = _near_flank_changes(c, moments.time), (Largest.of(none) for _ in range(3))
    for b in blocks(len(c)):
        nominal, corrected = (moments.motion(q, b)[1] for q in (c.path.q, c.command.q))
        added = corrected - nominal
        largest.take_in(b.start, nominal)
        at_flanks.take_in(b.start, np.where(near[b, None], added, 0.0))
        elsewhere.take_in(b.start, np.where(near[b, None], 0.0, added))
    return AddedAcceleration(
        elsewhere=elsewhere.value, at_flanks=at_flanks.value, pose=elsewhere.pose, nominal=largest.value
    )


def _near_flank_changes(c: Compensation, time: Floats) -> npt.NDArray[np.bool_]:
    """(N,) poses within RAMP of a move on which a joint state changes; ``time``: (N,) s."""
    end = c.state.changed
    if not len(end):
        return np.zeros(len(time), dtype=np.bool_)
    end = np.concatenate([end[b][_changes(c.state, end[b])] for b in blocks(len(end))])
    change = np.unique(np.concatenate([time[end - 1], time[end]]))
    slack = 1e-9
    first, last = np.searchsorted(change, time - RAMP - slack), np.searchsorted(change, time + RAMP + slack)
    return np.asarray(last > first)


def _changes(state: PreloadState, end: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """(K,) whether it is another one at poses ``end`` (K,) than at those before."""
    before, after = state.take(end - 1).middle, state.take(end).middle
    return np.asarray((np.abs(after - before) > SAME_STATE).any(axis=1))
