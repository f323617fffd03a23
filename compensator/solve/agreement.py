"""Commands and flank states of a path as it is, iterated until they agree.

The flanks follow from the commanded moves, the commands from the flanks.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from compensator.errors import SolveError
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import place
from compensator.solve.joint_state import SAME_STATE, commanded_moves, settled_state
from compensator.solve.rapid_fade import held_targets
from stiffness.memory.preload import PreloadState, walk
from stiffness.statics.prediction import TOLERANCE, Command, StartValues
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

STATE_ROUNDS = 12
UNSETTLED_FROM = 10  # rounds after which a state that still changes is taken as either


def agreed(
    arm: EquippedArm,
    start: Floats | None,
    path: PlannedPath,
    target: Frame,
    *,
    wrench: Floats,
    near: StartValues | Command | None,
    held: Rows,
) -> tuple[Command, PreloadState, int]:
    """Command, state and rounds, iterated until the state stops changing.

    Args:
        start: (n,) rad where the path starts from; None: not known.
        target: (N) TCP, base; not used at poses ``held``, which are commanded as they are.
        wrench: (N, 6) on the robot, base axes, about the TCP.
        near: where the solve begins.

    Raises:
        SolveError: a pose has no command, or state and command do not agree; names the poses.
    """
    first, moves = arm.unknown_state, partial(commanded_moves, start=start)
    state = walk(arm.effects, arm.values, moves(path.q), torque=np.zeros_like(path.q), start=first)
    command: Command | None = None
    rows = np.arange(len(path))
    for rounds in range(1, STATE_ROUNDS + 1):
        if len(held):
            target = held_targets(arm, path, wrench, state, rows=held)
        begin = None if near is None else StartValues(near.q[rows], near.actual[rows], near.extra[rows])
        some = path.toolpath if command is None else path.toolpath.take(rows)
        at = target.take(rows)
        part = arm.command(
            some, at, wrench=wrench[rows], state=state.middle[rows], seed=path.q[rows], near=begin
        )
        _refuse_unsolved(some, part)
        near = command = part if command is None else command.replaced(rows, part)
        if not state.low.shape[1]:
            break
        new = settled_state(arm, command, state, first=first, moves=moves)
        change = np.abs(new.middle - state.middle).max(axis=1)
        rows = np.flatnonzero(change > SAME_STATE)
        if not len(rows):
            break
        state = new if rounds < UNSETTLED_FROM else _either(path.toolpath, state, new, change)
    if command is None:
        raise SolveError(f"{path.toolpath.source}: no poses")
    return command, state, rounds


def _either(toolpath: Toolpath, state: PreloadState, new: PreloadState, change: Floats) -> PreloadState:
    """Where a torque of about zero makes the flank change with every correction, both are possible.

    Raises:
        SolveError: that is so at more than a few poses.
    """
    unsettled = change > SAME_STATE
    if unsettled.sum() > max(10, 0.01 * len(change)):
        k = int(np.argmax(unsettled))
        raise SolveError(
            f"{place(toolpath, k)}: joint state and correction do not agree at {int(unsettled.sum())} poses: every "
            "correction turns a joint around again. Check gap, breakaway and side of the backlash in the model"
        )
    both = PreloadState(np.minimum(state.low, new.low), np.maximum(state.high, new.high))
    rows = unsettled[:, None]
    return PreloadState(np.where(rows, both.low, new.low), np.where(rows, both.high, new.high))


def _refuse_unsolved(toolpath: Toolpath, command: Command) -> None:
    bad = ~command.converged
    if bad.any():
        worst = np.argsort(np.where(np.isfinite(command.error), command.error, np.inf))[::-1][:5]
        names = "; ".join(f"{place(toolpath, int(k))}: {command.error[k]:.1e}" for k in worst if bad[k])
        raise SolveError(
            f"{int(bad.sum())} of {len(bad)} poses have no command whose deflected TCP stands at the nominal pose "
            f"within {TOLERANCE:g} m and rad; the worst: {names}"
        )
