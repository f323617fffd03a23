"""A toolpath as the arm follows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.chosen_axes import ChosenAxes
from compensator.path.chosen_turn import ChosenTurn
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class PlannedPath:
    """A toolpath as the arm follows it, nominal.

    Attributes:
        toolpath: the poses, sampled.
        tcp: (N) TCP in the base.
        q: (N, n) rad, nominal inverse kinematics.
        turn: (N,) rad about the tool axis, from the reference orientation.
        branch: (N,) arm configuration; the same for all poses of a tool.
        programmed: (N,) m/s, the feeds before some were lowered to what the joints can follow, 0 for rapids; None: none
            was.
        instead: the path with the turn that is the next best, should no commands be found for this one; None: none is.
        chosen: how the turn was chosen along the path; None: one turn serves, or the file gives it.
        axes: how external axes were chosen for the path; None: none was.
    """

    toolpath: Toolpath
    tcp: Frame
    q: Floats
    turn: Floats
    branch: npt.NDArray[np.int64]
    programmed: Floats | None = None
    chosen: ChosenTurn | None = None
    instead: PlannedPath | None = None
    axes: ChosenAxes | None = None

    def programmed_at(self, row: Floats) -> Floats | None:
        """``programmed`` (M,) of the moves that end at rows (M,) of the file, of this path with poses put in."""
        if self.programmed is None:
            return None
        return np.asarray(self.programmed[np.minimum(np.searchsorted(self.toolpath.row, row), len(self) - 1)])

    def __len__(self) -> int:
        return len(self.q)

    def take(self, rows: npt.NDArray[np.intp]) -> PlannedPath:
        """The poses of ``rows``, ascending."""
        columns = {name: getattr(self, name)[rows] for name in ("q", "turn", "branch")}
        programmed = None if self.programmed is None else self.programmed[rows]
        return PlannedPath(self.toolpath.take(rows), self.tcp.take(rows), **columns, programmed=programmed)

    def __repr__(self) -> str:
        return f"PlannedPath({len(self)} poses, branch {np.unique(self.branch).tolist()})"
