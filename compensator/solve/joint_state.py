"""Joint state along a path: what the commanded moves and the torques make of every flank."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from stiffness.memory.preload import PreloadState, walk
from stiffness.statics.prediction import Command, Prediction
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

STATE_ROUNDS = 12
SETTLE_ROUNDS = 4
FOLLOW_ROUNDS = 10
SAME_STATE = 1e-9  # rad, and of the direction state: below, two states are one


def commanded_moves(job: Job, q: Floats) -> Floats:
    """(N, n) commanded move to every pose; the first one from [start], if there is one."""
    first = q[:1] if job.cell.start is None else np.radians([job.cell.start.joints])
    return np.diff(q, axis=0, prepend=first)


def settled_state(
    job: Job, command: Command, state: PreloadState, start: PreloadState, moves: Callable[[Job, Floats], Floats]
) -> PreloadState:
    """The state that commands cause which stand where ``command`` stands, whatever state they were solved with.

    Actual angles and torques hardly depend on the state, so state and command are iterated on them alone;
    the caller solves again and looks whether that was true.
    """
    for _ in range(SETTLE_ROUNDS):
        middle = state.middle
        shape = middle.shape[:-1]
        flat = (-1, job.robot.n)
        dq = job.joint_deflection(
            command.q.reshape(flat), command.torque.reshape(flat), middle.reshape(-1, middle.shape[-1])
        )
        without = command.actual - (dq - job.joint_states(middle.reshape(-1, middle.shape[-1]))).reshape(*shape, -1)
        new = walk(job.effects, job.values, moves(job, without), command.torque, start, corrected=True)
        if not np.any(np.abs(new.middle - middle) > SAME_STATE):
            break
        state = new
    return new


def follow(
    job: Job, toolpath: Toolpath, q: Floats, wrench: Floats, guess: PreloadState | None = None
) -> tuple[Prediction, PreloadState]:
    """Equilibrium along a commanded path, with the state that the commands themselves cause.

    The torque that decides the state is that of the deflected posture: few rounds settle it. Where a torque
    of about zero lets a flank rest on either side, ``guess`` says which.
    """
    start, moves = job.state_before, commanded_moves(job, q)
    state = guess or walk(job.effects, job.values, moves, np.zeros_like(q), start)
    prediction = job.forward(toolpath, q, wrench, state.middle)
    for _ in range(FOLLOW_ROUNDS if state.low.shape[1] else 0):
        new = walk(job.effects, job.values, moves, prediction.torque, start)
        rows = np.flatnonzero(np.abs(new.middle - state.middle).max(axis=1) > SAME_STATE)
        state = new
        if not len(rows):
            break
        part = job.forward(toolpath.take(rows), q[rows], wrench[rows], state.middle[rows])
        prediction = _replaced(prediction, rows, part)
    return prediction, state


def _replaced(whole: Prediction, rows: npt.NDArray[np.intp], part: Prediction) -> Prediction:
    names = ("rotation", "position", "torque", "residual")
    arrays = {name: getattr(whole, name).copy() for name in names}
    for name, array in arrays.items():
        array[rows] = getattr(part, name)
    return Prediction(**arrays)


def spread_of_unknown(job: Job, toolpath: Toolpath, q: Floats, wrench: Floats, state: PreloadState) -> Floats:
    """(N,) m: distance between the TCP with the lowest and the highest state that the data allows."""
    out = np.zeros(len(q))
    rows = np.flatnonzero(~state.known.all(axis=1)) if state.low.shape[1] else np.empty(0, dtype=np.intp)
    if len(rows):
        part = toolpath.take(rows)
        low = job.forward(part, q[rows], wrench[rows], state.low[rows])
        high = job.forward(part, q[rows], wrench[rows], state.high[rows])
        out[rows] = np.linalg.norm(high.position - low.position, axis=1)
    return out
