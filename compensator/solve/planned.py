"""The path of a run: checked against the tools, sampled, and followed by the arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.axes.free_axes import FreeAxes
from compensator.cell.external_axes import moved_workobject
from compensator.cell.job import Job
from compensator.cell.placement import Placement
from compensator.errors import CellError, PathError
from compensator.path.chosen_axes import ChosenAxes
from compensator.path.failure_hints import failure_hints
from compensator.path.lean import LeanRoom
from compensator.path.planned_path import PlannedPath
from compensator.scene.clearance import clearance
from compensator.solve.agreement import agreed
from compensator.solve.load_along import load_along
from compensator.solve.motion_limits import within_limits
from compensator.turn.lean_choice import Upright, lean_choice, reached_by_leaning, upright
from compensator.turn.turn_choice import refuse_fixed, turn_choice
from compensator.turn.turn_grid import Clearance
from toolpaths.resample import resample
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]


def planned(job: Job, toolpath: Toolpath) -> PlannedPath:
    """A toolpath as the arm of a job follows it.

    Raises:
        CellError, PathError, ToolpathError: a tool is missing, nothing cuts, or the arm cannot follow; names the pose.
    """
    path, solve = sampled(job.placement, toolpath), job.placement.solve
    room = room_to_lean(job, path) if solve.lean > 0 else None
    if any(axis.free for axis in job.placement.external.values()):
        from compensator.axes.axis_choice import chosen_axes  # takes scipy, which a preview does without

        begun = chosen_axes(job, path, lambda one: load_along(job, one).wrench)
        followed = _with_axes(_with_chosen(job, begun, room), begun.axes)
    else:
        followed = _fixed_base(job, path, room)
    return with_feeds_in_limits(job, followed, followed.q)


def _fixed_base(job: Job, path: Toolpath, room: LeanRoom | None) -> PlannedPath:
    """A sampled path as the arm follows it, its turn and lean chosen where that is asked for; ``room`` to lean.

    Raises:
        CellError, PathError: the arm cannot follow.
    """
    try:
        followed = job.planner.plan(path)
    except PathError as e:
        begun = None if room is None else reached_by_leaning(job, path, room)
        if begun is None:
            raise PathError(f"{e}{failure_hints(job.planner, path, job.placement.conditions.gravity)}") from e
        return _with_chosen_lean(job, begun, load_along(job, begun.path).wrench)
    return _with_chosen(job, followed, room)


def _with_chosen(job: Job, path: PlannedPath, room: LeanRoom | None) -> PlannedPath:
    """The path with its turn, and with ``room`` its lean, chosen along it where that is asked for."""
    if job.placement.solve.turn != "path" and room is None:
        return path
    wrench = load_along(job, path).wrench
    turned = _with_chosen_turn(job, path, wrench)
    return turned if room is None else _with_chosen_lean(job, upright(turned, room), wrench)


def _with_axes(path: PlannedPath, axes: ChosenAxes | None) -> PlannedPath:
    """The path, and what would stand in for it, with what was chosen before it was followed; another choice of axes
    keeps its own."""
    if axes is None:
        return path
    instead = None if path.instead is None else _with_axes(path.instead, axes)
    return replace(path, axes=path.axes or axes, instead=instead)


def room_to_lean(job: Job, path: Toolpath) -> LeanRoom:
    """Where the tool of a path may lean.

    Raises:
        CellError, PathError: nothing is open there, or leaning would cut another surface.
    """
    placement = job.placement
    refuse_fixed(job, path)
    return LeanRoom.of(float(np.radians(placement.solve.lean)), path, placement.cutters, placement.source)


def _with_chosen_turn(job: Job, path: PlannedPath, wrench: Floats) -> PlannedPath:
    """The path with the turn that costs least under a wrench (N, 6), by commands that are solved for."""
    return turn_choice(job, path, wrench, _clear(job, path)).taken(_commands(job, wrench))


def _with_chosen_lean(job: Job, begun: Upright, wrench: Floats) -> PlannedPath:
    """The path with the lean that costs least under a wrench (N, 6), by commands that are solved for."""
    clear, commands = _clear(job, begun.path), _commands(job, wrench)
    return lean_choice(job, begun, wrench, clear=clear, commands=commands).taken()


def _clear(job: Job, path: PlannedPath) -> Clearance | None:
    return clearance(job, path.toolpath) if job.placement.surroundings.scene else None


def _commands(job: Job, wrench: Floats) -> Callable[[PlannedPath], Floats]:
    """(N, n) rad, commands of a path under a wrench (N, 6)."""
    none_held = np.empty(0, dtype=np.intp)

    def commands(one: PlannedPath) -> Floats:
        found, _, _ = agreed(job.arm, job.placement.start, one, one.tcp, wrench=wrench, near=None, held=none_held)
        return found.q

    return commands


def with_feeds_in_limits(job: Job, path: PlannedPath, q: Floats) -> PlannedPath:
    """Where [solve] asks for it, the path with feeds at which joint angles ``q`` (N, n) rad stay within the limits."""
    if job.placement.solve.feed != "limit":
        return path
    return within_limits(job.arm.robot, path, q, job.placement.program.default_feed / 60e3)


def sampled(placement: Placement, toolpath: Toolpath) -> Toolpath:
    """The toolpath with points as [sampling] asks for, checked against the tools.

    Raises:
        CellError, ToolpathError: a tool is missing, nothing cuts, or there are too many poses.
    """
    _refuse_without_cuts(toolpath)
    _refuse_missing_tools(placement, toolpath)
    s = placement.sampling
    dense = resample(_under_declared_tools(placement, toolpath), spacing=s.spacing / 1e3, angle=np.radians(s.angle))
    moved = moved_workobject(placement, dense)
    made = placement.process.with_corner_poses(dense, None if moved is None else moved.inward(dense.position))
    free = FreeAxes.of(placement, made)
    return made if free is None else free.sampled(made)


def _refuse_missing_tools(placement: Placement, toolpath: Toolpath) -> None:
    """Refuse a tool that cuts without a [tools.N], and several that cut with one [tool]."""
    tools, cuts = placement.tools, np.flatnonzero(toolpath.kind == CUT)
    used = toolpath.tool[cuts]
    if tools.any_number and (used != used[0]).any():
        k = int(cuts[np.argmax(used != used[0])])
        numbers = sorted({int(number) for number in used})
        raise CellError(
            f"{toolpath.where(k)}: a cut with tool {toolpath.tool[k]} after cuts with tool {used[0]} "
            f"({toolpath.line_words(int(cuts[0]))}), and [tool] of {placement.source} is one tool: give "
            f"{', '.join(f'[tools.{number}]' for number in numbers)} in its place"
        )
    missing = ~np.isin(used, list(tools.by_number))
    if missing.any() and not tools.any_number:
        k = int(cuts[np.argmax(missing)])
        number = int(toolpath.tool[k])
        what = f"tool {number} cuts" if number else "a cut before any tool call"
        raise CellError(
            f"{toolpath.where(k)}: {what}, but {placement.source} has [tools.N] for "
            f"{', '.join(map(str, sorted(tools.by_number)))} only"
        )


def _under_declared_tools(placement: Placement, toolpath: Toolpath) -> Toolpath:
    """Rapids with a tool that nobody declared, as before the first call, have that of the next pose that has one."""
    tools = placement.tools
    strange = ~np.isin(toolpath.tool, list(tools.by_number))
    if tools.any_number or not strange.any():
        return toolpath
    known = np.flatnonzero(~strange)
    following = known[np.minimum(np.searchsorted(known, np.arange(len(toolpath))), len(known) - 1)]
    return replace(toolpath, tool=toolpath.tool[np.where(strange, following, np.arange(len(toolpath)))])


def _refuse_without_cuts(toolpath: Toolpath) -> None:
    if not np.any(toolpath.kind == CUT):
        raise CellError(f"{toolpath.source}: no cutting move (feed) in it: nothing to compensate")
