"""Which two-sided touches tell the lost motion of every joint: one posture or two, a dial gauge along an axis.

A touch brings one joint to its angle from above, then from below, the others standing still: the two readings differ by
the gap of that joint times its lever along the gauge.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.errors import PathError
from compensator.trials.circle import CircleShape
from compensator.trials.trial_path import TrialMoves, frames, joined, moves, toolpath_of
from stiffness.planning.lever import tcp_levers
from stiffness.planning.postures import link_frames
from toolpaths.frame import Frame
from toolpaths.rotation import quaternion_from_matrix

Floats = npt.NDArray[np.float64]

LEVER = 0.05  # m/rad along the gauge: a gap of 0.1 mrad is 5 um there, half a division of a dial gauge
TRAVEL = 0.004  # m of the TCP before a touch: within the range of a dial gauge, 20 times the gap of a worn robot
MOST_TURN = np.radians(3.0)
PIECE = np.radians(0.1)  # of an approach: its chords leave the arc by less than a micrometre, the other joints stand
NOISE = 2e-6  # m, of a reading of a dial gauge
REPEATS = 2
FEW = 2  # places and turns, where a posture takes long to find
SHARE = 0.5  # of the longest lever of a joint: a posture that shows less of it is not good for it
MOST = 2  # postures: a frame of its own (six numbers) takes up the zeros of the gauge, three per posture
TILTS = tuple(np.radians(t) for t in ((0, 0), (35, 0), (-35, 0), (0, 35), (0, -35)))
SPREAD, HEIGHTS = 0.3, (0.1, 0.4)  # m
TURNS = np.radians((0.0, 90.0, 180.0, 270.0))
FEED = 300.0  # mm/min
CLEAR = 0.05  # m


@dataclass(frozen=True, repr=False)
class Touch:
    """A joint that is brought to its angle from both sides.

    Attributes:
        joint: counted from 0. posture: (n,) rad. axis: 0, 1, 2: of the work object, where the gauge points.
        lever: m/rad along it, signed. turn: rad, of the approach. pose: (1) TCP, work object.
        number: of the posture, from 0.
    """

    joint: int
    posture: Floats
    axis: int
    lever: float
    turn: float
    pose: Frame
    number: int

    @property
    def quaternion(self) -> Floats:
        """(4,) of the TCP in the work object."""
        return np.asarray(quaternion_from_matrix(self.pose.rotation)[0])

    @property
    def above(self) -> Floats:
        """(1, 3) m, clear of the gauge."""
        return np.asarray(self.pose.origin + np.array([[0.0, 0.0, CLEAR]]))

    @property
    def sd(self) -> float:
        """rad of the gap, of REPEATS readings from both sides."""
        return float(NOISE * np.sqrt(2 / REPEATS) / abs(self.lever))


@dataclass(frozen=True, repr=False)
class ProbePlan:
    """Touches of all joints that a gauge sees; ``levers``: (n,) m/rad, the longest that was found of each joint."""

    touches: tuple[Touch, ...]
    levers: Floats
    tried: int

    def of(self, joint: int) -> Touch | None:
        """The touch of a joint."""
        return next((t for t in self.touches if t.joint == joint), None)

    def number_of(self, joint: int) -> int | None:
        """Number of the touch of a joint, from 1, in the order of the program."""
        return next((k for k, t in enumerate(self.touches, 1) if t.joint == joint), None)

    def why_not(self, joint: int) -> str:
        """Why no touch tells a joint."""
        most = float(self.levers[joint]) * 1e3
        return f"the TCP moves {most:.1f} um per mrad of it at most: it lies near its axis; a bent tool would show it"


@dataclass(frozen=True, repr=False)
class _Posture:
    """A posture with its TCP (1) in the work object and levers (n, 3) m/rad along the axes of the work object."""

    q: Floats
    pose: Frame
    lever: Floats


def probe_plan(job: Job, center: Floats | None) -> ProbePlan:
    """The touches of a cell.

    Args:
        center: (3,) m, work object, where the TCP touches; None: chosen near its zero.

    Raises:
        PathError: no posture is reached with room for the approach.
    """
    pool = list(_postures(job, center))
    if not pool:
        raise PathError(
            "no posture near the work object is reached with room for two-sided approaches: give --center X Y Z (mm, "
            "base), or move [workobject]"
        )
    size = np.abs(np.array([p.lever for p in pool])).max(axis=2)  # (M, n)
    longest = size.max(axis=0)
    wanted = np.flatnonzero(longest >= LEVER)
    share = size[:, wanted] / longest[wanted]
    chosen: list[int] = []
    while len(chosen) < MOST and not _enough(share, chosen):
        with_it = [np.maximum(share[k], share[chosen].max(axis=0, initial=0.0)) for k in range(len(pool))]
        chosen.append(int(np.argmax([np.minimum(s, SHARE).sum() + 1e-3 * s.sum() for s in with_it])))
    touches = []
    for joint in wanted.tolist():
        number = int(np.argmax(size[chosen, joint]))
        p = pool[chosen[number]]
        axis = int(np.argmax(np.abs(p.lever[joint])))
        lever = float(p.lever[joint, axis])
        if abs(lever) < LEVER:
            continue
        turn = min(TRAVEL / abs(lever), MOST_TURN)
        touches.append(
            Touch(joint=joint, posture=p.q, axis=axis, lever=lever, turn=turn, pose=p.pose, number=number)
        )
    order = sorted(touches, key=lambda t: (t.number, t.axis, t.joint))  # the gauge is moved as seldom as can be
    return ProbePlan(tuple(order), longest, len(pool))


def _enough(share: Floats, chosen: list[int]) -> bool:
    return bool(chosen) and bool(np.all(share[chosen].max(axis=0) >= SHARE))


def _postures(job: Job, center: Floats | None) -> Iterator[_Posture]:
    """Postures of one arm configuration, with room for the approaches."""
    planner, robot = job.planner, job.arm.robot
    found: list[tuple[int, Floats, Frame]] = []
    quick = planner.inverse.labelled  # without a closed form a posture takes a quarter of a second
    for at in list(_places())[: None if quick else FEW] if center is None else [center]:
        for tilt in TILTS:
            for turn in TURNS[: None if quick else FEW]:
                shape = CircleShape("XY", (float(tilt[0]), float(tilt[1])), float(turn))
                pose = toolpath_of(moves(at[None], shape.quaternion, 0.01), "")
                tcp = planner.workobject.then(frames(pose))
                found += [(b, q, frames(pose)) for b, q in planner.inverse.postures(pose, tcp, limits=True)]
    if not found:
        return
    q = np.array([f[1] for f in found])
    room = np.minimum(q - robot.lower, robot.upper - q).min(axis=1)
    free = (planner.bounds.margin(q) > 0) & (room > 2 * MOST_TURN)
    kept = np.flatnonzero(free & (np.array([f[0] for f in found]) == _configuration(job, found, free)))
    lever = tcp_levers(robot, job.placement.tools.first, q) @ job.placement.workobject.rotation
    for k in kept:
        yield _Posture(q[k], found[k][2], lever[k])


def _configuration(job: Job, found: list[tuple[int, Floats, Frame]], free: npt.NDArray[np.bool_]) -> int:
    """That of the start, else the one that most postures have."""
    inverse, start = job.planner.inverse.inverse, job.placement.start
    if start is not None and job.planner.inverse.labelled:
        return int(inverse.configuration(start[None])[0])
    branches = [b for (b, _, _), ok in zip(found, free, strict=True) if ok]
    return max(dict.fromkeys(branches), key=branches.count, default=0)


def _places() -> Iterator[Floats]:
    for z in HEIGHTS:
        for x, y in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
            yield np.array([x * SPREAD, y * SPREAD, z])


def probe_moves(job: Job, plan: ProbePlan) -> TrialMoves:
    """The whole program: every joint from both sides, REPEATS times; the program waits for every reading."""
    parts: list[TrialMoves] = []
    before: Touch | None = None
    for number, touch in enumerate(plan.touches, 1):
        set_gauge = f"set the gauge along {'XYZ'[touch.axis]} of the work object"
        if before is None or before.number != touch.number:
            parts += _way_to(touch, before)
            wait = set_gauge
        else:
            wait = READ if before.axis == touch.axis else f"{READ}, then {set_gauge}"
        for _ in range(REPEATS):
            for side in (1.0, -1.0):
                parts.append(_brought(job, touch, side, number=number, wait=wait))
                wait = READ
        before = touch
    if before is not None:
        parts.append(moves(before.above, before.quaternion, FEED / 6e4, wait=READ))
    return joined(parts)


READ = "read the gauge"


def _way_to(touch: Touch, before: Touch | None) -> list[TrialMoves]:
    """Up from the posture before, over, and down."""
    up = [] if before is None else [moves(before.above, before.quaternion, FEED / 6e4, wait=READ)]
    over = moves(touch.above, touch.quaternion, np.nan)
    return [*up, over, moves(touch.pose.origin, touch.quaternion, FEED / 6e4)]


def _brought(job: Job, touch: Touch, side: float, *, number: int, wait: str) -> TrialMoves:
    """A joint away from its angle and back to it; ``side``: sign of its last move."""
    pieces = max(4, int(np.ceil(touch.turn / PIECE)))
    away = np.linspace(0.0, -side * touch.turn, pieces + 1)[1:]
    turned = np.concatenate([away, away[-2::-1], [0.0]])
    at = _turned(job, touch, turned)
    told = {"touch": float(number), "joint": float(touch.joint + 1), "side": side}
    told |= dict(zip("ijk", np.eye(3)[touch.axis].tolist(), strict=True))
    last = np.arange(len(turned)) == len(turned) - 1
    return moves(at.origin, quaternion_from_matrix(at.rotation), FEED / 6e4, read=last, wait=wait, **told)


def _turned(job: Job, touch: Touch, turned: Floats) -> Frame:
    """(N) TCP in the work object with one joint turned by ``turned`` (N,) rad from the posture."""
    q = np.tile(touch.posture, (len(turned), 1))
    q[:, touch.joint] += turned
    tool = job.placement.tools.first
    flange = Frame.of(link_frames(job.arm.robot, q)[-1])
    return flange.then(Frame(tool.rotation, tool.position)).relative_to(job.placement.workobject)
