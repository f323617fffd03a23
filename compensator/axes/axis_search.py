"""Axis search: the lattices of a path, the fixed places that are worth following, and the cheapest way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.axes.axis_contacts import contacts_in_the_way
from compensator.axes.axis_lattice import AxisLattice, PathStages
from compensator.axes.cheapest_way import SHARE, CoarseWay, cheapest_way
from compensator.axes.free_axes import FreeAxes
from compensator.cell.job import Job
from compensator.errors import PathError
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import mm, place
from compensator.scene.path_collisions import collider_of
from compensator.turn.reliance import tool_reliances
from compensator.turn.turn_choice import key_motion
from compensator.turn.turn_grid import TurnGrid
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]

CELLS = {1: 41, 2: 13}  # places of each axis, by their number
TURNING, MOST = 7.5, {1: 97, 2: 25}  # deg from place to place of a table that may turn, and its places at most
STAGES = {1: 300, 2: 120}  # poses at most
SPACING = 0.05  # m of path between stages, as long as there are few
FEWEST = 8  # stages
BEST = 8  # fixed places that are followed
CLOSER = 5  # places about each of the best, along each axis
FINER = 2  # of the best that are looked about


@dataclass(frozen=True, eq=False)
class AxisStart:
    """Places (S, A) and turns (S,) rad at the stages, in one arm configuration."""

    places: Floats
    turn: Floats
    branch: int

    @classmethod
    def of(cls, way: CoarseWay) -> AxisStart:
        """Of a way over a lattice."""
        return cls(way.places, way.turn, way.branch)


@dataclass(frozen=True, repr=False, eq=False)
class AxisSearch:
    """What there is to choose from.

    Attributes:
        shape: of the grid of places, over the axes.
        lattices: of arm configurations in which every stage can be reached from somewhere.
        reached: (S,) whether anything reaches a stage.
        grids: arm configuration -> postures at each place of the grid, where contacts are looked at.
        wrench: (N, 6) of the whole path, tables where ``stages`` have them.
    """

    stages: PathStages
    shape: tuple[int, ...]
    lattices: tuple[AxisLattice, ...]
    reached: Bools
    wrench: Floats
    grids: Mapping[int, list[TurnGrid]]

    def fixed_places(self) -> list[AxisStart]:
        """Of places that stay for the whole path the best ones, which lie apart, and better ones beside them."""
        scored = [(float(row.min()), k, one) for one in self.lattices for k, row in enumerate(one.constant())]
        scored = sorted((s for s in scored if np.isfinite(s[0])), key=lambda s: s[:2])
        if not scored and not self._one_turn:
            ways = [w for one in self.lattices if (w := cheapest_way(one, self.shape, one_turn=False, still=True))]
            return [AxisStart.of(min(ways, key=lambda w: w.price))] if ways else []
        picked: list[tuple[float, int, AxisLattice]] = []
        cell = self.cell
        for score in scored:
            at = score[2].places[score[1]]
            if len(picked) < BEST and all(np.any(np.abs(at - o.places[k]) > 1.5 * cell) for _, k, o in picked):
                picked.append(score)
        closer = [self._closer(one.places[k], one.branch) for _, k, one in picked[:FINER]]
        return [*(c for c in closer if c is not None), *(self._best(one, k) for _, k, one in picked)]

    def way(self) -> CoarseWay | None:
        """The cheapest way of what may move over the lattices, at one turn where that serves."""
        for one_turn in (True, False)[: 1 if self._one_turn else 2]:
            found = [w for one in self.lattices if (w := cheapest_way(one, self.shape, one_turn=one_turn))]
            if found:
                return min(found, key=lambda w: w.price)
        return None

    def refusal(self, first: str) -> str:
        """Why nothing serves, with the pose, and what to do; ``first``: why a path could not be followed."""
        stages, free = self.stages, self.stages.free
        spans = ", ".join(f"{n} = {a:g} ... {b:g}" for n, a, b in zip(free.names, free.low, free.high, strict=True))
        robot, contacts = stages.job.arm.robot.name, self._contacts()
        if not self.reached.all():
            k = int(np.argmin(self.reached))
            return (
                f"{place(stages.toolpath, int(stages.rows[k]))}: out of reach of {robot} wherever {spans} stand (TCP "
                f"{mm(stages.some.position[k])} mm in the work object), or a limit or a contact is in the way at every "
                f"turn{contacts}: widen range, or check [workobject], direction and center"
            )
        what = f"{stages.toolpath.source}: every pose can be reached from somewhere with {spans}, but no fixed place"
        moving = [n for n, moves in zip(free.names, free.moving, strict=True) if moves]
        moved = f" and no smooth way of {', '.join(moving)} within speed and acceleration" if moving else ""
        told = f"{f' ({first})' if first else ''}{contacts}"
        kind = "rail" if free.rail.any() else "table"
        still = "widen range, give speed and acceleration of a table that the controller coordinates"
        remedy = f"widen range, give speed and acceleration of the {kind}, or lower the feed" if moving else still
        remedy = "; ".join([*free.doubts(), remedy])
        return f"{what}{moved} serves the whole path in one arm configuration{told}; {remedy}, or split the file"

    def _contacts(self) -> str:
        """What touches where the path could be followed otherwise; empty: that closes nothing."""
        free = self.stages.free
        lines = [np.linspace(a, b, n) for a, b, n in zip(free.low, free.high, self.shape, strict=True)]
        return contacts_in_the_way(self.stages, self.shape, _product(lines), self.grids, one_turn=self._one_turn)

    @property
    def _one_turn(self) -> bool:
        return self.stages.job.placement.solve.turn == "constant" or self.stages.turns == 1

    @property
    def cell(self) -> Floats:
        """(A,) from place to place."""
        free = self.stages.free
        return np.asarray((free.high - free.low) / (np.array(self.shape) - 1))

    def _best(self, lattice: AxisLattice, k: int) -> AxisStart:
        """A place at the turn that costs least there."""
        column = int(np.argmin(lattice.constant()[k]))
        turn = np.full(len(self.stages.rows), column * 2 * np.pi / self.stages.turns)
        return AxisStart(np.tile(lattice.places[k], (len(turn), 1)), turn, lattice.branch)

    def _closer(self, places: Floats, branch: int) -> AxisStart | None:
        """The best of some places less than a cell away."""
        free, cell = self.stages.free, self.cell
        lines = [np.linspace(-cell[a], cell[a], CLOSER + 2)[1:-1] + places[a] for a in range(len(free))]
        near = np.clip(_product(lines), free.low, free.high)
        lattice = _lattice(self.stages, near, branch)
        score = lattice.constant().min(axis=1)
        return self._best(lattice, int(np.argmin(score))) if np.isfinite(score).any() else None


def axis_search(
    job: Job, free: FreeAxes, toolpath: Toolpath, wrench: Callable[[PlannedPath], Floats]
) -> AxisSearch:
    """The lattices of a path; ``wrench`` of a path, (N, 6).

    Raises:
        PathError: the arm has no closed form.
    """
    if not job.planner.inverse.labelled:
        raise PathError(
            f"{job.placement.source}: external.{free.names[0]}.free: places are looked at in closed form, which "
            f"needs a spherical wrist (axes 4, 5, 6 through one point); {job.arm.robot.name} has none: take free away"
        )
    stages, whole = _stages(job, free, toolpath, wrench)
    shape = _shape(free)
    places = _product([np.linspace(a, b, n) for a, b, n in zip(free.low, free.high, shape, strict=True)])
    start, form = job.planner.start, job.planner.inverse.inverse
    branches = range(form.branches) if start is None else [int(form.configuration(start[None])[0])]
    references = stages.references(places)
    kept = dict[int, list[TurnGrid]]()
    lattices, reached = [], np.zeros(len(stages.rows), dtype=np.bool_)
    for branch in branches:
        grids = stages.grids(places, references, branch)
        if stages.collider is not None:
            kept[branch] = grids
        here = np.any([grid.free.any(axis=1) for grid in grids], axis=0)
        reached |= here
        if here.all():
            lattices.append(AxisLattice.of(stages, places, grids, references=references, branch=branch))
    return AxisSearch(stages, shape, lattices=tuple(lattices), reached=reached, wrench=whole, grids=kept)


def _lattice(stages: PathStages, places: Floats, branch: int) -> AxisLattice:
    references = stages.references(places)
    grids = stages.grids(places, references, branch)
    return AxisLattice.of(stages, places, grids, references=references, branch=branch)


def _stages(
    job: Job, free: FreeAxes, toolpath: Toolpath, wrench: Callable[[PlannedPath], Floats]
) -> tuple[PathStages, Floats]:
    """Where it is decided, evenly along the path, and the wrench of the whole path."""
    middle = (free.low + free.high) / 2
    path = free.on(toolpath, middle)
    rows = _stage_rows(free, path)
    none = np.zeros(len(path), dtype=np.int64)
    q = np.zeros((len(path), job.arm.robot.n))
    begun = PlannedPath(toolpath=path, tcp=job.planner.reference(path), q=q, turn=np.zeros(len(path)), branch=none)
    whole = wrench(begun)
    motion, _, allowed = key_motion(job, begun, rows)
    turning = bool((free.moving & ~free.rail).any())
    around = bool(job.placement.surroundings.scene)
    collider = collider_of(job, on_rail=bool(free.rail.any()), on_table=turning) if around else None
    stages = PathStages(
        job=job, free=free, toolpath=toolpath, rows=rows, some=toolpath.take(rows), wrench=whole[rows], motion=motion,
        allowed=allowed, time=free.time(toolpath)[rows], collider=collider, turned_at=middle,
        tools=tool_reliances(job.arm),
    )  # fmt: skip
    return stages, whole


def _stage_rows(free: FreeAxes, path: Toolpath) -> Rows:
    """(S,) poses, evenly in time, so far apart that every axis can go a cell between two of them."""
    length, time = float(np.linalg.norm(np.diff(path.on_part, axis=0), axis=1).sum()), free.time(path)
    cells = ((free.high - free.low) / (np.array(_shape(free)) - 1))[free.moving]
    needed = float(np.max(1.01 * cells / (SHARE * free.speed[free.moving]), initial=0.0))
    most = min(length / SPACING, STAGES[len(free)], time[-1] / needed if needed else np.inf)
    rows = np.searchsorted(time, np.linspace(0.0, time[-1], int(max(most, FEWEST)) + 1))
    return np.unique(np.append(np.clip(rows, 0, len(path) - 1), [0, len(path) - 1]))


def _shape(free: FreeAxes) -> tuple[int, ...]:
    """(A,) how many places there are of each axis; a table that may turn has a wide range, and goes slowly over it."""
    few = CELLS[len(free)]
    wide = np.clip((free.high - free.low) / TURNING, few, MOST[len(free)])
    return tuple(int(n) for n in np.where(free.moving & ~free.rail, wide, few))


def _product(lines: list[Floats]) -> Floats:
    """(P, A) of all combinations, the last axis fastest."""
    return np.stack([g.ravel() for g in np.meshgrid(*lines, indexing="ij")], axis=1)
