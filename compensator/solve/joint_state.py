"""Joint state along a path: what the commanded moves and the torques make of every flank."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from stiffness.memory.preload import PathState, PreloadState, walk
from stiffness.statics.prediction import PREDICTED, Command, PathColumns, Prediction
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

SETTLE_ROUNDS = 4
FOLLOW_ROUNDS = 10
SAME_STATE = 1e-9  # rad, and of the direction state: below, two states are one
STATELESS = 65536  # poses at a time of an arm that remembers nothing, so that memory stays small
PIECE = 16384  # poses whose state is iterated together: what is settled is not walked again, and memory stays small


def pieces(arm: EquippedArm, poses: int) -> Iterator[Rows]:
    """Rows of a path that are solved one after the other, from the state at the end of those before."""
    size = PIECE if arm.unknown_state.low.size else STATELESS
    for first in range(0, max(poses, 1), size):
        yield np.arange(first, min(first + size, poses))


def commanded_moves(q: Floats, start: Floats | None) -> Floats:
    """(N, n) commanded move to every pose of q (N, n); the first one from ``start`` (n,), if that is known."""
    return np.diff(q, axis=0, prepend=q[:1] if start is None else start[None])


def settled_state(
    arm: EquippedArm,
    command: Command,
    state: PreloadState,
    *,
    first: PreloadState,
    moves: Callable[[Floats], Floats],
) -> PreloadState:
    """The state that commands cause which stand where ``command`` stands, whatever state they were solved with.

    Actual angles and torques hardly depend on the state, so state and command are iterated on them alone;
    the caller solves again and looks whether that was true.

    Args:
        first: before the first pose.
        moves: commanded angles -> commanded moves.
    """
    for _ in range(SETTLE_ROUNDS):
        middle = state.middle
        new = walk(
            arm.effects, arm.values, moves(without_states(arm, command, middle)), torque=command.torque,
            start=first, corrected=True,
        )  # fmt: skip
        if not np.any(np.abs(new.middle - middle) > SAME_STATE):
            break
        state = new
    return new


def without_states(arm: EquippedArm, command: Command, middle: Floats) -> Floats:
    """(..., n) rad: the command as it would be with all deflection states taken as zero."""
    states = middle.reshape(-1, middle.shape[-1])
    flat = (-1, arm.robot.n)
    dq = arm.joint_deflection(command.q.reshape(flat), command.torque.reshape(flat), states)
    return np.asarray(command.actual - (dq - arm.joint_states(states)).reshape(command.actual.shape))


def equilibrium_along(
    arm: EquippedArm,
    start: Floats | None,
    toolpath: Toolpath,
    *,
    q: Floats,
    wrench: Floats,
    guess: PreloadState | None = None,
) -> tuple[Prediction, PreloadState]:
    """Equilibrium along a commanded path, with the state that the commands themselves cause.

    The torque that decides the state is that of the deflected posture: few rounds settle it. Where a torque
    of about zero lets a flank rest on either side, ``guess`` decides.

    Args:
        start: (n,) rad where the path starts from; None: not known.
        q: (N, n) rad, commands. wrench: (N, 6) on the robot, base axes, about the TCP.
    """
    columns, state = equilibrium_columns(arm, start, toolpath, q=q, wrench=wrench, guess=guess, names=PREDICTED)
    return Prediction(**columns), state


def equilibrium_columns(
    arm: EquippedArm,
    start: Floats | None,
    toolpath: Toolpath,
    *,
    q: Floats,
    wrench: Floats,
    names: Sequence[str],
    guess: PreloadState | None = None,
) -> tuple[Mapping[str, Floats], PreloadState]:
    """As ``equilibrium_along``, of the Prediction only the columns ``names``: a million poses of all are 150 MB."""
    columns, states = PathColumns(len(q), names), list[PathState]()
    for rows, prediction, state in equilibria(arm, start, toolpath, q=q, wrench=wrench, guess=guess):
        columns.put(rows, prediction)
        states.append(state.kept())
    return columns.whole, PreloadState.chained(states)


def equilibria(
    arm: EquippedArm,
    start: Floats | None,
    toolpath: Toolpath,
    *,
    q: Floats,
    wrench: Floats,
    guess: PreloadState | None = None,
) -> Iterator[tuple[Rows, Prediction, PreloadState]]:
    """As ``equilibrium_along``, piece by piece: its rows, what is predicted there, and the state."""
    first, before = arm.unknown_state, start
    for rows in pieces(arm, len(q)):
        some = toolpath if len(rows) == len(q) else toolpath.take(rows)
        moves, near = commanded_moves(q[rows], before), None if guess is None else guess.take(rows)
        prediction, state = _equilibrium(arm, some, q[rows], wrench=wrench[rows], moves=moves, first=first, guess=near)
        yield rows, prediction, state
        if len(rows):
            first, before = state.last, q[rows[-1]]


def _equilibrium(
    arm: EquippedArm,
    toolpath: Toolpath,
    q: Floats,
    *,
    wrench: Floats,
    moves: Floats,
    first: PreloadState,
    guess: PreloadState | None,
) -> tuple[Prediction, PreloadState]:
    state = guess or walk(arm.effects, arm.values, moves, torque=np.zeros_like(q), start=first)
    prediction = arm.forward(toolpath, q, wrench, state.middle)
    for _ in range(FOLLOW_ROUNDS if state.low.shape[1] else 0):
        new = walk(arm.effects, arm.values, moves, torque=prediction.torque, start=first)
        rows = np.flatnonzero(np.abs(new.middle - state.middle).max(axis=1) > SAME_STATE)
        state = new
        if not len(rows):
            break
        part = arm.forward(toolpath.take(rows), q[rows], wrench[rows], state.middle[rows])
        prediction = prediction.replaced(rows, part)
    return prediction, state


def spread_of_unknown(
    arm: EquippedArm, toolpath: Toolpath, *, q: Floats, wrench: Floats, state: PreloadState
) -> Floats:
    """(N,) m: distance between the TCP with the lowest and the highest state that the data allows."""
    out = np.zeros(len(q))
    rows = state.unknown_rows
    if len(rows):
        part = toolpath.take(rows)
        open_ = state.take(rows)
        low = arm.forward(part, q[rows], wrench[rows], open_.low)
        high = arm.forward(part, q[rows], wrench[rows], open_.high)
        out[rows] = np.linalg.norm(high.position - low.position, axis=1)
    return out
