"""Flank changes between two poses: the path gets poses around them, not a smear across the segment.

A segment whose ends differ in state is cut into parts and solved on its own, from the state at its beginning;
the part with the change is cut once more. What comes out are the poses next to the change, or, for a
joint that crosses its gap gradually, those where the crossing begins and ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from compensator.cell.external_axes import moved_workobject, workobject_along
from compensator.path.added_poses import rows_between, with_poses_between
from compensator.path.planned_path import PlannedPath
from compensator.process.process import ToolMotion
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import settled_state
from stiffness.memory.preload import PreloadState
from stiffness.numerics.beside import beside
from stiffness.statics.prediction import COLUMNS, Command
from toolpaths.columns import blocks
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]

PARTS = 16  # that an interval is cut into, per level
SHORTEST = 5e-5  # m; a change is not located finer than this
WORTH_A_POSE = 5e-7  # rad; a change of joint deflection below is left where it is
ROUNDS = 3
TOGETHER = 2048  # intervals that are solved together, so that memory stays small


@dataclass(frozen=True)
class _Intervals:
    """Stretches of segments: ``segment`` (M,), ``low`` and ``high`` (M,) fractions of it, ``state`` at the low end."""

    segment: Index
    low: Floats
    high: Floats
    state: PreloadState

    def __len__(self) -> int:
        return len(self.segment)

    @staticmethod
    def joined(parts: Sequence[_Intervals]) -> _Intervals:
        """All of them."""
        segment, low, high = (np.concatenate([getattr(p, name) for p in parts]) for name in ("segment", "low", "high"))
        states = (np.concatenate([getattr(p.state, name) for p in parts]) for name in ("low", "high"))
        return _Intervals(segment, low, high, PreloadState(*states))

    def take(self, block: slice) -> _Intervals:
        """Some of them."""
        state = PreloadState(self.state.low[block], self.state.high[block])
        return _Intervals(self.segment[block], self.low[block], self.high[block], state)

    def grid(self) -> Floats:
        """(PARTS + 1, M) fractions."""
        t = np.linspace(0, 1, PARTS + 1)[:, None]
        return np.asarray(self.low + t * (self.high - self.low))


def with_flank_poses(c: Compensation) -> PlannedPath | None:
    """The path with poses around every flank change of a cut; None when there is none."""
    toolpath, end = c.path.toolpath, c.state.changed
    if not len(end):
        return None
    length = np.linalg.norm(np.diff(toolpath.on_part, axis=0), axis=1)
    worth = np.concatenate([_worth_a_look(c, end[b]) for b in blocks(len(end))])
    rows = end[worth & (length[end - 1] > SHORTEST) & (toolpath.kind[end] == CUT)] - 1
    if not len(rows):
        return None
    begin = c.state.take(rows)
    intervals = _Intervals(rows, np.zeros(len(rows)), np.ones(len(rows)), PreloadState(begin.low, begin.high))
    first, closer = _bends(c, intervals, length, deeper=True)
    second, _ = _bends(c, closer, length, deeper=False) if len(closer) else (first[:0], closer)
    keep = np.concatenate([first, second])
    keep = keep[(keep[:, 1] > 0) & (keep[:, 1] < 1)]
    if not len(keep):
        return None
    keep = np.unique(keep, axis=0)
    finer = with_poses_between(toolpath, keep[:, 0].astype(np.intp), keep[:, 1])
    return c.job.planner.again(c.path, finer)


def _worth_a_look(c: Compensation, end: Rows) -> Bools:
    """(K,) whether the state changes by so much at poses (K,) that it is looked for where between it and the pose
    before; from an unknown flank nothing can be located."""
    before, after = c.state.take(end - 1), c.state.take(end).middle
    worth = _worth(c.job.arm, c.command.q[end], c.command.torque[end], before=before.middle, after=after)
    return np.asarray(worth.any(axis=1) & before.known.all(axis=1))


def _worth(arm: EquippedArm, q: Floats, tau: Floats, *, before: Floats, after: Floats) -> Bools:
    """(N, n) whether a change of state moves a joint by more than WORTH_A_POSE."""
    change = arm.joint_deflection(q, tau, after) - arm.joint_deflection(q, tau, before)
    return np.asarray(np.abs(change) > WORTH_A_POSE)


def _bends(c: Compensation, intervals: _Intervals, length: Floats, *, deeper: bool) -> tuple[Floats, _Intervals]:
    """Poses (K, 2: segment, fraction) where changes begin and end, and the intervals to look into again."""
    parts = list(blocks(len(intervals), TOGETHER))
    whole = None if _stand_alone(c) else _Inside(c, intervals, alone=False)

    def among(some: Sequence[slice]) -> list[tuple[Floats, _Intervals]]:
        found = []
        for b in some:
            inside, rows = (_Inside(c, intervals.take(b), alone=True), slice(None)) if whole is None else (whole, b)
            found.append(_bends_among(c, inside, length, rows, deeper=deeper))
        return found

    half = len(parts) // 2
    with beside(lambda: among(parts[half:]), known=(c,), poses=len(intervals) * PARTS) as others:
        found = [*among(parts[:half]), *others.result()]
    return np.concatenate([bends for bends, _ in found]), _Intervals.joined([finer for _, finer in found])


def _stand_alone(c: Compensation) -> bool:
    """Whether what is inside of an interval does not depend on the poses that others get: it is made for a few of them
    at a time, and not for all. Reference orientations of a tilting tool follow from the whole path."""
    placement, toolpath = c.job.placement, c.path.toolpath
    given = toolpath.quaternion is not None or bool((toolpath.axis == toolpath.axis[0]).all())
    return given and placement.process.between_ends and moved_workobject(placement, toolpath) is None


def _bends_among(
    c: Compensation, inside: _Inside, length: Floats, block: slice, *, deeper: bool
) -> tuple[Floats, _Intervals]:
    """As ``_bends``, of some of the intervals."""
    intervals = inside.intervals.take(block)
    command, state = inside.solved(block)
    n, m, count = c.job.arm.robot.n, state.low.shape[-1], len(intervals)
    worth = _worth(
        c.job.arm, command.q[1:].reshape(-1, n), command.torque[1:].reshape(-1, n),
        before=state.middle[:-1].reshape(-1, m), after=state.middle[1:].reshape(-1, m),
    ).reshape(PARTS, count, n)  # fmt: skip
    edge = np.zeros((1, count, n), dtype=bool)
    before, after = np.concatenate([edge, worth]), np.concatenate([worth, edge])
    grid = intervals.grid()
    # a change of one part alone is a jump and looked into; one of several parts is a gap crossed gradually
    alone = worth & ~np.concatenate([edge, worth[:-1]]) & ~np.concatenate([worth[1:], edge])
    alone &= (length[intervals.segment] * (grid[1] - grid[0]) > SHORTEST)[None, :, None] & deeper
    # the ends of a part that is looked into again are not needed: nothing changes up to the finer ones
    covered = np.concatenate([edge, alone]) | np.concatenate([alone, edge])
    node, which = np.nonzero(((before != after) & ~covered).any(axis=2))
    bends = np.stack([intervals.segment[which].astype(float), grid[node, which]], axis=1)
    part, among = np.nonzero(alone.any(axis=2))
    finer = _Intervals(
        intervals.segment[among], grid[part, among], grid[part + 1, among],
        PreloadState(state.low[part, among], state.high[part, among]),
    )  # fmt: skip
    return bends, finer


class _Inside:
    """The poses (PARTS + 1) along every one of some intervals, solved a few intervals at a time."""

    def __init__(self, c: Compensation, intervals: _Intervals, *, alone: bool) -> None:
        self.compensation, self.intervals = c, intervals
        count, fractions = len(intervals), intervals.grid()
        order = np.lexsort((fractions.T.ravel(), np.repeat(intervals.segment, PARTS + 1)))
        inner = np.clip(fractions, 1e-9, 1 - 1e-9).T.ravel()[order]  # interval by interval
        segment = np.repeat(intervals.segment, PARTS + 1)[order]
        stretch, first = c.path.toolpath, 0
        if alone:
            first = int(segment[0])
            stretch = stretch.take(np.arange(first, segment[-1] + 2))
        self._fine, rows = with_poses_between(stretch, segment - first, inner), rows_between(segment - first)
        self._tcp, placement = c.job.planner.tcp(c.path, self._fine), c.job.placement
        motion = ToolMotion(self._fine, workobject_along(placement, self._fine), self._tcp)
        wrench = placement.process.wrench_between(motion, c.path.toolpath, c.load, rows)
        begin = np.repeat(intervals.low == 0, PARTS + 1)[order] & (inner < 1e-6)
        wrench[begin] = c.wrench[segment[begin]]  # may be a rapid, without load
        place = np.empty(len(order), dtype=np.intp)
        place[order] = np.arange(len(order))
        self._wrench, self._rows, self._place = wrench, rows, place.reshape(count, PARTS + 1)

    def solved(self, block: slice) -> tuple[Command, PreloadState]:
        """Commands and states (PARTS + 1, M, ...) along M of the intervals, each from its own first state."""
        arm, pick = self.compensation.job.arm, self._place[block].T.ravel()  # part by part, intervals side by side
        rows, wrench = self._rows[pick], self._wrench[pick]
        some, first = self._fine.take(rows), self.intervals.take(block).state
        path = self.compensation.job.planner.part(self.compensation.path, some, self._tcp.take(rows))
        wide = (PARTS + 1, *first.low.shape)
        state = PreloadState(np.broadcast_to(first.low, wide), np.broadcast_to(first.high, wide))
        for _ in range(ROUNDS):
            flat = state.middle.reshape(len(rows), -1)
            command = _folded(arm.command(some, path.tcp, wrench=wrench, state=flat, seed=path.q), wide[:2])
            new = _walked(arm, command, state, first)
            same = not np.any(np.abs(new.middle - state.middle) > 1e-9)
            state = new
            if same:
                break
        return command, state


def _folded(command: Command, shape: tuple[int, int]) -> Command:
    """The same command with poses as (parts, intervals)."""
    columns = {name: getattr(command, name) for name in COLUMNS}
    folded = {k: a.reshape(*shape, *a.shape[1:]) for k, a in columns.items()}
    return Command(**folded, nominal=lambda q: command.printed, steps=command.steps)


def _walked(arm: EquippedArm, command: Command, state: PreloadState, first: PreloadState) -> PreloadState:
    """States along the intervals; the first row keeps the state it is given."""
    return settled_state(arm, command, state, first=first, moves=lambda v: np.diff(v, axis=0, prepend=v[:1]))
