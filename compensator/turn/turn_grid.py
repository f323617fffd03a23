"""Turn grid: a path against the turn about the tool axis, and which postures there an arm can take.

The closed form solves all of them at once. The arm configuration is that of the path: between two configurations lies a
singularity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.errors import PathError
from compensator.path.free_turn import about_z
from compensator.path.motion_bounds import MotionBounds
from compensator.path.planned_path import PlannedPath
from compensator.path.tcp_inverse import TcpInverse
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

TURNS = 72  # per pose, 5 deg apart
CELLS = 1 << 16  # that are solved at once: what numpy needs beside the kernels stays small

#: What a cell of the grid is; the first that holds.
FREE, OUT_OF_REACH, BEYOND_LIMIT, SINGULAR, COLLIDING = (np.uint8(k) for k in range(5))

#: Whether the arm touches nothing: poses (M,) of the path, joint angles (M, T, n) rad -> (M, T).
Clearance = Callable[[Rows, Floats], npt.NDArray[np.bool_]]


@dataclass(frozen=True, repr=False, eq=False)
class TurnGrid:
    """Postures of an arm at M poses of a path, at T turns each.

    Attributes:
        rows: (M,) poses of the path, ascending.
        turns: (T,) rad from the reference orientation of the path, evenly over a full turn.
        q: (M, T, n) rad, each joint as near as full turns bring it to the middle of its limits; no meaning where out of
            reach.
        status: (M, T) FREE, OUT_OF_REACH, BEYOND_LIMIT, SINGULAR or COLLIDING.
        margin: (M, T) as ``MotionBounds.margin``; -inf out of reach.
    """

    rows: Rows
    turns: Floats
    q: Floats
    status: npt.NDArray[np.uint8]
    margin: Floats

    def __repr__(self) -> str:
        return f"TurnGrid({len(self.rows)} poses x {len(self.turns)} turns, {np.mean(self.free):.0%} free)"

    @property
    def free(self) -> npt.NDArray[np.bool_]:
        """(M, T) what an arm may be sent to."""
        return np.asarray(self.status == FREE)

    @property
    def step(self) -> float:
        """rad between two turns."""
        return float(2 * np.pi / len(self.turns))

    def index(self, turn: Floats) -> tuple[Rows, Floats]:
        """The column below each turn (M,), and the share of the way to the next one."""
        at = np.asarray(turn) / self.step
        return np.floor(at).astype(np.intp) % len(self.turns), at - np.floor(at)

    def free_at(self, turn: Floats) -> npt.NDArray[np.bool_]:
        """(M,) whether both columns about each turn (M,) are free."""
        below, share = self.index(turn)
        k, free = np.arange(len(self.rows)), self.free
        above = (below + 1) % len(self.turns)
        return np.asarray((free[k, below] | (share > 1 - 1e-9)) & (free[k, above] | (share < 1e-9)))


def turn_grid(
    inverse: TcpInverse,
    bounds: MotionBounds,
    path: PlannedPath,
    rows: Rows,
    *,
    turns: int = TURNS,
    clear: Clearance | None = None,
) -> TurnGrid:
    """Solve the grid.

    Args:
        path: whose configuration the arm keeps.
        rows: (M,) its poses.
        clear: asked for every cell that nothing else forbids; None: nothing stands around.

    Raises:
        PathError: the arm has no closed form.
    """
    refuse_without_closed_form(inverse)
    angles = 2 * np.pi * np.arange(turns) / turns
    q = np.empty((len(rows), turns, inverse.robot.n))
    status, margin = np.empty((len(rows), turns), dtype=np.uint8), np.empty((len(rows), turns))
    step = max(CELLS // turns, 1)
    for begin in range(0, len(rows), step):
        part = slice(begin, begin + step)
        q[part], status[part], margin[part] = _solved(inverse, bounds, path, rows[part], turns=angles)
        if clear is not None:
            hit = ~clear(rows[part], q[part]) & (status[part] == FREE)
            status[part][hit] = COLLIDING
    return TurnGrid(rows=rows, turns=angles, q=q, status=status, margin=margin)


def refuse_without_closed_form(inverse: TcpInverse) -> None:
    """Refuse an arm whose configuration has no name that holds from pose to pose.

    Raises:
        PathError: names the robot.
    """
    if not inverse.labelled:
        raise PathError(
            f"{inverse.robot.name}: turns along a path are looked at in closed form, which needs a spherical wrist "
            '(axes 4, 5, 6 through one point); this arm has none: keep [solve] turn = "constant"'
        )


def reference_of(path: PlannedPath, rows: Rows) -> Frame:
    """(M) TCP in the base before it is turned about the tool axis."""
    at = path.tcp.take(rows)
    return Frame(at.rotation @ about_z(-path.turn[rows]), at.origin)


def _solved(
    inverse: TcpInverse, bounds: MotionBounds, path: PlannedPath, rows: Rows, *, turns: Floats
) -> tuple[Floats, npt.NDArray[np.uint8], Floats]:
    """q, status and margin of some rows."""
    robot, shape = inverse.robot, (len(rows), len(turns))
    at = reference_of(path, rows)
    rotation = (at.rotation[:, None] @ about_z(turns)[None]).reshape(-1, 3, 3)
    tcp = Frame(rotation, np.repeat(at.origin, len(turns), axis=0))
    some = path.toolpath.take(np.repeat(rows, len(turns)))
    finite = np.isfinite(robot.lower + robot.upper)
    middle = np.where(finite, (np.where(finite, robot.lower, 0.0) + np.where(finite, robot.upper, 0.0)) / 2, 0.0)
    branch = np.repeat(path.branch[rows], len(turns))
    batch = inverse.along(some, tcp, branch, np.broadcast_to(middle, (len(some), robot.n)))
    q = np.where(batch.ok[:, None], batch.q, middle)
    margin = np.where(batch.ok, bounds.margin(q), -np.inf)
    status = np.full(len(q), FREE)
    status[margin < 0] = SINGULAR
    status[(batch.limit_margin < 0).any(axis=1)] = BEYOND_LIMIT
    status[~batch.ok] = OUT_OF_REACH
    return q.reshape(*shape, robot.n), status.reshape(shape), margin.reshape(shape)
