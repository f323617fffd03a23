"""The choice: where rails and tables stand along a path; one place each, or a smooth way of those that may move.

A lattice of places, turns and arm configurations gives the starts; the path is followed with each of them as it would
be run, and the declared cost decides. An axis moves where no fixed place serves, or where that costs clearly less.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.axes.axis_curve import CurveBasis, smoothed
from compensator.axes.axis_refinement import refined_axes
from compensator.axes.axis_search import AxisSearch, axis_search
from compensator.axes.axis_trial import AxisTrial, FollowedAxes, TurnAlong
from compensator.axes.axis_words import axis_uses, choice_findings
from compensator.axes.free_axes import FreeAxes
from compensator.cell.job import Job
from compensator.errors import PathError
from compensator.path.chosen_axes import ChosenAxes
from compensator.path.planned_path import PlannedPath
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

ROUNDS = 3  # of refinement, as long as they gain
PAYS = 0.9  # of the cost of the best fixed places: what gains less than a tenth is not worth moving tons for
BESIDE = 4  # rounds of looking beside the best fixed places, a cell away and nearer
CURVES, EVERY = (6, 320), 0.25  # coefficients of the curve of an axis, one for so many m of path
FINER = (2, 4)  # times as many, where the places between which a table has to keep are narrow
ARC = 0.5  # rad of a table, beside that: of a path about its axis
SHORTER = (1.0, 0.5, 0.2)  # of a refinement, until it can be followed between its keys too, and pays
INSTEAD, APART = 4, 1.0  # next best ones, mm or deg from each other somewhere
UNSETTLED = "a place or a way that costs less has no commands that agree with the joint states that they cause"
ENOUGH = 0.99  # of the cost: a round that gains less is the last


def chosen_axes(job: Job, toolpath: Toolpath, wrench: Callable[[PlannedPath], Floats]) -> PlannedPath:
    """A CAM path with axes where they cost least, as the arm follows it.

    Args:
        wrench: of the process along a path, (N, 6), base axes, about the TCP; its joint angles are not looked at.

    Raises:
        PathError: the arm has no closed form, or no place and no way serves; says which poses.
    """
    free = FreeAxes.of(job.placement, toolpath)
    if free is None:
        raise PathError(f"{job.placement.source}: no external axis is free")
    _refuse_touches(job, free)
    search = axis_search(job, free, toolpath, wrench)
    trial = AxisTrial(job, free, toolpath, stages=search.stages, wrench=search.wrench)
    fixed, places = _fixed(search, trial)
    ways, said = _moving(search, trial, fixed) if free.moving.any() else ([], ())
    taken, moving = fixed, min(ways, key=lambda one: one.value.cost, default=None)
    if moving is not None:
        taken = fixed = _cheaper(fixed, trial.stopped(moving))
    if moving is not None and (fixed is None or moving.value.cost < PAYS * fixed.value.cost):
        taken = moving
    if taken is None:
        raise PathError(search.refusal(trial.refused))
    path: PlannedPath | None = None
    for one in reversed(_instead(taken, [*places, *ways] if fixed is None else [fixed, *places, *ways])):
        path = replace(one.path, axes=_told(free, one, fixed, (*said, UNSETTLED)), instead=path)
    return replace(taken.path, axes=_told(free, taken, fixed, said), instead=path)


def _refuse_touches(job: Job, free: FreeAxes) -> None:
    """Refuse a table that may turn with a work object that was touched off."""
    turning = [name for name in free.names if job.placement.external[name].turns]
    if turning and job.placement.touches:
        raise PathError(
            f"{job.placement.source}: workobject.touched_off: the table {turning[0]} may turn along the path, and what "
            "the touches took off would turn with it: that is not built; take speed and acceleration of "
            f"external.{turning[0]} away, and it is set once"
        )


def _instead(taken: FollowedAxes, found: list[FollowedAxes]) -> list[FollowedAxes]:
    """The next best ones, should commands of what is taken not agree with their joint states; no two at one place."""
    out = [taken]
    for one in sorted(found, key=lambda f: f.value.cost):
        if len(out) <= INSTEAD and all(np.abs(one.places - o.places).max() > APART for o in out):
            out.append(one)
    return out[1:]


def _told(free: FreeAxes, taken: FollowedAxes, fixed: FollowedAxes | None, said: tuple[str, ...]) -> ChosenAxes:
    uses = axis_uses(free, taken.path.toolpath, taken.places)
    return ChosenAxes(
        uses=uses,
        constant=None if fixed is None else fixed.value,
        constant_places={} if fixed is None else free.by_name(fixed.places[0]),
        chosen=taken.value,
        windows=taken.windows,
        findings=tuple(choice_findings(free, uses, taken, fixed=fixed, said=said)),
    )


def _fixed(search: AxisSearch, trial: AxisTrial) -> tuple[FollowedAxes | None, list[FollowedAxes]]:
    """The best of the best few fixed places, and of places beside it: what is counted, reversals, is not smooth; and
    the best few."""
    found = [one for start in search.fixed_places() if (one := trial.fixed(start)) is not None]
    best = None
    for one in found:
        best = _cheaper(best, one)
    step = search.cell
    for _ in range(BESIDE):
        if best is None:
            return None, found
        tried = best
        for way in (*np.diag(step), *-np.diag(step)):
            tried = _cheaper(tried, trial.beside(best, way)) or tried
        step, best = (step if tried is not best else step / 2), tried
    return best, found


def _cheaper(one: FollowedAxes | None, other: FollowedAxes | None) -> FollowedAxes | None:
    return min((f for f in (one, other) if f is not None), key=lambda f: f.value.cost, default=None)


def _moving(
    search: AxisSearch, trial: AxisTrial, fixed: FollowedAxes | None
) -> tuple[list[FollowedAxes], tuple[str, ...]]:
    """Ways of the axes: refined from that over the lattice, and from the best fixed places; and what is to be said of
    starts that led nowhere."""
    length = float(np.linalg.norm(np.diff(trial.toolpath.on_part, axis=0), axis=1).sum())
    size = trial.free.size[trial.free.moving & ~trial.free.rail]
    every = min(EVERY, float(np.degrees(ARC) * size.min(initial=np.inf)))
    count = int(np.clip(length / every, *CURVES))
    basis = CurveBasis.of(float(trial.time[-1]), count)
    found, said = list[FollowedAxes](), list[str]()
    if fixed is not None:
        start = np.tile(fixed.places[0], (count, 1))
        found += _refined(trial, basis, start, (fixed.path.turn, fixed.path.branch))
    way = search.way()
    if way is not None:
        curve = smoothed(trial.free, basis, way, search.stages.time)
        for more in FINER if len(size) else ():
            if curve is None:
                basis = CurveBasis.of(float(trial.time[-1]), min(count * more, CURVES[1]))
                curve = smoothed(trial.free, basis, way, search.stages.time)
        if curve is not None:
            near = _refined(trial, basis, curve, trial.turn_along(basis, curve, way))
            found += near
        if curve is None:
            limits = f"speed and acceleration of the {_kind(trial.free)}"
            said.append(f"near the way over the lattice no smooth one is within {limits}")
        elif not near:
            said.append(f"the arm cannot follow the smooth way of the {_kind(trial.free)} near that over the lattice")
    return found, tuple(said)


def _kind(free: FreeAxes) -> str:
    """What moves."""
    kinds = ["rail" if rail else "table" for rail in free.rail[free.moving].tolist()]
    return " and the ".join(dict.fromkeys(kinds))


def _refined(trial: AxisTrial, basis: CurveBasis, start: Floats, turn: TurnAlong) -> list[FollowedAxes]:
    """A start and what is refined of it as long as that gains, each time at the turns that the path before it took;
    empty: it cannot be followed."""
    one, found = trial.moving(basis, start, turn), list[FollowedAxes]()
    for _ in range(ROUNDS):
        if one is None or one.coefficients is None:
            break
        start = one.coefficients
        made = refined_axes(one.cost, basis, start, trial.time[one.cost.rows])
        windows, turn = (made.windows, made.failed), (one.path.turn, one.path.branch)
        tried = (trial.moving(basis, start + share * (made.values - start), turn, windows) for share in SHORTER)
        before = one.value.cost
        better = next((other for other in tried if other is not None and other.value.cost < before), None)
        if better is not None:
            found.append(one)
        one = replace(one, windows=windows) if better is None else better
        if one.value.cost >= ENOUGH * before:
            break
    return found if one is None else [*found, one]
