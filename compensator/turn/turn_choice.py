"""The choice: a turn about the tool axis along a path with which the compensation relies on its model least."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.errors import CellError, PathError, SolveError
from compensator.path.chosen_turn import ChosenTurn, TurnValue
from compensator.path.planned_path import PlannedPath
from compensator.turn.coarse_turn import coarse_turn
from compensator.turn.refinement import refined
from compensator.turn.reliance import reliance
from compensator.turn.turn_cost import KeyMotion, TurnCost
from compensator.turn.turn_grid import Clearance, refuse_without_closed_form, turn_grid
from compensator.turn.turn_kinematics import TurnKinematics
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

FIRST_ROUNDS, MORE_ROUNDS = 1, 3  # of refinement: each takes the ways of the joints as the one before left them
BEST = 3  # candidates that are worth more rounds
SOON = 1.2  # times the reversals of before: more rounds take a fifth away and more (docs/path-turn.md)
SOLVED = 4  # of them that commands are solved for
CONSTANT, APART = 3, np.radians(15.0)  # constant turns to begin with
KEYS = 6000  # poses that the turn is decided at; in between it is a smooth curve


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A turn (K,) rad at the keys, what it costs, and the windows that made it, with those that failed."""

    turn: Floats
    value: TurnValue
    windows: tuple[int, int]



def promising(value: TurnValue, before: TurnValue) -> tuple[bool, float]:
    """As ``ranked``, of what may still lose reversals."""
    worse = value.variance > before.variance or value.reversals > SOON * before.reversals
    return worse, value.cost


def ranked(value: TurnValue, before: TurnValue) -> tuple[bool, float]:
    """What sorts values: those first that are worse than ``before`` in nothing, then by their cost."""
    worse = value.variance > before.variance or value.reversals > before.reversals
    return worse, value.cost


@dataclass(frozen=True, repr=False, eq=False)
class TurnedPath:
    """A path with a turn, as it would be followed, and what it costs."""

    path: PlannedPath
    value: TurnValue
    windows: tuple[int, int]


@dataclass(frozen=True, repr=False, eq=False)
class TurnChoice:
    """What there is to choose from.

    Attributes:
        rows: (K,) poses of the path that costs are taken at.
        own: the path as it was. found: others, the best first.
        refused: why one that costs less could not be followed; empty: all could.
        own_is_free: whether nothing forbids the turn that the path has; else any other that is free takes its place.
    """

    cost: TurnCost
    rows: Rows
    own: TurnedPath
    found: tuple[TurnedPath, ...]
    refused: str
    own_is_free: bool = True

    def taken(self, commands: Callable[[PlannedPath], Floats]) -> PlannedPath:
        """The best of the best few by their solved commands; the path as it was, where none is better.

        Args:
            commands: of a path, (N, n) rad.
        """
        own = self._exact(self.own, commands) or self.own
        exact = [solved for one in self.found if (solved := self._exact(one, commands))]
        better = [one for one in exact if one.value.cost < own.value.cost or not self.own_is_free]
        note = Finding(NOTE, own.path.toolpath.source, "no other turn about the tool axis costs less: it stays")
        taken = replace(own.path, chosen=ChosenTurn(own.value, own.value, (0, 0), (note,)))
        constant = own.value if np.ptp(own.path.turn) < 1e-9 else None
        for one in sorted(better, key=lambda t: ranked(t.value, own.value), reverse=True):
            chosen = ChosenTurn(constant, one.value, one.windows, tuple(_findings(own.value, one, self.refused)))
            taken = replace(one.path, chosen=chosen, instead=taken)
        return taken

    def _exact(self, one: TurnedPath, commands: Callable[[PlannedPath], Floats]) -> TurnedPath | None:
        """Its cost by solved commands; None where there are none."""
        try:
            q = commands(one.path)[self.rows]
        except SolveError:
            return None
        return replace(one, value=self.cost.value(one.path.turn[self.rows], q))


def turn_choice(job: Job, path: PlannedPath, wrench: Floats, clear: Clearance | None = None) -> TurnChoice:
    """Turns that cost less than that of the path.

    Args:
        wrench: (N, 6) of the process, base axes, about the TCP; it does not turn with the tool.
        clear: as in ``turn_grid``.

    Raises:
        CellError, PathError: the turn is not open, or the arm has no closed form.
    """
    refuse_fixed(job, path.toolpath)
    rows = np.unique(np.linspace(0, len(path) - 1, min(len(path), KEYS)).round().astype(np.intp))
    cost, allowed = _cost(job, path, rows, wrench=wrench, clear=clear)
    own = path.turn[rows]
    before, own_is_free = cost.value(own), bool(cost.grid.free_at(own).all())
    refused, found = "", list[TurnedPath]()
    for one in sorted(_candidates(cost, own, allowed), key=lambda c: ranked(c.value, before)):
        if (one.value.cost >= before.cost and own_is_free) or len(found) == SOLVED:
            continue
        try:
            turned = job.planner.turned(path, _spread(rows, one.turn, len(path)))
        except PathError as e:
            refused = refused or str(e)
            continue
        found.append(TurnedPath(turned, one.value, one.windows))
    own_path = TurnedPath(path, before, (0, 0))
    return TurnChoice(
        cost=cost, rows=rows, own=own_path, found=tuple(found), refused=refused, own_is_free=own_is_free
    )


def refuse_fixed(job: Job, toolpath: Toolpath) -> None:
    """Refuse where no turn about the tool axis, or no lean, is open.

    Raises:
        CellError, PathError: says what holds it.
    """
    refuse_without_closed_form(job.planner.inverse)
    solve = job.placement.solve
    fixed = "the toolpath gives the whole orientation of the tool" if toolpath.quaternion is not None else ""
    if not job.planner.free_tool_axis:
        fixed = "solve.free_tool_axis = false holds it"
    if fixed:
        key = f"solve.lean = {solve.lean:g}" if solve.lean else 'solve.turn = "path"'
        raise CellError(
            f"{job.placement.source}: {key}: no turn about the tool axis is open: {fixed}; take one of the two away"
        )


def _cost(
    job: Job, path: PlannedPath, rows: Rows, *, wrench: Floats, clear: Clearance | None
) -> tuple[TurnCost, Floats]:
    """The cost at the keys, and how far joints may go between them."""
    inverse = job.planner.inverse
    grid = turn_grid(inverse, job.planner.bounds, path, rows, clear=clear)
    motion, limits, allowed = key_motion(job, path, rows)
    kinematics = TurnKinematics.of(inverse, path, rows)
    cost = TurnCost.of(kinematics, motion, grid, reliance(job.arm, path, grid, wrench), acceleration=limits)
    return cost, allowed


def key_motion(job: Job, path: PlannedPath, rows: Rows) -> tuple[KeyMotion, Floats, Floats]:
    """The way between the keys, the acceleration (n,) rad/s2 of each joint at most, and how far (K - 1, n) rad it may
    go from key to key."""
    robot, toolpath = job.arm.robot, path.toolpath
    default = job.placement.program.default_feed / 60e3
    feed = np.where(toolpath.kind == CUT, np.where(toolpath.feed > 0, toolpath.feed, default), 0.0)
    motion = KeyMotion.of(path, rows, feed, job.planner.inverse.tools.changes(toolpath))
    limits = np.full(robot.n, np.inf) if robot.acceleration is None else robot.acceleration
    allowed = motion.allowed(robot.velocity, job.planner.bounds.max_joint_step)
    return motion, np.where(np.isnan(limits), np.inf, limits), allowed


def _candidates(cost: TurnCost, own: Floats, allowed: Floats) -> list[_Candidate]:
    """Starts and their refinements: a few rounds for all of them, more for the best ones."""
    before = cost.value(own)
    found = []
    for start in _starts(cost, own, allowed):
        if cost.grid.free_at(start).all():
            found.append(_Candidate(start, cost.value(start), (0, 0)))
            found += _rounds(cost, start, allowed, FIRST_ROUNDS)
    best = sorted(found, key=lambda c: promising(c.value, before))[:BEST]
    return found + [more for one in best for more in _rounds(cost, one.turn, allowed, MORE_ROUNDS)]


def _starts(cost: TurnCost, own: Floats, allowed: Floats) -> Iterator[Floats]:
    """(K,) rad: the path's own turn, constant ones that lie apart, and the way over the coarse grid.

    Refinement takes reversals away and hardly changes the variance: of constant turns with less of it, those that
    reverse least; of others, what costs least.
    """
    yield own
    whole = cost.grid.turns[cost.grid.free.all(axis=0)]
    before = cost.value(own)
    values = {float(turn): cost.value(np.full(len(own), turn)) for turn in whole}
    rank = {
        turn: (False, v.reversals) if v.variance < before.variance else (True, v.cost) for turn, v in values.items()
    }
    picked: list[float] = []
    for turn in sorted(rank, key=rank.__getitem__):
        if len(picked) < CONSTANT and all(np.cos(turn - other) < np.cos(APART) for other in picked):
            picked.append(turn)
            yield np.full(len(own), turn)
    coarse = coarse_turn(cost, allowed)
    if coarse is not None:
        yield coarse


def _rounds(cost: TurnCost, turn: Floats, allowed: Floats, count: int) -> list[_Candidate]:
    out = []
    for _ in range(count):
        made = refined(cost, turn, allowed)
        turn = made.values
        if cost.grid.free_at(turn).all():
            out.append(_Candidate(turn, cost.value(turn), (made.windows, made.failed)))
    return out


def _spread(rows: Rows, turn: Floats, count: int) -> Floats:
    """(N,) rad between the keys: the same where every pose is one, else a curve without overshoot (Fritsch)."""
    if len(rows) == count:
        return turn
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(rows, turn)(np.arange(count)))


def _findings(before: TurnValue, one: TurnedPath, refused: str) -> Iterator[Finding]:
    source, now, span = one.path.toolpath.source, one.value, np.degrees(np.ptp(one.path.turn))
    what = (
        f"the turn about the tool axis is chosen along the path (over {span:.0f} deg): mean standard deviation of the "
        f"deflection {before.sd * 1e6:.1f} to {now.sd * 1e6:.1f} um, joint reversals in the cut "
        f"{before.reversals:.0f} to {now.reversals:.0f}"
    )
    yield Finding(NOTE, source, what)
    windows, failed = one.windows
    if failed:
        what = f"{failed} of {windows} windows of the turn's refinement failed: there it stays as it began"
        yield Finding(WARNING, source, what, "The result is sound, and may be worse than it could be")
    if refused:
        yield Finding(NOTE, source, f"a turn that would cost less cannot be followed: {refused}")
