"""The solve: commands whose deflected TCP stands on the nominal path; state, solve, check, repeat.

State and correction depend on each other: the flanks follow from the commanded moves, the commands
from the flanks. They are iterated until they agree. Where a flank changes between two poses the
path gets poses there, so that the change is not smeared over a segment.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.errors import SolveError
from compensator.fade import faded_targets
from compensator.job import Job, check_cuts, check_tools
from compensator.path import Path, Planner, mm, place
from compensator.process.wrench import process_wrench
from compensator.sampling import between, corners
from stiffness.inverse import SphericalInverse
from stiffness.predict import TOLERANCE, Command, Near, Prediction
from stiffness.preload import PreloadState, walk
from toolpaths.resample import resample
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]

STATE_ROUNDS = 30
INSERT_ROUNDS = 3
STEPS = 16  # parts that a segment with a flank change is cut into, per round
SHORTEST = 5e-5  # m; a change is not located finer than this
WORTH_A_POSE = 5e-7  # rad; a change of joint deflection below is left where it is


@dataclass(frozen=True, repr=False)
class Compensation:
    """A path with its commands.

    Attributes:
        job, path: what was asked.
        wrench: (N, 6) on the robot, base axes, about the TCP.
        target_rotation, target_position: where the TCP has to be, base. Differs from the nominal path only
            where a correction fades along a rapid.
        command: the solve.
        state: of every pose.
        before: the equilibrium when the nominal poses are commanded.
        iterations: rounds until state and correction agreed.
        inserted: poses that flank changes needed.
    """

    job: Job
    path: Path
    wrench: Floats
    target_rotation: Floats
    target_position: Floats
    command: Command
    state: PreloadState
    before: Prediction
    iterations: int
    inserted: int

    def __len__(self) -> int:
        return len(self.path)

    def __repr__(self) -> str:
        return f"Compensation({self.path.toolpath.source!r}, {len(self)} poses, {self.iterations} rounds)"

    @property
    def cutting(self) -> npt.NDArray[np.bool_]:
        """(N,) which poses cut."""
        return np.asarray(self.path.toolpath.kind == CUT)

    @property
    def correction(self) -> Floats:
        """(N, 3) m, base axes: command minus nominal."""
        return self.command.position - self.path.position

    @property
    def error_before(self) -> Floats:
        """(N, 3) m, base axes: TCP error when the nominal poses are commanded."""
        return self.before.position - self.path.position


def sampled(job: Job, toolpath: Toolpath) -> Toolpath:
    """The toolpath with points as [sampling] asks for, checked against the cell's tools."""
    check_tools(job, toolpath)
    check_cuts(toolpath)
    s = job.cell.sampling
    dense = resample(toolpath, spacing=s.spacing / 1e3, angle=np.radians(s.angle))
    return corners(dense) if job.cell.process.frame == "path" else dense


def compensate(job: Job, toolpath: Toolpath) -> Compensation:
    """Solve the whole path.

    Raises:
        PathError, SolveError: names the pose, its line, the value and the bound.
    """
    planner = Planner(job.cell, job.robot, job.inverse, job.tools)
    path = planner.plan(sampled(job, toolpath))
    result = _solved(job, path)
    inserted = 0
    for _ in range(INSERT_ROUNDS):
        finer = _with_changes(job, planner, result)
        if finer is None:
            break
        inserted += len(finer) - len(result)
        result = finer
    _check(planner, result)
    return replace(result, before=predict_nominal(job, result.path, result.wrench), inserted=inserted)


def uncompensated(job: Job, path: Path) -> Compensation:
    """The nominal path commanded as it is: what ``preview`` shows."""
    wrench = process_wrench(job.cell, path.toolpath, path.rotation, path.position)
    before, state = follow(job, path.toolpath, path.q, wrench)
    nothing = np.zeros(len(path))
    still = Command(
        path.q, path.q, before.torque, path.rotation, path.position, nothing, np.empty((len(path), 0)), 0
    )
    return Compensation(job, path, wrench, path.rotation, path.position, still, state, before, 0, 0)


def _moves(job: Job, q: Floats) -> Floats:
    """(N, n) commanded move to every pose; the first one from [start], if there is one."""
    first = q[:1] if job.cell.start is None else np.radians([job.cell.start.joints])
    return np.diff(q, axis=0, prepend=first)


def _near(old: Compensation, path: Path) -> Near:
    """The solution of ``old`` carried over to a path with poses put in between."""
    at, to = old.path.toolpath.row, path.toolpath.row

    def carried(values: Floats) -> Floats:
        return np.array([np.interp(to, at, column) for column in values.T]).reshape(-1, len(to)).T.copy()

    q, actual = carried(old.command.q - old.path.q), carried(old.command.actual - old.path.q)
    return Near(path.q + q, path.q + actual, carried(old.command.twists))


def _solved(job: Job, path: Path, old: Compensation | None = None) -> Compensation:
    """Commands for the poses as they are; state and correction agree in the result."""
    toolpath = path.toolpath
    wrench = process_wrench(job.cell, toolpath, path.rotation, path.position)
    rotation, position = path.rotation, path.position
    command, state, rounds = _agree(job, path, rotation, position, wrench, old and _near(old, path))
    if np.any(toolpath.kind != CUT):
        rotation, position = faded_targets(job, path, wrench, command, state)
        command, state, rounds = _agree(job, path, rotation, position, wrench, command)
    empty = Prediction(path.rotation, path.position, command.torque, command.error)
    return Compensation(job, path, wrench, rotation, position, command, state, empty, rounds, 0)


def _agree(
    job: Job, path: Path, rotation: Floats, position: Floats, wrench: Floats, near: Near | Command | None
) -> tuple[Command, PreloadState, int]:
    """Iterate command and state until the state stops changing."""
    start = job.state_before
    guess = walk(job.effects, job.values, _moves(job, path.q), np.zeros_like(path.q), start)
    for rounds in range(1, STATE_ROUNDS + 1):
        state = guess
        begin = near and Near(near.q, near.actual, near.twists)
        near = command = job.command(path.toolpath, rotation, position, wrench, state.middle, path.q, begin)
        _refuse_unsolved(path.toolpath, command)
        if not state.low.shape[1]:
            return command, state, rounds
        without = command.q + job.joint_states(state.middle)
        guess = walk(job.effects, job.values, _moves(job, without), command.torque, start, corrected=True)
        change = np.abs(guess.middle - state.middle).max(axis=1)
        if not np.any(change > 1e-9):
            return command, state, rounds
    k = int(np.argmax(change))
    raise SolveError(
        f"{place(path.toolpath, k)}: joint state and correction do not agree after {STATE_ROUNDS} rounds at "
        f"{int(np.sum(change > 1e-9))} poses: every correction turns a joint around again. Check gap, breakaway and "
        "side of the backlash in the model"
    )


def _refuse_unsolved(toolpath: Toolpath, command: Command) -> None:
    bad = ~command.converged
    if bad.any():
        worst = np.argsort(np.where(np.isfinite(command.error), command.error, np.inf))[::-1][:5]
        names = "; ".join(f"{place(toolpath, int(k))}: {command.error[k]:.1e}" for k in worst if bad[k])
        raise SolveError(
            f"{int(bad.sum())} of {len(bad)} poses have no command whose deflected TCP stands at the nominal pose "
            f"within {TOLERANCE:g} m and rad; the worst: {names}"
        )


def _jumps(job: Job, c: Compensation) -> Floats:
    """(N - 1,) rad: change of joint deflection between neighbours that comes from state alone."""
    state, tau = c.state.middle, c.command.torque
    if not state.shape[1]:
        return np.zeros(len(c) - 1)
    then = job.joint_deflection(c.command.q[1:], tau[1:], state[:-1])
    now = job.joint_deflection(c.command.q[1:], tau[1:], state[1:])
    return np.asarray(np.abs(now - then).max(axis=1))


def _with_changes(job: Job, planner: Planner, c: Compensation) -> Compensation | None:
    """The path with poses around every flank change in a cut; None when nothing is left to locate."""
    toolpath = c.path.toolpath
    length = np.linalg.norm(np.diff(toolpath.position, axis=0), axis=1)
    change = (_jumps(job, c) > WORTH_A_POSE) & (length > SHORTEST) & (toolpath.kind[1:] == CUT)
    if not change.any():
        return None
    segments = np.flatnonzero(change)
    fractions = np.arange(1, STEPS) / STEPS
    fine, added = between(toolpath, np.repeat(segments, STEPS - 1), np.tile(fractions, len(segments)))
    solved = _solved(job, planner.again(c.path, fine), c)
    keep = ~added | _bends(_jumps(job, solved), added)
    if keep.sum() == len(toolpath):
        return None
    return _solved(job, planner.again(solved.path, fine.take(np.flatnonzero(keep))), solved)


def _bends(jump: Floats, added: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Which added poses stand where a change begins or ends."""
    left = np.concatenate([[0.0], jump]) > WORTH_A_POSE
    right = np.concatenate([jump, [0.0]]) > WORTH_A_POSE
    return np.asarray(added & (left != right))


def _check(planner: Planner, c: Compensation) -> None:
    """Refuse a command beyond a limit, through a singularity, with a jump, or a correction above its bound."""
    toolpath = c.path.toolpath
    _check_identified(c)
    size = np.linalg.norm(c.correction, axis=1) * 1e3
    bound = c.job.cell.solve.max_correction
    if not np.all(size <= bound):
        k = int(np.argmax(np.where(np.isfinite(size), size, np.inf)))
        raise SolveError(
            f"{place(toolpath, k)}: correction {size[k]:.3f} mm is above solve.max_correction = {bound:g} mm "
            f"({int(np.sum(~(size <= bound)))} poses; TCP {mm(toolpath.position[k])} mm in the work object). Check the "
            "wrench, the stiffness and their units; gravity = 'uncompensated' adds the whole sag of the arm"
        )
    planner.check(toolpath, c.command.q, "commanded")
    if isinstance(c.job.inverse, SphericalInverse):
        branch = c.job.inverse.configuration(c.command.q)
        other = branch != c.path.branch
        if other.any():
            k = int(np.argmax(other))
            raise SolveError(
                f"{place(toolpath, k)}: the corrected command lies in another arm configuration (ABB cfx {branch[k]}, "
                f"path {c.path.branch}): too near the border between two; move [workobject] or choose another [start]"
            )


def _check_identified(c: Compensation) -> None:
    """Refuse a path that loads a joint whose stiffness the data did not determine."""
    for effect, flags in c.job.model.identified.items():
        if flags.all():
            continue
        unloaded = c.job.forward(c.path.toolpath, c.command.q, np.zeros_like(c.wrench), c.state.middle)
        process = np.abs(c.command.torque - unloaded.torque)
        for j in np.flatnonzero(~flags):
            if process[:, j].max() > 1.0:
                k = int(np.argmax(process[:, j]))
                raise SolveError(
                    f"{place(c.path.toolpath, k)}: the process loads joint {j + 1} with {process[k, j]:.0f} N*m, but "
                    f"{effect} of joint {j + 1} is not identified in {c.job.model.source}; measure it first"
                )


def predict_nominal(job: Job, path: Path, wrench: Floats) -> Prediction:
    """Where the TCP goes when the nominal poses are commanded."""
    return follow(job, path.toolpath, path.q, wrench)[0]


def follow(job: Job, toolpath: Toolpath, q: Floats, wrench: Floats) -> tuple[Prediction, PreloadState]:
    """Equilibrium along a commanded path, with the state that the commands themselves cause.

    The torque that decides the state is that of the deflected posture: two rounds settle it.
    """
    start, moves = job.state_before, _moves(job, q)
    state = walk(job.effects, job.values, moves, np.zeros_like(q), start)
    prediction = job.forward(toolpath, q, wrench, state.middle)
    for _ in range(STATE_ROUNDS if state.low.shape[1] else 0):
        new = walk(job.effects, job.values, moves, prediction.torque, start)
        same = not np.any(np.abs(new.middle - state.middle) > 1e-12)
        state = new
        if same:
            break
        prediction = job.forward(toolpath, q, wrench, state.middle)
    return prediction, state


def spread_of_unknown(job: Job, toolpath: Toolpath, q: Floats, wrench: Floats, state: PreloadState) -> Floats:
    """(N,) m: distance between the TCP with the lowest and the highest state that the data allows."""
    out = np.zeros(len(q))
    rows = np.flatnonzero(~state.known.all(axis=1)) if state.low.shape[1] else np.empty(0, dtype=np.intp)
    if len(rows):
        part = toolpath.take(rows)
        low = job.forward(part, q[rows], wrench[rows], state.low[rows])
        high = job.forward(part, q[rows], wrench[rows], state.high[rows])
        out[rows] = np.linalg.norm(high.position - low.position, axis=1)
    return out
