"""The solve: commands whose deflected TCP stands on the nominal path; state, solve, check, repeat.

State and correction depend on each other and are iterated until they agree. Where a flank changes between two
poses the path gets poses there, so that the change is not smeared over a segment.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.errors import PathError, SolveError
from compensator.path.planned_path import PlannedPath
from compensator.process.process import ProcessLoad
from compensator.solve.agreement import agreed
from compensator.solve.command_bounds import refuse_unsafe
from compensator.solve.compensation import Compensation
from compensator.solve.cutter_offset import at_the_wall, with_offset_findings
from compensator.solve.flank_poses import with_flank_poses
from compensator.solve.joint_state import equilibria, equilibrium_columns
from compensator.solve.load_along import load_along
from compensator.solve.planned import with_feeds_in_limits
from compensator.solve.rapid_fade import faded_targets, held_targets
from compensator.solve.share_sizes import share_sizes
from compensator.solve.thinned import thinned
from compensator.solve.touching_off import touched_off
from compensator.solve.uncertainty import band_rows
from stiffness.memory.preload import PreloadState
from stiffness.numerics.beside import beside
from stiffness.statics.prediction import Command, PathColumns, StartValues
from toolpaths.columns import give_back
from toolpaths.finding import ERROR
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]

FEED_ROUNDS = 3  # of lowering feeds to what the joints can follow; each leaves a reserve, so that one or two do


def compensate(
    job: Job, path: PlannedPath, *, rapids_stay: bool = False, load: ProcessLoad | None = None
) -> Compensation:
    """Solve a planned path; poses are put in where flanks change.

    Args:
        rapids_stay: rapids are commanded as the toolpath has them, as in a program that is filtered in place; else the
            correction fades in and out along them.
        load: of the process along ``path``, where it is known.

    Raises:
        PathError, SolveError: names the pose, its line, the value and the bound.
    """
    handed = [path]
    del path  # one with poses put in is another one: nobody above keeps the one without, so that it can go
    result = _with_some_turn(job, handed.pop(), rapids_stay=rapids_stay, load=load)
    for _ in range(FEED_ROUNDS):
        slower = with_feeds_in_limits(job, result.path, result.command.q)
        if slower is result.path:
            break
        path = _with_feeds_of(slower, result.uncompensated.path)
        result = _compensated(job, path, rapids_stay=rapids_stay)
        refuse_unsafe(result)
    return result


def _with_some_turn(
    job: Job, path: PlannedPath, *, rapids_stay: bool, load: ProcessLoad | None
) -> Compensation:
    """Of the path, or of the next best where no commands agree with the joint states that they cause."""
    while True:
        handed, instead = [path], path.instead
        del path
        try:
            result = _compensated(job, handed.pop(), rapids_stay=rapids_stay, load=load)
            refuse_unsafe(result)
            return result
        except (PathError, SolveError):
            if instead is None:
                raise
            path, load = with_feeds_in_limits(job, instead, instead.q), None


def _with_feeds_of(finer: PlannedPath, path: PlannedPath) -> PlannedPath:
    """``path`` with the feeds of ``finer``, which has poses put in: the slowest of all parts of a move."""
    begin = np.append(0, np.searchsorted(finer.toolpath.row, path.toolpath.row[:-1], side="right"))
    feed = np.fmin.reduceat(finer.toolpath.feed, begin)
    programmed = None if finer.programmed is None else np.maximum.reduceat(finer.programmed, begin)
    return PlannedPath(
        toolpath=replace(path.toolpath, feed=feed), tcp=path.tcp, q=path.q, turn=path.turn, branch=path.branch,
        programmed=programmed, chosen=path.chosen, instead=path.instead, axes=path.axes,
    )  # fmt: skip


def _compensated(
    job: Job, path: PlannedPath, *, rapids_stay: bool, load: ProcessLoad | None = None
) -> Compensation:
    """As ``compensate``, at the feeds of the path, and not yet looked at for what no robot may be sent."""
    job, along = touched_off(job, path), _sound(path, load_along(job, path) if load is None else load)
    count = len(path)
    del load
    with beside(lambda: _predicted(job, path, along), known=(job, path, along), poses=count) as plainly:
        result = _solved(job, path, along, rapids_stay=rapids_stay)
        position, state = plainly.result()
    del plainly
    columns = {"position": position, "torque": np.broadcast_to(np.nan, path.q.shape)}  # these are the preview's own
    plain = as_it_is(job, path, along, columns=columns, state=state)
    along = along.predicted(band_rows(plain))
    plain, result, before = replace(plain, load=along), replace(result, load=result.load.solved()), plain.before
    # with joint memory a core is idle now; a stock would be held longer by the other process
    idle = job.arm.unknown_state.low.size > 0 and type(along) is ProcessLoad
    with beside(lambda: share_sizes(plain), known=(plain,), poses=count if idle else 0) as sized:
        finer = with_flank_poses(result)
        if finer is not None:
            near = None if job.arm.closed_form else _carried_over(result, finer)
            del result  # a million poses of it are half a gigabyte, and its stock as much as that
            give_back()
            finer_load = _sound(finer, load_along(job, finer, (path.toolpath, along)))
            plain = thinned(plain, finer, finer_load)
            del path, along
            give_back()
            known = (job, finer, finer_load)
            with beside(lambda: _positions(job, finer, finer_load), known=known, poses=len(finer)) as nominally:
                result = _solved(job, finer, finer_load, rapids_stay=rapids_stay, near=near)
                before = nominally.result()
            del near
        plain = replace(plain, shares=sized.found())
    found = with_offset_findings(job, result.path.toolpath, result.load)
    return replace(result, load=found, before=before, inserted=len(result) - count, plain=plain)


def _predicted(job: Job, path: PlannedPath, load: ProcessLoad) -> tuple[Floats, PreloadState]:
    """(N, 3) m where the TCP stands when the nominal poses are commanded, and the state."""
    start, names = job.placement.start, ("position",)
    columns, state = equilibrium_columns(job.arm, start, path.toolpath, q=path.q, wrench=load.wrench, names=names)
    return columns["position"], state


def _positions(job: Job, path: PlannedPath, load: ProcessLoad) -> Floats:
    """As ``_predicted``, of states no more than those of a piece."""
    columns, start = PathColumns(len(path), ("position",)), job.placement.start
    for rows, prediction, _ in equilibria(job.arm, start, path.toolpath, q=path.q, wrench=load.wrench):
        columns.put(rows, prediction)
    return columns.whole["position"]


def uncompensated(job: Job, path: PlannedPath, load: ProcessLoad | None = None) -> Compensation:
    """The nominal path commanded as it is: what ``preview`` shows; ``load``: of the process, where it is known."""
    job, load = touched_off(job, path), load_along(job, path) if load is None else load
    start, names = job.placement.start, ("position", "torque")
    columns, state = equilibrium_columns(job.arm, start, path.toolpath, q=path.q, wrench=load.wrench, names=names)
    return as_it_is(job, path, load, columns=columns, state=state)


def as_it_is(
    job: Job, path: PlannedPath, load: ProcessLoad, *, columns: Mapping[str, Floats], state: PreloadState
) -> Compensation:
    """The nominal path commanded as it is; ``columns``: ``position`` and ``torque`` of the Prediction."""
    still = Command(
        q=path.q,
        actual=path.q,
        torque=columns["torque"],
        nominal=lambda q: path.tcp,
        error=np.broadcast_to(0.0, len(path)),
        extra=np.empty((len(path), 0)),
        steps=0,
    )
    return Compensation(
        job=job, path=path, load=load, target=path.tcp, command=still, state=state, before=columns["position"],
        iterations=0, inserted=0,
    )  # fmt: skip


def _sound(path: PlannedPath, load: ProcessLoad) -> ProcessLoad:
    """The load as it is.

    Raises:
        SolveError: the process found an error; all that it found is listed.
    """
    if any(f.level == ERROR for f in load.findings):
        listed = "\n".join(f"  {f}" for f in load.findings)
        raise SolveError(f"{path.toolpath.source}: the process is refused:\n{listed}")
    return load


def _carried_over(old: Compensation, path: PlannedPath) -> StartValues:
    """The solution of ``old`` at a path with poses put in between."""
    at, to = old.path.toolpath.row, path.toolpath.row

    def carried(values: Floats) -> Floats:
        return np.array([np.interp(to, at, column) for column in values.T]).reshape(-1, len(to)).T.copy()

    q, actual = carried(old.command.q - old.path.q), carried(old.command.actual - old.path.q)
    return StartValues(path.q + q, path.q + actual, carried(old.command.extra))


def _solved(
    job: Job, path: PlannedPath, load: ProcessLoad, *, rapids_stay: bool, near: StartValues | None = None
) -> Compensation:
    """Commands for the poses as they are; state and correction agree in the result."""
    arm, start, toolpath, wrench = job.arm, job.placement.start, path.toolpath, load.wrench
    target = at_the_wall(arm, path, load.wall)
    held = np.flatnonzero((toolpath.kind != CUT) & rapids_stay)
    command, state, rounds = agreed(arm, start, path, target, wrench=wrench, near=near, held=held)
    if len(held):
        target = held_targets(arm, path, wrench, state, target=target, rows=held)
    elif np.any(toolpath.kind != CUT):
        target = faded_targets(
            arm, path, command, state, target=target, fade=job.placement.solve.fade / 1e3
        )
        del state  # of every pose that changes it, all joints
        command, state, rounds = agreed(arm, start, path, target, wrench=wrench, near=command, held=held)
    return Compensation(
        job=job,
        path=path,
        load=load,
        target=target,
        command=command,
        state=state,
        before=np.broadcast_to(np.nan, (len(path), 3)),  # not known yet
        iterations=rounds,
        inserted=0,
    )
