"""From poses to arm configurations: inverse kinematics along the path, one branch, no jumps.

Where the file leaves the turn about the tool axis open it is chosen: first one turn for the whole path, the
best of a grid; where none serves, a turn that varies along the path, by dynamic programming.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from compensator.errors import PathError
from compensator.path.first_postures import FirstPostures
from compensator.path.free_turn import about_tool_axis, reference_rotation, varying_turn
from compensator.path.motion_bounds import MotionBounds
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import mm, place
from compensator.path.tcp_inverse import TcpInverse
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


class Planner:
    """Follows toolpaths with one arm at one placement.

    Args:
        inverse, bounds: of the arm with its tools.
        workobject: in the base.
        start: (n,) rad where the arm comes from; None: not known.
        free_tool_axis: the turn about the tool axis may be chosen where the toolpath leaves it open.
        source: the file that gives these, for messages.
    """

    def __init__(
        self,
        inverse: TcpInverse,
        bounds: MotionBounds,
        *,
        workobject: Frame,
        start: Floats | None,
        free_tool_axis: bool,
        source: str,
    ) -> None:
        self.inverse, self.bounds, self.robot = inverse, bounds, inverse.robot
        self.workobject, self.start = workobject, start
        self.free_tool_axis, self.source = free_tool_axis, source

    def __repr__(self) -> str:
        return f"Planner({self.robot.name}, {self.source!r})"

    def plan(self, toolpath: Toolpath) -> PlannedPath:
        """Choose turn and configuration, and follow the whole path.

        Raises:
            PathError: names the pose, its source line, the joint or measure, the value and the bound.
        """
        reference, choice = self._reference(toolpath), self._choice(toolpath)
        first: PathError | None = None
        for c in choice.for_path(toolpath, reference):
            try:
                turn = np.full(len(toolpath), c.turn)
                return self._follow(toolpath, reference, turn=turn, branch=c.branch, seed=c.seed)
            except PathError as e:
                first = first or e
        if choice.turn_is_open:
            path = self._with_varying_turn(toolpath, reference)
            if path is not None:
                return path
        if first is None:
            raise PathError(self._out_of_reach(toolpath, reference, choice))
        raise first

    def again(self, path: PlannedPath, toolpath: Toolpath) -> PlannedPath:
        """Follow the path again after poses were put in between, with the same choices."""
        turn = np.interp(toolpath.row, path.toolpath.row, path.turn)
        return self._follow(toolpath, self._reference(toolpath), turn=turn, branch=path.branch, seed=path.q[0])

    def tcp(self, path: PlannedPath, toolpath: Toolpath) -> Frame:
        """(N) TCP in the base after poses were put into ``path``: same turns."""
        turn = np.interp(toolpath.row, path.toolpath.row, path.turn)
        return about_tool_axis(self._reference(toolpath), turn)

    def part(self, path: PlannedPath, toolpath: Toolpath, rows: Rows) -> PlannedPath:
        """Some poses of a path with poses put in between, each near its neighbours in ``path``."""
        some, tcp = toolpath.take(rows), self.tcp(path, toolpath).take(rows)
        seed = np.array([np.interp(some.row, path.toolpath.row, column) for column in path.q.T]).T
        batch = self.inverse.along(some, tcp, path.branch, seed)
        return PlannedPath(toolpath=some, tcp=tcp, q=batch.q, turn=np.zeros(len(rows)), branch=path.branch)

    def _reference(self, toolpath: Toolpath) -> Frame:
        """(N) TCP in the base, before it is turned about the tool axis."""
        return self.workobject.then(Frame(reference_rotation(toolpath), toolpath.position))

    def _choice(self, toolpath: Toolpath) -> FirstPostures:
        turn_is_open = toolpath.quaternion is None and self.free_tool_axis
        return FirstPostures(self.inverse, self.bounds, self._checked_start(), turn_is_open)

    def _checked_start(self) -> Floats | None:
        start, robot = self.start, self.robot
        if start is None:
            return None
        if len(start) != robot.n:
            raise PathError(f"{self.source}: start.joints has {len(start)} angles, {robot.name} {robot.n} joints")
        bad = np.flatnonzero((start < robot.lower) | (start > robot.upper))
        if len(bad):
            j = int(bad[0])
            raise PathError(
                f"{self.source}: start.joints[{j + 1}] = {np.degrees(start[j]):g} deg is outside the limits "
                f"{np.degrees(robot.lower[j]):g} ... {np.degrees(robot.upper[j]):g} deg of {robot.name}"
            )
        return start

    def _follow(
        self, toolpath: Toolpath, reference: Frame, *, turn: Floats, branch: int, seed: Floats
    ) -> PlannedPath:
        tcp = reference if not turn.any() else about_tool_axis(reference, turn)
        batch = self.inverse.along(toolpath, tcp, branch, seed)
        q = self._choice(toolpath).turns_in_limits(batch.q, batch.ok)
        if not batch.ok.all():
            k = int(np.argmin(batch.ok))
            why = batch.why(k)
            raise PathError(
                f"{place(toolpath, k)}: {self.robot.name} cannot be here in this arm configuration: {why} (TCP "
                f"{mm(toolpath.position[k])} mm in the work object); move [workobject] or choose another [start]"
            )
        self.bounds.check(toolpath, q, "nominal")
        return PlannedPath(toolpath=toolpath, tcp=tcp, q=q, turn=turn, branch=branch)

    def _with_varying_turn(self, toolpath: Toolpath, reference: Frame) -> PlannedPath | None:
        start, inverse = self._checked_start(), self.inverse.inverse
        branches = range(inverse.branches) if start is None else [int(inverse.configuration(start[None])[0])]
        for branch in branches:
            turn = varying_turn(toolpath, partial(self._feasible, toolpath, reference, branch))
            if turn is None:
                continue
            first = about_tool_axis(reference.take(slice(1)), turn[:1])
            for b, seed in self.inverse.postures(toolpath.take([0]), first, limits=True):
                if b != branch:
                    continue
                try:
                    return self._follow(toolpath, reference, turn=turn, branch=branch, seed=seed)
                except PathError:
                    continue
        return None

    def _feasible(self, toolpath: Toolpath, reference: Frame, branch: int, rows: Rows, turns: Floats) -> Floats:
        """(rows, turns) margin of every turn at every pose; -inf where it cannot be reached."""
        out = np.full((len(rows), len(turns)), -np.inf)
        some, at = toolpath.take(rows), reference.take(rows)
        for k, turn in enumerate(turns):
            batch = self.inverse.along(some, about_tool_axis(at, turn), branch, None)
            q = np.where(batch.ok[:, None], batch.q, 0.0)
            room = np.minimum(q - self.robot.lower, self.robot.upper - q).min(axis=1)
            out[:, k] = np.where(batch.ok & (room >= 0), self.bounds.margin(q), -np.inf)
        return out

    def _out_of_reach(self, toolpath: Toolpath, reference: Frame, choice: FirstPostures) -> str:
        """Why: the first pose that no configuration reaches, of up to 500 evenly over the path."""
        for k in np.unique(np.linspace(0, len(toolpath) - 1, 500).astype(int)):
            pose, at = toolpath.take([k]), reference.take(slice(k, k + 1))
            turned = (about_tool_axis(at, turn) for turn in choice.turns(toolpath, reference))
            if not any(self.inverse.postures(pose, tcp, limits=True) for tcp in turned):
                away = np.linalg.norm(reference.origin[k])
                return (
                    f"{place(toolpath, int(k))}: out of reach of {self.robot.name}: TCP "
                    f"{mm(toolpath.position[k])} mm in the work object is {away * 1e3:.0f} mm from the base origin "
                    "and no arm configuration within the joint limits gets there; check [workobject], [tool] and "
                    "their units (mm, deg)"
                )
        return (
            f"{toolpath.source}: every pose can be reached, but {self.robot.name} cannot keep one arm configuration "
            "along the whole path; move [workobject], allow solve.free_tool_axis, or split the file"
        )
