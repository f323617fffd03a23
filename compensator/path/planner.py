"""From poses to arm configurations: inverse kinematics along the path, one branch for each tool, no jumps.

Where the file leaves the turn about the tool axis open it is chosen: first one turn for the whole path, the
best of a grid; where none serves, a turn that varies along the path, by dynamic programming.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.errors import PathError
from compensator.path.first_postures import FirstPostures
from compensator.path.free_turn import about_tool_axis, reference_rotations, varying_turn
from compensator.path.motion_bounds import MotionBounds
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import mm, place
from compensator.path.tcp_inverse import TcpInverse
from toolpaths.columns import once
from toolpaths.frame import Frame
from toolpaths.made_frames import MadeFrames
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

PROBES = 500  # poses of a path that are tried where it has to be said which the arm does not reach


class _Section(NamedTuple):
    """The poses of one tool; their (N) TCP in the base, before they are turned about it; the number of the first."""

    toolpath: Toolpath
    reference: Frame
    first: int


def _joined(toolpath: Toolpath, parts: list[PlannedPath]) -> PlannedPath:
    """The path of all tools."""
    if len(parts) == 1:
        return parts[0]
    q, turn, branch = (np.concatenate([getattr(p, name) for p in parts]) for name in ("q", "turn", "branch"))
    return PlannedPath(toolpath=toolpath, tcp=MadeFrames.joined([p.tcp for p in parts]), q=q, turn=turn, branch=branch)


class Planner:
    """Follows toolpaths with one arm at one placement.

    Args:
        inverse, bounds: of the arm with its tools.
        workobject: in the base.
        start: (n,) rad where the arm comes from; None: not known.
        free_tool_axis: the turn about the tool axis may be chosen where the toolpath leaves it open.
        source: the file that gives these, for messages.
        one_turn: where no constant turn serves the path is refused.
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
        one_turn: bool = False,
    ) -> None:
        self.inverse, self.bounds, self.robot = inverse, bounds, inverse.robot
        self.workobject, self.start = workobject, start
        self.free_tool_axis, self.source, self.one_turn = free_tool_axis, source, one_turn

    def __repr__(self) -> str:
        return f"Planner({self.robot.name}, {self.source!r})"

    def plan(self, toolpath: Toolpath) -> PlannedPath:
        """Choose turn and configuration for the poses of each tool, and follow them.

        A joint move leads to the first pose of a tool: there all angles may change.

        Raises:
            PathError: names the pose, its source line, the joint or measure, the value and the bound.
        """
        start = self._checked_start()
        parts: list[PlannedPath] = []
        for begin, end in self._sections(toolpath):
            some = toolpath if end - begin == len(toolpath) else toolpath.take(np.arange(begin, end))
            section = _Section(some, self.reference(some), begin)
            if parts:
                parts.append(self._after(section, parts[-1].q[-1]))
            else:
                parts.append(self._planned(section, start))
        return _joined(toolpath, parts)

    def again(self, path: PlannedPath, toolpath: Toolpath) -> PlannedPath:
        """Follow the path again after poses were put in between, with the same choices."""
        turn = np.interp(toolpath.row, path.toolpath.row, path.turn)
        old = [begin for begin, _ in self._sections(path.toolpath)]
        parts = []
        for k, (begin, end) in zip(old, self._sections(toolpath), strict=True):
            some = toolpath if end - begin == len(toolpath) else toolpath.take(np.arange(begin, end))
            section = _Section(some, self.reference(some), begin)
            parts.append(self._follow(section, turn=turn[begin:end], branch=int(path.branch[k]), seed=path.q[k]))
        whole, programmed = _joined(toolpath, parts), path.programmed_at(toolpath.row)
        return replace(whole, programmed=programmed, chosen=path.chosen, axes=path.axes)

    def turned(self, path: PlannedPath, turn: Floats) -> PlannedPath:
        """Follow the path with other turns (N,) rad about the tool axis, in the same configuration.

        Raises:
            PathError: the arm cannot; names the pose.
        """
        toolpath, parts = path.toolpath, list[PlannedPath]()
        for begin, end in self._sections(toolpath):
            some = toolpath if end - begin == len(toolpath) else toolpath.take(np.arange(begin, end))
            section = _Section(some, self.reference(some), begin)
            choice = self._choice(some, parts[-1].q[-1] if parts else self.start)
            branch, seed = int(path.branch[begin]), path.q[begin]
            parts.append(self._follow(section, turn=turn[begin:end], branch=branch, seed=seed, choice=choice))
        return replace(_joined(toolpath, parts), programmed=path.programmed)

    def check(self, toolpath: Toolpath, q: Floats, what: str) -> None:
        """As ``MotionBounds.check``; a joint move leads to the first pose of every tool."""
        self.bounds.check(toolpath, q, what, begun=self.inverse.tools.changes(toolpath))

    def tcp(self, path: PlannedPath, toolpath: Toolpath) -> Frame:
        """(N) TCP in the base after poses were put into ``path``: same turns."""
        turn = np.interp(toolpath.row, path.toolpath.row, path.turn)
        return about_tool_axis(self.reference(toolpath), turn)

    def part(self, path: PlannedPath, some: Toolpath, tcp: Frame) -> PlannedPath:
        """Poses (K) that lie between those of ``path``, each near its neighbours there; ``tcp`` (K) in the base."""
        seed = np.array([np.interp(some.row, path.toolpath.row, column) for column in path.q.T]).T
        branch = path.branch[np.minimum(np.searchsorted(path.toolpath.row, some.row), len(path) - 1)]
        batch = self.inverse.along(some, tcp, branch, seed)
        return PlannedPath(toolpath=some, tcp=tcp, q=batch.q, turn=np.zeros(len(some)), branch=branch)

    def _sections(self, toolpath: Toolpath) -> list[tuple[int, int]]:
        """Begin and end of the poses of each tool, in their order."""
        changes = self.inverse.tools.changes(toolpath)
        return list(zip([0, *changes], [*changes, len(toolpath)], strict=True))

    def _after(self, section: _Section, before: Floats) -> PlannedPath:
        """The poses of a tool in the configuration that the arm has ``before`` them, or in another one."""
        try:
            return self._planned(section, before)
        except PathError:
            return self._planned(section, None)

    def _planned(self, section: _Section, start: Floats | None) -> PlannedPath:
        """Choose turn and configuration for the whole section, and follow it."""
        choice = self._choice(section.toolpath, start)
        if not self.inverse.labelled:  # without a closed form the search for a way takes minutes where there is none
            self._refuse_out_of_reach(section, choice)
        first: PathError | None = None
        for c in choice.for_path(section.toolpath, section.reference):
            try:
                turn = np.broadcast_to(np.float64(c.turn), len(section.toolpath))
                return self._follow(section, turn=turn, branch=c.branch, seed=c.seed, choice=choice)
            except PathError as e:
                first = first or e
        path = self._with_varying_turn(section, choice) if choice.turn_is_open else None
        if path is not None and not self.one_turn:
            return path
        if path is not None:
            raise PathError(
                f'{self.source}: solve.turn = "constant": no turn about the tool axis serves the whole path, but one '
                f'that changes along it does: set turn = "path"' + (f"; with a constant one, {first}" if first else "")
            )
        if first is None:
            self._refuse_out_of_reach(section, choice)
            raise PathError(
                f"{section.toolpath.source}: every pose can be reached, but {self.robot.name} cannot keep one arm "
                "configuration along the whole path; move [workobject], allow solve.free_tool_axis, or split the file"
            )
        raise first

    def reference(self, toolpath: Toolpath) -> Frame:
        """(N) TCP in the base, before it is turned about the tool axis."""
        work, position, rotations = self.workobject, toolpath.position, reference_rotations(toolpath)
        return MadeFrames(
            len(toolpath), lambda rows: work.then(Frame(rotations(rows), position[rows])), lambda: work.at(position)
        )

    def _choice(self, toolpath: Toolpath, start: Floats | None) -> FirstPostures:
        turn_is_open = toolpath.quaternion is None and self.free_tool_axis
        return FirstPostures(self.inverse, self.bounds, start, turn_is_open)

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
        self, section: _Section, *, turn: Floats, branch: int, seed: Floats, choice: FirstPostures | None = None
    ) -> PlannedPath:
        """Follow it from ``seed``; ``choice``: whole joints may turn by 2 pi to stay within the limits."""
        (toolpath, reference, first), turn = section, once(turn)
        tcp = reference if not turn.any() else about_tool_axis(reference, turn)
        batch = self.inverse.along(toolpath, tcp, branch, seed)
        q = choice.turns_in_limits(batch.q, batch.ok) if choice else batch.q
        if not batch.ok.all():
            k = int(np.argmin(batch.ok))
            why = batch.why(k)
            raise PathError(
                f"{place(toolpath, k, first)}: {self.robot.name} cannot be here in this arm configuration: {why} (TCP "
                f"{mm(toolpath.position[k])} mm in the work object); move [workobject] or choose another [start]"
            )
        del batch  # its margins: as much as the angles
        self.bounds.check(toolpath, q, "nominal", first=first)
        branches = np.broadcast_to(np.int64(branch), len(toolpath))
        return PlannedPath(toolpath=toolpath, tcp=tcp, q=q, turn=turn, branch=branches)

    def _with_varying_turn(self, section: _Section, choice: FirstPostures) -> PlannedPath | None:
        toolpath, reference, _ = section
        inverse, start = self.inverse.inverse, choice.start
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
                    return self._follow(section, turn=turn, branch=branch, seed=seed, choice=choice)
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

    def _refuse_out_of_reach(self, section: _Section, choice: FirstPostures) -> None:
        """Refuse the first pose that no configuration reaches at any turn: of PROBES evenly over the path, and then of
        those before it.

        Raises:
            PathError: names the pose.
        """
        toolpath, reference, first = section
        rows = np.unique(np.linspace(0, len(toolpath) - 1, PROBES).astype(np.intp))
        turns = choice.turns(toolpath, reference)
        doubtful = self._unreached(section, rows, turns, thorough=False)
        beyond = next((k for k in doubtful if self._is_beyond(section, k, turns)), None)
        if beyond is None:
            return
        before = rows[rows < beyond]
        low, high = (int(before[-1]) if len(before) else beyond), beyond
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if self._is_beyond(section, middle, turns) else (middle, high)
        away = np.linalg.norm(reference.origin[high])
        raise PathError(
            f"{place(toolpath, high, first)}: out of reach of {self.robot.name}: TCP "
            f"{mm(toolpath.position[high])} mm in the work object is {away * 1e3:.0f} mm from the base origin "
            "and no arm configuration within the joint limits gets there; check [workobject], [tool] and "
            "their units (mm, deg)"
        )

    def _is_beyond(self, section: _Section, pose: int, turns: Floats) -> bool:
        return len(self._unreached(section, np.array([pose]), turns, thorough=True)) > 0

    def _unreached(self, section: _Section, rows: Rows, turns: Floats, *, thorough: bool) -> list[int]:
        """Those of the poses ``rows`` that the flange reaches at none of the turns."""
        left = rows
        for turn in turns:
            if not len(left):
                break
            tcp = about_tool_axis(section.reference.take(left), float(turn))
            left = left[~self.inverse.reached(section.toolpath.take(left), tcp, thorough=thorough)]
        return [int(k) for k in left]
