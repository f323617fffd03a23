"""Joint speeds and accelerations at the programmed feed against the robot's limits; feeds lowered to keep them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.path.joint_motion import RAMP, JointMotion, PathMoments, joint_motion
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import place
from stiffness.robot.robot import Robot
from toolpaths.columns import blocks
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

ROUNDS = 30  # of lowering: a change of feed is itself an acceleration
CLOSE = 1.001  # times a limit: less than this beyond it is on it
RESERVE = 0.98  # of a limit: what a lowered feed aims at; corrections and the steps between feeds take the rest
_REMEDY = 'Lower the feed there, or set [solve] feed = "limit"; near a singularity choose another turn or placement'


@dataclass(frozen=True, repr=False, eq=False)
class MotionCheck:
    """Largest joint speeds and accelerations along the cuts of a path, and the limits.

    Attributes:
        robot: whose limits; NaN: not known.
        speed, acceleration: rad/s and rad/s2.
    """

    robot: Robot
    speed: Largest
    acceleration: Largest

    def __repr__(self) -> str:
        return f"MotionCheck({self.robot.name})"

    def findings(self, toolpath: Toolpath) -> Iterator[Finding]:
        """A warning for each joint and limit, at the worst pose, and a note of what no limit is known of."""
        limits = limits_by_name(self.robot)
        yield from self._beyond(toolpath, self.speed, limits["speed"], "turn at {} deg/s")
        yield from self._beyond(toolpath, self.acceleration, limits["acceleration"], "accelerate with {} deg/s2")
        if unknown := [name for name, values in limits.items() if np.isnan(values).any()]:
            what = f"{' and '.join(unknown)} of the joints not checked: {self.robot.name} has no limits of them"
            yield Finding(NOTE, "", what)

    def _beyond(self, toolpath: Toolpath, values: Largest, limits: Floats, verb: str) -> Iterator[Finding]:
        name = self.robot.name
        for j in np.flatnonzero(values.beyond).tolist():
            have, may = (f"{np.degrees(v):.0f}" for v in (values.value[j], limits[j]))
            what = f"joint {j + 1} would have to {verb.format(have)} at the programmed feed; {name} has {may}"
            where = place(toolpath, int(values.pose[j]))
            yield Finding(WARNING, where, what, _REMEDY, count=int(values.beyond[j]))


@dataclass(eq=False)
class Largest:
    """The largest of a value of every joint along a path, taken block by block.

    Attributes:
        limit: (n,) of each joint; NaN: not known.
        value: (n,) the largest, 0 where there is none. pose: (n,) where. beyond: (n,) poses at which it is beyond it.
    """

    limit: Floats
    value: Floats
    pose: Rows
    beyond: Rows

    @staticmethod
    def of(limit: Floats) -> Largest:
        """Before the first block."""
        n = len(limit)
        return Largest(limit, np.zeros(n), np.zeros(n, dtype=np.intp), np.zeros(n, dtype=np.intp))

    def take_in(self, first: int, values: Floats) -> None:
        """A block (K, n) that begins at pose ``first``."""
        k, joints = values.argmax(axis=0), np.arange(len(self.value))
        larger = values[k, joints] > self.value
        self.value = np.where(larger, values[k, joints], self.value)
        self.pose = np.where(larger, first + k, self.pose)
        self.beyond = self.beyond + (values > CLOSE * self.limit).sum(axis=0)


def share_of_limits(robot: Robot, motion: JointMotion) -> Floats:
    """(N,) the largest part of a speed limit, or the root of that of an acceleration limit: above 1, by so much the
    feed has to fall."""
    parts = [motion.speed / robot.velocity, np.sqrt(motion.acceleration / accelerations(robot))]
    return np.asarray(np.nan_to_num(np.concatenate(parts, axis=1)).max(axis=1, initial=0.0))


def accelerations(robot: Robot) -> Floats:
    """(n,) rad/s2; NaN where not known."""
    return np.full(robot.n, np.nan) if robot.acceleration is None else robot.acceleration


def limits_by_name(robot: Robot) -> dict[str, Floats]:
    """What is limited -> (n,) rad/s or rad/s2, NaN where not known."""
    return {"speed": robot.velocity, "acceleration": accelerations(robot)}


def motion_check(robot: Robot, toolpath: Toolpath, q: Floats, default_feed: float) -> MotionCheck:
    """How a path moves the joints of a robot.

    Args:
        q: (N, n) rad. default_feed: m/s, of cuts without one.
    """
    moments, limits = PathMoments(toolpath, feeds(toolpath, default_feed)), limits_by_name(robot)
    speed, acceleration = Largest.of(limits["speed"]), Largest.of(limits["acceleration"])
    for b in blocks(len(q)):
        fast, hard = moments.motion(q, b)
        speed.take_in(b.start, fast)
        acceleration.take_in(b.start, hard)
    return MotionCheck(robot, speed, acceleration)


def feeds(toolpath: Toolpath, default: float) -> Floats:
    """(N,) m/s of the cuts, ``default`` where the toolpath gives none; 0 for rapids."""
    given = np.where(toolpath.feed > 0, toolpath.feed, default)
    return np.where(toolpath.kind == CUT, given, 0.0)


def within_limits(robot: Robot, path: PlannedPath, q: Floats, default_feed: float) -> PlannedPath:
    """The path with feeds at which the joints stay within their limits; the same one where they do.

    Args:
        q: (N, n) rad, of ``path`` or of its commands. default_feed: m/s, of cuts without one.
    """
    toolpath = path.toolpath
    given = feed = feeds(toolpath, default_feed)
    for _ in range(ROUNDS):
        motion = joint_motion(toolpath, q, feed)
        share = share_of_limits(robot, motion)
        rows = np.flatnonzero(share > CLOSE)
        if not len(rows):
            break
        feed = feed * _factor(motion, rows, RESERVE / share[rows])
    if feed is given:
        return path
    lowered = np.where(feed < given, feed, toolpath.feed)
    programmed = given if path.programmed is None else path.programmed
    return replace(path, toolpath=replace(toolpath, feed=lowered), programmed=programmed)


@dataclass(frozen=True)
class LoweredFeed:
    """A stretch of cuts whose feeds were lowered.

    Attributes:
        pose: the first and the last. line: of the source, likewise.
        programmed, lowest: m/s, where it is lowered most.
    """

    pose: tuple[int, int]
    line: tuple[int, int]
    programmed: float
    lowest: float


def lowered_feeds(path: PlannedPath) -> list[LoweredFeed]:
    """Stretches of a path with lowered feeds, in their order."""
    if path.programmed is None:
        return []
    feed = path.toolpath.feed
    less = np.zeros(len(feed) + 2, dtype=np.int8)
    less[1:-1] = feed < path.programmed * (1 - 1e-12)  # False for NaN: the default, as it is
    begin, end = np.flatnonzero(np.diff(less) == 1), np.flatnonzero(np.diff(less) == -1) - 1
    out = []
    for a, b in zip(begin.tolist(), end.tolist(), strict=True):
        k = a + int(np.argmin(feed[a : b + 1] / path.programmed[a : b + 1]))
        lines = (int(path.toolpath.line[a]), int(path.toolpath.line[b]))
        out.append(LoweredFeed((a, b), lines, float(path.programmed[k]), float(feed[k])))
    return out


def lowered_findings(path: PlannedPath) -> list[Finding]:
    """A note of the feeds that were lowered, at the first of them."""
    found = lowered_feeds(path)
    if not found:
        return []
    worst = min(found, key=lambda f: f.lowest / f.programmed)
    poses = sum(f.pose[1] - f.pose[0] + 1 for f in found)
    what = (
        f"the feed is lowered at {poses:,} poses, so that every joint can follow; most at line {worst.line[0]}, from "
        f"{worst.programmed * 60e3:.0f} to {worst.lowest * 60e3:.0f} mm/min"
    )
    return [Finding(NOTE, place(path.toolpath, found[0].pose[0]), what, "See motion.lowered in the JSON")]


def _factor(motion: JointMotion, rows: Rows, factor: Floats) -> Floats:
    """(N,) the smallest of the factors (M,) of poses ``rows`` within RAMP of the move that ends at each pose."""
    out = np.ones(len(motion.time))
    begin = np.searchsorted(motion.time, motion.time[rows] - RAMP)
    end = np.searchsorted(motion.time, motion.time[rows] + RAMP, side="right") + 1
    for a, b, k, f in zip(begin, end, rows, factor, strict=True):
        span = slice(max(int(a), 0), min(int(b), len(out)))
        same = motion.stretch[span] == motion.stretch[k]
        out[span] = np.where(same, np.minimum(out[span], f), out[span])
    return out
