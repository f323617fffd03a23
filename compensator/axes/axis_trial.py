"""Axis trial: a path with its axes at chosen places, as it would be run, and what that costs."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from compensator.axes.axis_contacts import touching
from compensator.axes.axis_cost import AxisCost, places_of
from compensator.axes.axis_curve import CurveBasis
from compensator.axes.axis_lattice import PathStages
from compensator.axes.axis_search import AxisStart
from compensator.axes.cheapest_way import CoarseWay
from compensator.axes.free_axes import FreeAxes
from compensator.cell.job import Job
from compensator.errors import PathError
from compensator.path.chosen_turn import TurnValue
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import place
from compensator.scene.clearance import clearance
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
TurnAlong = tuple[Floats, Ints]  # (N,) rad and arm configurations (N,)


@dataclass(frozen=True, repr=False, eq=False)
class FollowedAxes:
    """A path with its axes, as it is followed, and what that costs.

    Attributes:
        places: (N, A). coefficients: (M, A) of the curves; None: the axes stay.
        windows: of the refinement that made it, and those that failed.
    """

    path: PlannedPath
    places: Floats
    value: TurnValue
    cost: AxisCost
    coefficients: Floats | None = None
    windows: tuple[int, int] = (0, 0)


@dataclass(eq=False)
class AxisTrial:
    """Paths as they would be run; ``refused``: why the first was not, empty where none was.

    Attributes:
        toolpath: axes at 0. wrench: (N, 6) of the process, tables where ``stages`` have them.
    """

    job: Job
    free: FreeAxes
    toolpath: Toolpath
    stages: PathStages
    wrench: Floats
    refused: str = ""
    time: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.time = self.free.time(self.toolpath)

    def fixed(self, start: AxisStart) -> FollowedAxes | None:
        """Axes that stay where a start begins; None: the arm cannot follow."""
        places = np.broadcast_to(start.places[0], (len(self.toolpath), len(self.free)))
        return self._followed(places, self.turn(start), None)

    def beside(self, one: FollowedAxes, way: Floats) -> FollowedAxes | None:
        """Fixed places ``way`` (A,) from others, with their turn; None: the arm cannot follow."""
        places = np.clip(one.places[0] + way, self.free.low, self.free.high)
        return self._followed(np.broadcast_to(places, one.places.shape), (one.path.turn, one.path.branch), None)

    def stopped(self, moving: FollowedAxes) -> FollowedAxes | None:
        """A way at the place in its middle, for the whole path, with its turn; None: the arm cannot follow."""
        places = np.broadcast_to(np.median(moving.places, axis=0), moving.places.shape)
        return self._followed(places, (moving.path.turn, moving.path.branch), None)

    def turn(self, start: AxisStart) -> TurnAlong:
        """(N,) rad and configurations (N,) of a start."""
        count = len(self.toolpath)
        turn = np.interp(np.arange(count), self.stages.rows, start.turn)
        return turn, np.full(count, start.branch, dtype=np.int64)

    def turn_along(self, basis: CurveBasis, coefficients: Floats, way: CoarseWay) -> TurnAlong:
        """(N,) rad and configurations (N,) of a way over the lattice that became curves: where a table turns, turns are
        counted from where the path's own are."""
        path = self.free.on(self.toolpath, self._places(basis, coefficients))
        turn, branch = self.turn(AxisStart.of(way))
        off = np.interp(np.arange(len(turn)), self.stages.rows, self.stages.held_on(path, way.places))
        if self.job.placement.solve.turn == "constant":
            off = np.full(len(turn), float(np.median(off)))
        return turn - off, branch

    def _places(self, basis: CurveBasis, coefficients: Floats) -> Floats:
        """(N, A) along curves."""
        return np.asarray(np.clip(basis.at(self.time) @ coefficients, self.free.low, self.free.high))

    def moving(
        self, basis: CurveBasis, coefficients: Floats, turn: TurnAlong, windows: tuple[int, int] = (0, 0)
    ) -> FollowedAxes | None:
        """Axes along curves; None: the arm cannot follow."""
        places = self._places(basis, coefficients)
        found = self._followed(places, turn, (basis, coefficients))
        return None if found is None else replace(found, windows=windows)

    def _followed(
        self, places: Floats, turn: TurnAlong, curve: tuple[CurveBasis, Floats] | None
    ) -> FollowedAxes | None:
        try:
            path = self._path(self.free.on(self.toolpath, places), *turn)
        except PathError as e:
            self.refused = self.refused or str(e)
            return None
        if not self._clear(path):
            self.refused = self.refused or self._contact(path)
            return None
        wrench = self.stages.wrench_along(places, self.wrench)
        cost = AxisCost.of(self.job, self.free, path, wrench=wrench, tools=self.stages.tools)
        bends = None if curve is None else curve[0].at(self.time[cost.rows], 2) @ curve[1]
        at = places_of(self.free, path)
        value = cost.value(at[cost.rows], bends)
        return FollowedAxes(path, at, value, cost, coefficients=None if curve is None else curve[1])

    def _path(self, toolpath: Toolpath, turn: Floats, branch: Ints) -> PlannedPath:
        """At these turns, or as the planner would choose them.

        Raises:
            PathError: neither can be followed.
        """
        planner = self.job.planner
        if self.stages.turns > 1:
            q, tcp = np.zeros((len(turn), self.job.arm.robot.n)), planner.reference(toolpath)
            with suppress(PathError):
                return planner.turned(PlannedPath(toolpath=toolpath, tcp=tcp, q=q, turn=turn, branch=branch), turn)
        return planner.plan(toolpath)

    def _contact(self, path: PlannedPath) -> str:
        """What touches first on a path that is not clear, and where."""
        rows = self.stages.rows
        found = touching(self.stages, path.toolpath.take(rows), path.q[rows])
        if found is None:
            return "something touches on the way"
        return f"{place(self.toolpath, int(rows[found[0]]))}: {found[1]} touch"

    def _clear(self, path: PlannedPath) -> bool:
        if self.stages.collider is None:
            return True
        free = clearance(self.job, path.toolpath, collider=self.stages.collider)
        rows = self.stages.rows
        return bool(free(rows, path.q[rows][:, None]).all())
