"""The solve: commands whose deflected TCP stands on the nominal path; state, solve, check, repeat.

State and correction depend on each other: the flanks follow from the commanded moves, the commands
from the flanks. They are iterated until they agree. Where a flank changes between two poses the
path gets poses there, so that the change is not smeared over a segment.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job, check_cuts, check_tools
from compensator.errors import SolveError
from compensator.path.planner import Path, Planner
from compensator.path.pose_names import mm, place
from compensator.path.sampling import corners
from compensator.process.wrench import carried_wrench, process_wrench
from compensator.solve.compensation import Compensation
from compensator.solve.flank_poses import with_changes
from compensator.solve.joint_state import SAME_STATE, STATE_ROUNDS, commanded_moves, follow, settled_state
from compensator.solve.rapid_fade import faded_targets, held_targets
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.memory.preload import PreloadState, walk
from stiffness.statics.prediction import TOLERANCE, Command, Prediction, StartValues
from toolpaths.resample import resample
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]



UNSETTLED_FROM = 10  # rounds after which a state that still changes is taken as either


def sampled(job: Job, toolpath: Toolpath) -> Toolpath:
    """The toolpath with points as [sampling] asks for, checked against the cell's tools."""
    check_tools(job, toolpath)
    check_cuts(toolpath)
    s = job.cell.sampling
    dense = resample(toolpath, spacing=s.spacing / 1e3, angle=np.radians(s.angle))
    return corners(dense) if job.cell.process.frame == "path" else dense


def compensate(job: Job, toolpath: Toolpath, *, rapids_stay: bool = False) -> Compensation:
    """Solve the whole path.

    Args:
        rapids_stay: rapids are commanded as the toolpath has them, as in a program that is filtered in place; else the
            correction fades in and out along them.

    Raises:
        PathError, SolveError: names the pose, its line, the value and the bound.
    """
    planner = Planner(job.cell, job.robot, job.inverse, job.tools)
    path = planner.plan(sampled(job, toolpath))
    first = result = _solved(job, path, rapids_stay)
    finer = with_changes(planner, result)
    if finer is not None:
        result = _solved(job, finer, rapids_stay, result)
    refuse_unsafe(planner, result)
    before, _ = follow(job, result.path.toolpath, result.path.q, result.wrench)
    return replace(result, before=before, inserted=len(result) - len(first))


def uncompensated(job: Job, path: Path) -> Compensation:
    """The nominal path commanded as it is: what ``preview`` shows."""
    wrench = process_wrench(job.cell, path.toolpath, path.rotation, path.position)
    before, state = follow(job, path.toolpath, path.q, wrench)
    nothing = np.zeros(len(path))
    still = Command(
        path.q, path.q, before.torque, path.rotation, path.position, nothing, np.empty((len(path), 0)), 0
    )
    return Compensation(job, path, wrench, path.rotation, path.position, still, state, before, 0, 0)


def _near(old: Compensation, path: Path) -> StartValues:
    """The solution of ``old`` carried over to a path with poses put in between."""
    at, to = old.path.toolpath.row, path.toolpath.row

    def carried(values: Floats) -> Floats:
        return np.array([np.interp(to, at, column) for column in values.T]).reshape(-1, len(to)).T.copy()

    q, actual = carried(old.command.q - old.path.q), carried(old.command.actual - old.path.q)
    return StartValues(path.q + q, path.q + actual, carried(old.command.extra))


def _solved(job: Job, path: Path, rapids_stay: bool, old: Compensation | None = None) -> Compensation:
    """Commands for the poses as they are; state and correction agree in the result."""
    toolpath = path.toolpath
    wrench = process_wrench(job.cell, toolpath, path.rotation, path.position)
    if old is not None:
        wrench = carried_wrench(job.cell, wrench, toolpath, old.path.toolpath, old.wrench)
    near = None if old is None else _near(old, path)
    rotation, position = path.rotation, path.position
    held = np.flatnonzero((toolpath.kind != CUT) & rapids_stay)
    command, state, rounds = _agree(job, path, rotation, position, wrench, near, held)
    if len(held):
        rotation, position = held_targets(job, path, wrench, state, held)
    elif np.any(toolpath.kind != CUT):
        rotation, position = faded_targets(job, path, wrench, command, state)
        command, state, rounds = _agree(job, path, rotation, position, wrench, command, held)
    empty = Prediction(path.rotation, path.position, command.torque, command.error)
    return Compensation(job, path, wrench, rotation, position, command, state, empty, rounds, 0)


def _agree(
    job: Job,
    path: Path,
    rotation: Floats,
    position: Floats,
    wrench: Floats,
    near: StartValues | Command | None,
    held: npt.NDArray[np.intp],
) -> tuple[Command, PreloadState, int]:
    """Iterate command and state until the state stops changing; poses ``held`` are commanded as they are."""
    start = job.state_before
    state = walk(job.effects, job.values, commanded_moves(job, path.q), np.zeros_like(path.q), start)
    command: Command | None = None
    rows = np.arange(len(path))
    for rounds in range(1, STATE_ROUNDS + 1):
        if len(held):
            rotation, position = held_targets(job, path, wrench, state, held)
        begin = None if near is None else StartValues(near.q[rows], near.actual[rows], near.extra[rows])
        some = path.toolpath if command is None else path.toolpath.take(rows)
        part = job.command(
            some, rotation[rows], position[rows], wrench[rows], state.middle[rows], path.q[rows], begin
        )
        _refuse_unsolved(some, part)
        near = command = part if command is None else command.replaced(rows, part)
        if not state.low.shape[1]:
            break
        new = settled_state(job, command, state, start, commanded_moves)
        change = np.abs(new.middle - state.middle).max(axis=1)
        rows = np.flatnonzero(change > SAME_STATE)
        if not len(rows):
            break
        state = new if rounds < UNSETTLED_FROM else _either(path.toolpath, state, new, change)
    if command is None:
        raise SolveError(f"{path.toolpath.source}: no poses")
    return command, state, rounds


def _either(toolpath: Toolpath, state: PreloadState, new: PreloadState, change: Floats) -> PreloadState:
    """Where a torque of about zero makes the flank change with every correction, both are possible.

    Raises:
        SolveError: that is so at more than a few poses.
    """
    unsettled = change > SAME_STATE
    if unsettled.sum() > max(10, 0.01 * len(change)):
        k = int(np.argmax(unsettled))
        raise SolveError(
            f"{place(toolpath, k)}: joint state and correction do not agree at {int(unsettled.sum())} poses: every "
            "correction turns a joint around again. Check gap, breakaway and side of the backlash in the model"
        )
    both = PreloadState(np.minimum(state.low, new.low), np.maximum(state.high, new.high))
    rows = unsettled[:, None]
    return PreloadState(np.where(rows, both.low, new.low), np.where(rows, both.high, new.high))


def _refuse_unsolved(toolpath: Toolpath, command: Command) -> None:
    bad = ~command.converged
    if bad.any():
        worst = np.argsort(np.where(np.isfinite(command.error), command.error, np.inf))[::-1][:5]
        names = "; ".join(f"{place(toolpath, int(k))}: {command.error[k]:.1e}" for k in worst if bad[k])
        raise SolveError(
            f"{int(bad.sum())} of {len(bad)} poses have no command whose deflected TCP stands at the nominal pose "
            f"within {TOLERANCE:g} m and rad; the worst: {names}"
        )


def refuse_unsafe(planner: Planner, c: Compensation) -> None:
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
    planner.bounds.check(toolpath, c.command.q, "commanded")
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
