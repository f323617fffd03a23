"""What corrections add to the accelerations of the joints at the programmed feed: a flank change is a jump that the arm
really makes; all else should add nothing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.joint_motion import RAMP, joint_motion
from compensator.path.pose_text import place
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import SAME_STATE
from compensator.solve.motion_limits import MotionCheck, feeds
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


def added_acceleration(c: Compensation, motion: MotionCheck) -> AddedAcceleration | None:
    """Of a corrected path; None where nothing is corrected.

    Args:
        motion: of its commands.
    """
    if not c.is_corrected or not len(c):
        return None
    toolpath, default = c.path.toolpath, c.job.placement.program.default_feed / 60e3
    nominal = joint_motion(toolpath, c.path.q, feeds(toolpath, default))
    largest, near = nominal.acceleration.max(axis=0), _near_flank_changes(c, nominal.time)
    added = np.subtract(motion.acceleration, nominal.acceleration, out=nominal.acceleration)  # a path may be long
    at_flanks = np.maximum(added[near].max(axis=0, initial=0.0), 0.0)
    added[near] = 0.0
    return AddedAcceleration(
        elsewhere=np.maximum(added.max(axis=0), 0.0), at_flanks=at_flanks, pose=added.argmax(axis=0), nominal=largest
    )


def _near_flank_changes(c: Compensation, time: Floats) -> npt.NDArray[np.bool_]:
    """(N,) poses within RAMP of a move on which a joint state changes; ``time``: (N,) s."""
    state = c.state.middle
    if not state.shape[1]:
        return np.zeros(len(time), dtype=np.bool_)
    end = np.flatnonzero((np.abs(np.diff(state, axis=0)) > SAME_STATE).any(axis=1)) + 1
    change = np.unique(np.concatenate([time[end - 1], time[end]]))
    slack = 1e-9
    first, last = np.searchsorted(change, time - RAMP - slack), np.searchsorted(change, time + RAMP + slack)
    return np.asarray(last > first)
