"""Path history: the walk along a commanded path, and the joint memory that it leaves at every reading of a trace.

The memory of a joint depends on the torque at every row of the path, and readings were taken at some of them only. The
torque of a rigid arm is known at all rows; what the readings add to it (deflection, springs, masses that the arm has
and its file has not) is small and smooth, and is interpolated between them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers
from stiffness.identification.load_history import memory_slopes, opened
from stiffness.memory.preload import unknown, walk
from stiffness.numerics.kernel import Kernel
from stiffness.session.path_trace import FAR, CommandedRows, PathTrace, first_signs
from stiffness.session.session import Session
from stiffness.statics.load import Load
from stiffness.statics.statics import Statics

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

MOST_ROWS = 20_000  # rows that are walked beside those of readings, reversals, and ends of cuts


class PathHistory:
    """One walk for all runs of a trace: every run begins with the same long move to the first row."""

    def __init__(self, session: Session, path: PathTrace) -> None:
        self._n, rows = session.robot.n, path.rows
        read, self._of = np.unique(path.index, return_inverse=True)
        grid = np.unique(np.concatenate([walked_rows(rows).astype(float), read]))
        self._at, self._grid, self._read = np.searchsorted(grid, read), grid, read
        q = rows.at(rows.q, grid)
        move = np.diff(q, axis=0, prepend=q[:1])
        self._moves = np.concatenate([FAR * first_signs(rows)[None], move])
        self._rigid = rigid_torque(session, q, rows.at(rows.wrench, grid))

    def __repr__(self) -> str:
        return f"PathHistory({len(self._grid)} rows, {len(self._read)} of them read)"

    def state(
        self, effects: Sequence[Effect], values: Mapping[str, Numbers], torque: Floats, resting: Floats
    ) -> Floats:
        """(N, m) memory of every reading as a share of its half range, -1 ... 1.

        Args:
            torque: (N, n) N*m of every reading. resting: not needed, a path has torques of its own.
        """
        values = {e.name: opened(e, values[e.name]) for e in effects}
        begin = unknown(effects, values)
        if not len(begin.low):
            return np.zeros((len(self._of), 0))
        along = self._along(torque)
        walked = walk(
            effects=effects,
            values=values,
            move=self._moves,
            torque=np.concatenate([along[:1], along]),
            start=begin,
        ).middle[1:]
        return np.asarray((walked / begin.high)[self._at][self._of])

    def slopes(
        self,
        effects: Sequence[Effect],
        values: Mapping[str, Numbers],
        torque: Floats,
        resting: Floats,
        state: Floats,
        only: Collection[tuple[str, str]] | None = None,
    ) -> dict[tuple[str, str], Floats]:
        """How shares (N, n * states) change with the numbers of what remembers; see ``LoadHistory.slopes``."""
        return memory_slopes(
            lambda other: self.state(effects, other, torque, resting),
            effects=effects,
            values=values,
            state=state,
            joints=self._n,
            only=only,
        )

    def _along(self, torque: Floats) -> Floats:
        """(G, n) N*m at every row of the walk."""
        count = np.bincount(self._of)
        own = np.stack([np.bincount(self._of, column) / count for column in torque.T], axis=1)
        more = own - self._rigid[self._at]
        spread = [np.interp(self._grid, self._read, column) for column in more.T]
        return np.asarray(self._rigid + np.stack(spread, axis=1))


def walked_rows(rows: CommandedRows) -> Index:
    """Rows that a walk may not leave out: every joint's turning points, ends of cuts, and some in between."""
    keep = np.zeros(len(rows), dtype=bool)
    keep[:: -(-len(rows) // MOST_ROWS)] = True
    keep[[0, -1]] = True
    change = np.flatnonzero(np.diff(rows.cut)) + 1
    keep[change] = keep[change - 1] = True
    for move in np.diff(rows.q, axis=0).T:
        moving = np.flatnonzero(move != 0)
        keep[moving[1:][np.diff(np.sign(move[moving])) != 0]] = True
    return np.flatnonzero(keep)


def rigid_torque(session: Session, q: Floats, wrench: Floats) -> Floats:
    """(G, n) N*m of a rigid arm at postures (G, n) with its tool, under wrenches (G, 6) at the TCP in base axes."""
    statics, tool = Statics(session.robot, ()), session.tool.tool()
    angle, w = ca.SX.sym("q", statics.robot.n), ca.SX.sym("w", 6)
    hung = [(statics.robot.n, ca.SX(tool.mass), ca.SX(ca.DM(tool.com)))] if tool.com is not None else []
    _, torque = statics.law(
        posture=statics.posture(angle, ca.SX.zeros(statics.n_x)),
        q=angle,
        weights=statics.loads_of_weight(ca.SX(ca.DM(session.gravity_in_base)), hung),
        loads=[Load(statics.robot.n, ca.SX(ca.DM(tool.position)), w)],
        state=None,
        values={},
    )
    (out,) = Kernel(ca.Function("rigid_torque", [angle, w], [ca.densify(torque)])).run(q, wrench)
    return np.asarray(out)
