"""From poses to arm configurations: inverse kinematics along the path, one branch, no jumps.

Where the file leaves the turn about the tool axis open it is chosen: first one turn for the whole path, the
best of a grid; where none serves, a turn that varies along the path, by dynamic programming.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from compensator.cell.cell import Cell
from compensator.errors import PathError
from compensator.path.free_turn import reference_rotation, varying_turn
from compensator.path.motion_bounds import Bounds
from compensator.path.pose_names import mm, place
from stiffness.kinematics.inverse import Inverse
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.robot.robot import Robot
from stiffness.statics.tool import Tool
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

TURNS = 24  # constant turns that are tried, 15 deg apart
FOLLOWED = 24  # first postures that an arm without a closed form is followed from
PROBES = 150  # poses of the path that a candidate is scored on first


@dataclass(frozen=True, repr=False)
class Path:
    """A toolpath as the robot follows it, nominal.

    Attributes:
        toolpath: the poses, sampled.
        rotation, position: (N, 3, 3), (N, 3) of the TCP in the base.
        q: (N, n) rad, nominal inverse kinematics.
        turn: (N,) rad about the tool axis, from the reference orientation.
        branch: arm configuration.
    """

    toolpath: Toolpath
    rotation: Floats
    position: Floats
    q: Floats
    turn: Floats
    branch: int

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"Path({len(self)} poses, branch {self.branch})"


@dataclass(frozen=True)
class _Candidate:
    turn: float
    branch: int
    seed: Floats
    score: float


class Planner:
    """Follows toolpaths with one robot in one cell."""

    def __init__(self, cell: Cell, robot: Robot, inverse: Inverse, tools: dict[int, Tool]) -> None:
        self.cell, self.robot, self.inverse, self.tools = cell, robot, inverse, tools
        self._workobject = cell.workobject.matrix()
        self.bounds = Bounds(cell.solve, robot, inverse)

    def plan(self, toolpath: Toolpath) -> Path:
        """Choose turn and configuration, and follow the whole path.

        Raises:
            PathError: names the pose, its source line, the joint or measure, the value and the bound.
        """
        base, position = self._in_base(toolpath)
        first: PathError | None = None
        for c in self._candidates(toolpath, base, position):
            try:
                return self._follow(toolpath, base, position, np.full(len(toolpath), c.turn), c.branch, c.seed)
            except PathError as e:
                first = first or e
        if self._turn_is_open(toolpath):
            path = self._with_varying_turn(toolpath, base, position)
            if path is not None:
                return path
        if first is None:
            raise PathError(self._out_of_reach(toolpath, base, position))
        raise first

    def again(self, path: Path, toolpath: Toolpath) -> Path:
        """Follow the path again after poses were put in between, with the same choices."""
        base, position = self._in_base(toolpath)
        turn = np.interp(toolpath.row, path.toolpath.row, path.turn)
        return self._follow(toolpath, base, position, turn, path.branch, path.q[0])

    def frames(self, path: Path, toolpath: Toolpath) -> tuple[Floats, Floats]:
        """TCP rotation and position in the base after poses were put into ``path``: same turns."""
        base, position = self._in_base(toolpath)
        return base @ about_z(np.interp(toolpath.row, path.toolpath.row, path.turn)), position

    def part(self, path: Path, toolpath: Toolpath, rows: npt.NDArray[np.intp]) -> Path:
        """Some poses of a path with poses put in between, each near its neighbours in ``path``."""
        rotation, position = self.frames(path, toolpath)
        some, rotation, position = toolpath.take(rows), rotation[rows], position[rows]
        seed = np.array([np.interp(some.row, path.toolpath.row, column) for column in path.q.T]).T
        r, p = self.flange(some, rotation, position)
        batch = self.inverse.along(Frame(r, p), path.branch, seed)
        return Path(some, rotation, position, batch.q, np.zeros(len(rows)), path.branch)

    def _in_base(self, toolpath: Toolpath) -> tuple[Floats, Floats]:
        turn, origin = self._workobject[:3, :3], self._workobject[:3, 3]
        return turn @ reference_rotation(toolpath), toolpath.position @ turn.T + origin

    def _turn_is_open(self, toolpath: Toolpath) -> bool:
        return toolpath.quaternion is None and self.cell.solve.free_tool_axis

    def flange(self, toolpath: Toolpath, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
        """Flange poses under the TCP poses of a path that may change tools."""
        r, p = np.empty_like(rotation), np.empty_like(position)
        for number, tool in self.tools.items():
            rows = slice(None) if len(self.tools) == 1 else np.flatnonzero(toolpath.tool == number)
            r[rows] = rotation[rows] @ tool.rotation.T
            p[rows] = position[rows] - np.einsum("nij,j->ni", r[rows], tool.position)
        return r, p

    def _turns_in_limits(self, q: Floats, ok: npt.NDArray[np.bool_]) -> Floats:
        """Shift whole joints by 2 pi so that the path lies within the limits, as near to [start] as can be."""
        if not ok.any():
            return q
        low, high = q[ok].min(axis=0), q[ok].max(axis=0)
        start = self._start()
        home = 0.5 * (low + high) if start is None else start
        shifted = q.copy()
        for j in range(q.shape[1]):
            options = 2 * np.pi * np.arange(-3, 4)
            fits = (low[j] + options >= self.robot.lower[j]) & (high[j] + options <= self.robot.upper[j])
            if not fits.any():
                continue
            middle = np.abs(0.5 * (low[j] + high[j]) + options - (0.0 if start is None else home[j]))
            shifted[:, j] += options[np.argmin(np.where(fits, middle, np.inf))]
        return shifted

    def _start(self) -> Floats | None:
        if self.cell.start is None:
            return None
        joints = np.radians(self.cell.start.joints)
        if len(joints) != self.robot.n:
            raise PathError(
                f"{self.cell.source}: start.joints has {len(joints)} angles, {self.robot.name} {self.robot.n} joints"
            )
        bad = np.flatnonzero((joints < self.robot.lower) | (joints > self.robot.upper))
        if len(bad):
            j = int(bad[0])
            raise PathError(
                f"{self.cell.source}: start.joints[{j + 1}] = {np.degrees(joints[j]):g} deg is outside the limits "
                f"{np.degrees(self.robot.lower[j]):g} ... {np.degrees(self.robot.upper[j]):g} deg of {self.robot.name}"
            )
        return joints

    def _candidates(self, toolpath: Toolpath, base: Floats, position: Floats) -> list[_Candidate]:
        """Turns and configurations for the whole path, the best first."""
        probe = np.unique(np.linspace(0, len(toolpath) - 1, PROBES).astype(int))
        some = toolpath.take(probe)
        start = self._start()
        found = []
        for turn, branch, q in self._first_postures(some, base[probe], position[probe], start):
            r, p = self.flange(some, base[probe] @ about_z(turn), position[probe])
            batch = self.inverse.along(Frame(r, p), branch, q)
            if batch.ok.all():
                joints = self._turns_in_limits(batch.q, batch.ok)
                score = self.bounds.margin(joints).min() if self._labelled or start is None else -_apart(q, start)
                found.append(_Candidate(turn, branch, q, float(score)))
        return [c for c in sorted(found, key=lambda c: -c.score)[:6]]

    def _first_postures(
        self, some: Toolpath, base: Floats, position: Floats, start: Floats | None
    ) -> list[tuple[float, int, Floats]]:
        """(turn, branch, joint angles) at the first pose; of arms that are followed pose by pose the roomiest only."""
        out: list[tuple[float, int, Floats]] = []
        for turn in self._turns(some, base):
            r, p = self.flange(some.take([0]), base[:1] @ about_z(turn), position[:1])
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = r[0], p[0]
            seen: dict[int, Floats] = {}
            for branch, q in self._allowed(pose, start):
                seen.setdefault(branch, q)
            out += [(float(turn), branch, q) for branch, q in seen.items()]
        if self._labelled or start is not None or len(out) <= FOLLOWED:
            return out
        room = self.bounds.margin(np.array([q for _, _, q in out]))
        return [out[k] for k in np.argsort(-room, kind="stable")[:FOLLOWED]]

    @property
    def _labelled(self) -> bool:
        """Whether a branch is the same arm configuration at every pose; the others are counted pose by pose."""
        return isinstance(self.inverse, SphericalInverse)

    def _allowed(self, pose: Floats, start: Floats | None) -> list[tuple[int, Floats]]:
        """Postures of the first pose, the nearest first; [start] picks the arm configuration."""
        near = np.zeros(self.robot.n) if start is None else start
        found = sorted(self.inverse.all(pose, limits=False), key=lambda s: _apart(s[1], near))
        if start is None:
            return found
        if not self._labelled:
            return found[:1]
        wanted = int(self.inverse.configuration(start[None])[0])
        return [s for s in found if s[0] == wanted]

    def _turns(self, toolpath: Toolpath, base: Floats) -> Floats:
        if self._turn_is_open(toolpath):
            return np.linspace(0, 2 * np.pi, TURNS, endpoint=False)
        start = self._start()
        if toolpath.quaternion is not None or start is None:
            return np.zeros(1)
        # fixed, but left open by the file: the turn that is nearest to how the tool stands at [start]
        flange = self.robot.pose(start)[:3, :3]
        tool = self.tools[int(toolpath.tool[0])] if len(self.tools) > 1 else next(iter(self.tools.values()))
        relative = base[0].T @ flange @ tool.rotation
        return np.array([np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1])])

    def _follow(
        self, toolpath: Toolpath, base: Floats, position: Floats, turn: Floats, branch: int, seed: Floats
    ) -> Path:
        rotation = base if not turn.any() else base @ about_z(turn)
        r, p = self.flange(toolpath, rotation, position)
        batch = self.inverse.along(Frame(r, p), branch, seed)
        q = self._turns_in_limits(batch.q, batch.ok)
        if not batch.ok.all():
            k = int(np.argmin(batch.ok))
            why = batch.why(k)
            raise PathError(
                f"{place(toolpath, k)}: {self.robot.name} cannot be here in this arm configuration: {why} (TCP "
                f"{mm(toolpath.position[k])} mm in the work object); move [workobject] or choose another [start]"
            )
        self.bounds.check(toolpath, q, "nominal")
        return Path(toolpath, rotation, position, q, turn, branch)

    def _with_varying_turn(self, toolpath: Toolpath, base: Floats, position: Floats) -> Path | None:
        start = self._start()
        branches = range(self.inverse.branches) if start is None else [int(self.inverse.configuration(start[None])[0])]
        for branch in branches:
            turn = varying_turn(toolpath, partial(self._feasible, toolpath, base, position, branch))
            if turn is None:
                continue
            rotation = base[:1] @ about_z(turn[:1])
            r, p = self.flange(toolpath.take([0]), rotation, position[:1])
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = r[0], p[0]
            for b, seed in self.inverse.all(pose, limits=True):
                if b != branch:
                    continue
                try:
                    return self._follow(toolpath, base, position, turn, branch, seed)
                except PathError:
                    continue
        return None

    def _feasible(
        self, toolpath: Toolpath, base: Floats, position: Floats, branch: int, rows: npt.NDArray[np.intp], turns: Floats
    ) -> Floats:
        """(rows, turns) margin of every turn at every pose; -inf where it cannot be reached."""
        out = np.full((len(rows), len(turns)), -np.inf)
        some = toolpath.take(rows)
        for k, turn in enumerate(turns):
            r, p = self.flange(some, base[rows] @ about_z(turn), position[rows])
            batch = self.inverse.along(Frame(r, p), branch, None)
            q = np.where(batch.ok[:, None], batch.q, 0.0)
            room = np.minimum(q - self.robot.lower, self.robot.upper - q).min(axis=1)
            out[:, k] = np.where(batch.ok & (room >= 0), self.bounds.margin(q), -np.inf)
        return out

    def _out_of_reach(self, toolpath: Toolpath, base: Floats, position: Floats) -> str:
        """The first pose that no configuration reaches, by bisection over single poses."""
        for k in np.unique(np.linspace(0, len(toolpath) - 1, 500).astype(int)):
            reached = False
            for turn in self._turns(toolpath, base):
                r, p = self.flange(toolpath.take([k]), base[k : k + 1] @ about_z(turn), position[k : k + 1])
                pose = np.eye(4)
                pose[:3, :3], pose[:3, 3] = r[0], p[0]
                if self.inverse.all(pose, limits=True):
                    reached = True
                    break
            if not reached:
                away = np.linalg.norm(position[k])
                return (
                    f"{place(toolpath, int(k))}: out of reach of {self.robot.name}: TCP "
                    f"{mm(toolpath.position[k])} mm in the work object is {away * 1e3:.0f} mm from the base origin "
                    "and no arm configuration within the joint "
                    "limits gets there; check [workobject], [tool] and their units (mm, deg)"
                )
        return (
            f"{toolpath.source}: every pose can be reached, but {self.robot.name} cannot keep one arm configuration "
            "along "
            "the whole path; move [workobject], allow solve.free_tool_axis, or split the file"
        )


def _apart(q: Floats, start: Floats) -> float:
    """Sum of the angles between two postures, rad; whole turns do not count."""
    return float(np.abs((q - start + np.pi) % (2 * np.pi) - np.pi).sum())


def about_z(angle: float | Floats) -> Floats:
    """Rotation(s) about z: (3, 3), or (N, 3, 3) for an array."""
    c, s = np.cos(angle), np.sin(angle)
    zero, one = np.zeros_like(c), np.ones_like(c)
    return np.stack([np.stack([c, -s, zero], -1), np.stack([s, c, zero], -1), np.stack([zero, zero, one], -1)], -2)
