"""The choice of lead and tilt: a tool axis within a cone about that of the toolpath, and the turn about it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.errors import PathError, SolveError
from compensator.path.chosen_turn import ChosenTurn, LeanWorth, TurnValue
from compensator.path.lean import LeanRoom, leaned, within_cone
from compensator.path.planned_path import PlannedPath
from compensator.turn.lean_cost import ArmRoom, LeanCost
from compensator.turn.lean_kinematics import LeanKinematics
from compensator.turn.lean_lattice import LeanLattice, bends, coarse_lean, stages_of, travel
from compensator.turn.reliance import ToolReliance
from compensator.turn.turn_choice import key_motion
from compensator.turn.turn_grid import Clearance
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Ints = npt.NDArray[np.int64]

KEYS = 6000  # poses that are decided at
ROUNDS = 4  # of refinement, as long as they gain
FAR = 2.0  # times what was there: too dear to begin with
PAYS = 0.99  # of the cost: what gains less than a hundredth is not worth leaning for
SAME = 1.02  # times what was there: no worse


@dataclass(frozen=True, repr=False, eq=False)
class Upright:
    """A path to begin with: the ``path`` as it is, its ``toolpath`` with upright tools, and its states (N, 3) rad."""

    path: PlannedPath
    toolpath: Toolpath
    state: Floats
    room: LeanRoom


@dataclass(frozen=True, eq=False)
class _Candidate:
    path: PlannedPath
    state: Floats
    value: TurnValue
    windows: tuple[int, int]
    offset: Floats


def ranked(value: TurnValue, before: TurnValue) -> tuple[bool, float]:
    """What sorts values: those first that are worse than ``before`` in nothing, then by their cost."""
    worse = value.variance > SAME * before.variance or value.reversals > SAME * before.reversals
    return worse, value.cost


def upright(path: PlannedPath, room: LeanRoom) -> Upright:
    """A path whose tool does not lean."""
    state = np.zeros((len(path), 3))
    state[:, 0] = path.turn
    return Upright(path, path.toolpath, state, room)


def reached_by_leaning(job: Job, toolpath: Toolpath, room: LeanRoom) -> Upright | None:
    """A path that the arm follows with a leaning tool where it does not with an upright one; None: there is none.

    Of one tool only. The way over the lattice with the most room to limits and singularities.
    """
    planner = job.planner
    if not planner.inverse.labelled or planner.inverse.tools.changes(toolpath):
        return None
    start, form = planner.start, planner.inverse.inverse
    for branch in range(form.branches) if start is None else [int(form.configuration(start[None])[0])]:
        branches = np.full(len(toolpath), branch, dtype=np.int64)
        kinematics = _kinematics(job, toolpath, np.arange(len(toolpath)), room=room, branch=branches)
        state = _roomiest(job, kinematics, room)
        if state is None:
            continue
        try:
            q, _, _ = kinematics.angles(state)
            return Upright(_followed(job, toolpath, state, room, q=q, branch=branches), toolpath, state, room)
        except PathError:
            continue
    return None


def _roomiest(job: Job, kinematics: LeanKinematics, room: LeanRoom) -> Floats | None:
    bounds, count = job.planner.bounds, len(room.open)
    arm = ArmRoom(bounds, None, np.arange(count))
    grid = LeanLattice.of(kinematics, arm, stages_of(count), cone=room.cone, opened=room.open)
    margin = np.array([bounds.margin(q.reshape(-1, q.shape[-1])) for q in grid.q]).reshape(grid.free.shape)
    leaning = np.linalg.norm(grid.leans, axis=1)[:, None] / room.cone
    price = np.where(grid.free, np.exp(-4 * np.clip(margin, -1, 1)) + 0.2 * leaning, np.inf)
    most = np.diff(grid.stages)[:, None] * np.full(job.arm.robot.n, bounds.max_joint_step / 2)
    apart = bends(grid.leans)

    def way(k: int, step: int) -> Floats:
        return travel(grid.q[k - 1], grid.q[k], step, most=most[k - 1], worth=0.0) + 0.2 * (step**2 + apart[:, :, None])

    found = grid.cheapest(price, way)
    return None if found is None else grid.straight(found, count)


def _kinematics(job: Job, toolpath: Toolpath, rows: Rows, *, room: LeanRoom, branch: Ints) -> LeanKinematics:
    some, reference = toolpath.take(rows), job.planner.reference(toolpath).take(rows)
    return LeanKinematics.of(job.planner.inverse, some, reference, radius=room.radius[rows], branch=branch[rows])


def _followed(
    job: Job, toolpath: Toolpath, state: Floats, room: LeanRoom, *, q: Floats, branch: Ints
) -> PlannedPath:
    """The leaned path; ``q`` (N, n) rad: near it.

    Raises:
        PathError: the arm cannot follow.
    """
    path, turn = leaned(toolpath, room.radius, state)
    tcp = job.planner.reference(path)
    return job.planner.turned(PlannedPath(toolpath=path, tcp=tcp, q=q, turn=turn, branch=branch), turn)


@dataclass(frozen=True, repr=False, eq=False)
class LeanChoice:
    """Leaning paths to choose from beside that which is there; ``rows`` (K,) are looked at.

    ``own_is_free``: nothing forbids the path that is there; else any other takes its place.
    """

    cost: LeanCost
    rows: Rows
    own: _Candidate
    found: tuple[_Candidate, ...]
    begun: Upright
    own_is_free: bool

    def taken(self) -> PlannedPath:
        """The best; the path as it was where leaning is not worth it."""
        own, path = self.own, self.own.path
        better = [one for one in self.found if one.value.cost < PAYS * own.value.cost or not self.own_is_free]
        said = () if path.chosen is None else path.chosen.findings
        forced = self.begun.state[:, 1:].any()
        if not better and not forced:
            note = Finding(NOTE, path.toolpath.source, "no lean of the tool axis is worth it: it stays upright")
            mine = ChosenTurn(None, own.value, (0, 0), ()) if path.chosen is None else path.chosen
            return replace(path, chosen=replace(mine, findings=(*said, note)))
        best = min(better, key=lambda one: ranked(one.value, own.value), default=own)
        before = None if forced else own.value
        worth = self._worth(best, before)
        findings = (*said, *self._findings(best, worth))
        constant = None if path.chosen is None else path.chosen.constant
        chosen = ChosenTurn(constant, best.value, best.windows, findings, lean=worth)
        return replace(best.path, chosen=chosen, instead=None if best is own else path)

    def _worth(self, one: _Candidate, before: TurnValue | None) -> LeanWorth:
        angle = np.linalg.norm(one.state[:, 1:], axis=1)
        toolpath, cut = one.path.toolpath, one.path.toolpath.kind == CUT
        k, weight = int(np.argmax(np.where(cut, angle, -1.0))), self.cost.motion.weight
        mean = float(np.sum(weight * angle[self.rows]) / max(weight.sum(), 1e-9))
        return LeanWorth(
            before, float(angle[cut].max()), mean, cone=float(self.cost.room.cone), place=toolpath.line_words(k)
        )

    def _findings(self, one: _Candidate, worth: LeanWorth) -> Iterator[Finding]:
        source, now, before = one.path.toolpath.source, one.value, worth.upright
        how = (
            f"the tool axis leans by up to {np.degrees(worth.most):.1f} deg in the cut ({worth.place}; allowed are "
            f"{np.degrees(worth.cone):g}), {np.degrees(worth.mean):.1f} in the mean"
        )
        gain = "no upright tool can be taken along this path"
        if before is not None:
            gain = (
                f"mean standard deviation of the deflection {before.sd * 1e6:.1f} to {now.sd * 1e6:.1f} um, joint "
                f"reversals in the cut {before.reversals:.0f} to {now.reversals:.0f}"
            )
        yield Finding(NOTE, source, f"{how}: {gain}")
        if self.begun.room.declared:
            what = "the cell does not tell the shape of the cutter: it leans about the TCP, because solve.lean says so"
            yield Finding(NOTE, source, what, "A ball leans about its centre: give process.cutter shape and diameter")
        else:
            what = "balls lean about their centres; what the flank of the cutter cuts above the ball leans with it"
            yield Finding(NOTE, source, what)
        if one.windows[1]:
            what = f"{one.windows[1]} of {one.windows[0]} windows of the lean's refinement failed: there it stays"
            yield Finding(WARNING, source, what, "The result is sound, and may be worse than it could be")


def lean_choice(
    job: Job, begun: Upright, wrench: Floats, *, clear: Clearance | None, commands: Callable[[PlannedPath], Floats]
) -> LeanChoice:
    """Leaning paths beside one that is there, at what they cost by solved commands.

    Args:
        wrench: (N, 6) of the process, base axes, about the TCP; it does not turn with the tool.
        clear: as in ``turn_grid``.
        commands: of a path, (N, n) rad.
    """
    count = len(begun.path)
    rows = np.unique(np.linspace(0, count - 1, min(count, KEYS)).round().astype(np.intp))
    cost, allowed = _cost(job, begun, rows, wrench=wrench, clear=clear)
    search = _Search(job, begun, rows=rows, cost=cost, commands=commands)
    own = _Candidate(begun.path, begun.state, cost.value(begun.state[rows]), (0, 0), offset=cost.offset)
    own = search.solved(own) or own
    own_is_free = bool(cost.free(own.state[rows]).all())
    found = [*search.rounds(own, allowed)] if own_is_free else []
    coarse = coarse_lean(cost, allowed)
    start = None if coarse is None else search.followed(coarse, (0, 0))
    if start is not None:
        near = start.value.cost < FAR * own.value.cost or not own_is_free
        found += [start, *(search.rounds(start, allowed) if near else ())]
    return LeanChoice(cost=cost, rows=rows, own=own, found=tuple(found), begun=begun, own_is_free=own_is_free)


@dataclass(frozen=True, eq=False)
class _Search:
    job: Job
    begun: Upright
    rows: Rows
    cost: LeanCost
    commands: Callable[[PlannedPath], Floats]

    def rounds(self, start: _Candidate, allowed: Floats) -> Iterator[_Candidate]:
        """Refinements of a candidate, each with the flanks of the one before, until one costs more."""
        from compensator.turn.lean_refinement import refined_lean  # takes scipy, which a preview does without

        one = start
        for _ in range(ROUNDS):
            made = refined_lean(replace(self.cost, offset=one.offset), one.state[self.rows], allowed)
            found = self.followed(made.values, (made.windows, made.failed))
            if found is None:
                return
            yield found
            if found.value.cost >= one.value.cost:
                return
            one = found

    def followed(self, state: Floats, windows: tuple[int, int]) -> _Candidate | None:
        """The path with states (K, 3) rad; None where it is not free or cannot be followed, or has no commands."""
        if not self.cost.free(state).all():
            return None
        whole, path = _spread(self.rows, state, self.begun), self.begun.path
        try:
            turned = _followed(
                self.job, self.begun.toolpath, whole, self.begun.room, q=path.q, branch=path.branch
            )
        except PathError:
            return None
        return self.solved(_Candidate(turned, whole, self.cost.value(state), windows, offset=self.cost.offset))

    def solved(self, one: _Candidate) -> _Candidate | None:
        """Its cost and its flanks by solved commands; None where there are none."""
        try:
            q = self.commands(one.path)[self.rows]
        except SolveError:
            return None
        state = one.state[self.rows]
        offset = q - self.cost.postures(state).commands
        offset = (offset + np.pi) % (2 * np.pi) - np.pi
        return replace(one, value=self.cost.value(state, q), offset=offset)


def _cost(
    job: Job, begun: Upright, rows: Rows, *, wrench: Floats, clear: Clearance | None
) -> tuple[LeanCost, Floats]:
    path, room, inverse = begun.path, begun.room, job.planner.inverse
    motion, acceleration, allowed = key_motion(job, replace(path, toolpath=begun.toolpath), rows)
    numbers = list(inverse.tools.by_number)
    cost = LeanCost(
        kinematics=_kinematics(job, begun.toolpath, rows, room=room, branch=path.branch),
        motion=motion,
        arm=ArmRoom(job.planner.bounds, clear, rows),
        acceleration=acceleration,
        reliance=tuple(ToolReliance.of(job.arm, job.arm.predictors[k]) for k in numbers),
        wrench=wrench[rows],
        room=replace(room, radius=room.radius[rows], open=room.open[rows]),
        offset=np.zeros((len(rows), job.arm.robot.n)),
    )
    return cost, allowed


def _spread(rows: Rows, state: Floats, begun: Upright) -> Floats:
    """(N, 3) rad between the keys: a curve without overshoot, within the cone, upright where the tool may not lean."""
    count, room = len(begun.path), begun.room
    if len(rows) < count:
        from scipy.interpolate import PchipInterpolator

        state = PchipInterpolator(rows, state)(np.arange(count))
    out = np.array(state)
    out[:, 1:] = np.where(room.open[:, None], within_cone(out[:, 1:], room.cone), 0.0)
    return out
