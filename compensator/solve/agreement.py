"""Commands and flank states of a path as it is, iterated until they agree.

The flanks follow from the commanded moves, the commands from the flanks. Both follow from what came before alone: a
path is taken piece by piece, and a piece that agrees is not looked at again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from compensator.errors import SolveError
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import place
from compensator.solve.joint_state import SAME_STATE, commanded_moves, pieces, settled_state, without_states
from compensator.solve.made_command import MadeCommand
from compensator.solve.rapid_fade import held_targets
from stiffness.memory.preload import PathState, PreloadState, walk
from stiffness.statics.prediction import COLUMNS, TOLERANCE, Command, PathColumns, StartValues
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

STATE_ROUNDS = 12
UNSETTLED_FROM = 10  # rounds after which a state that still changes is taken as either


@dataclass(frozen=True)
class _Piece:
    """Poses in a row with what was before them.

    Attributes:
        first: state before the first pose.
        nominal: (n,) rad, nominal angles of the pose before; None: not known.
        without: (n,) rad, its command with all deflection states taken as zero; None: not known.
    """

    path: PlannedPath
    target: Frame
    wrench: Floats
    held: Rows
    first: PreloadState
    nominal: Floats | None
    without: Floats | None


@dataclass(frozen=True)
class _Agreed:
    """What a piece comes to; ``unsettled`` (N,): poses whose flank changes with every correction; ``creeping`` (N, n):
    joints of them that move there by less than they are corrected."""

    command: Command
    state: PreloadState
    rounds: int
    unsettled: npt.NDArray[np.bool_]
    creeping: npt.NDArray[np.bool_]


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
    if not len(path):
        raise SolveError(f"{path.toolpath.source}: no poses")
    columns, states, unsettled = PathColumns(len(path), COLUMNS), list[PathState](), np.zeros(len(path), dtype=bool)
    creeping = np.zeros(arm.robot.n, dtype=np.intp)
    first, nominal, without, steps, rounds = arm.unknown_state, start, start, 0, 0
    for rows in pieces(arm, len(path)):
        some = path if len(rows) == len(path) else path.take(rows)
        piece = _Piece(
            path=some, target=target.take(rows), wrench=wrench[rows], held=np.flatnonzero(np.isin(rows, held)),
            first=first, nominal=nominal, without=without,
        )  # fmt: skip
        begin = None if near is None else StartValues(near.q[rows], near.actual[rows], near.extra[rows])
        done = _piece_agreed(arm, piece, begin)
        columns.put(rows, done.command)
        states.append(done.state.kept())
        creeping += done.creeping.sum(axis=0)
        unsettled[rows], steps, rounds = done.unsettled, max(steps, done.command.steps), max(rounds, done.rounds)
        if rows[-1] < len(path) - 1:
            first, nominal = done.state.last, some.q[-1]
            if arm.unknown_state.low.size:
                without = without_states(arm, done.command, done.state.middle)[-1]
    _refuse_unsettled(path.toolpath, unsettled, creeping)
    command = MadeCommand(**columns.whole, nominal=partial(arm.printed, path.toolpath), steps=steps)
    del columns  # in the closed form, actual angles are those of the path but at held poses
    return command.sharing(path.q), PreloadState.chained(states), rounds


def _piece_agreed(arm: EquippedArm, piece: _Piece, begin: StartValues | None) -> _Agreed:
    path, target, wrench = piece.path, piece.target, piece.wrench
    moves = partial(commanded_moves, start=piece.without)
    state = walk(
        arm.effects, arm.values, commanded_moves(path.q, piece.nominal), torque=np.zeros_like(path.q),
        start=piece.first,
    )  # fmt: skip
    unsettled, turned = np.zeros(len(path), dtype=bool), np.zeros(path.q.shape, dtype=bool)
    if len(piece.held):
        target = held_targets(arm, path, wrench, state, target=target, rows=piece.held)
    command = _solved(arm, path.toolpath, target, wrench=wrench, state=state.middle, seed=path.q, near=begin)
    rounds = 1
    while state.low.shape[1]:
        new = settled_state(arm, command, state, first=piece.first, moves=moves)
        change = np.abs(new.middle - state.middle).max(axis=1)
        rows = np.flatnonzero(change > SAME_STATE)
        if not len(rows):
            break
        if rounds >= UNSETTLED_FROM:
            turned |= _by_joint(np.abs(new.middle - state.middle) > SAME_STATE, path.q.shape[1])
            new = _either(state, new, change > SAME_STATE)
            unsettled |= change > SAME_STATE
        state = new
        if rounds == STATE_ROUNDS:
            break
        rounds += 1
        if len(piece.held):
            target = held_targets(arm, path, wrench, state, target=target, rows=piece.held)
        part = _solved(
            arm, path.toolpath.take(rows), target.take(rows), wrench=wrench[rows], state=state.middle[rows],
            seed=path.q[rows], near=StartValues(command.q[rows], command.actual[rows], command.extra[rows]),
        )  # fmt: skip
        command = command.replaced(rows, part)
    way = np.abs(commanded_moves(path.q, piece.nominal))
    return _Agreed(command, state, rounds, unsettled, creeping=turned & (way < np.abs(command.q - path.q)))


def _by_joint(states: npt.NDArray[np.bool_], n: int) -> npt.NDArray[np.bool_]:
    """(N, n) of states (N, S), which every effect has for each joint."""
    return np.asarray(states.reshape(len(states), -1, n).any(axis=1))


def _either(state: PreloadState, new: PreloadState, rows: npt.NDArray[np.bool_]) -> PreloadState:
    """Where a torque of about zero makes the flank change with every correction, both are possible."""
    low, high, at = np.minimum(state.low, new.low), np.maximum(state.high, new.high), rows[:, None]
    return PreloadState(np.where(at, low, new.low), np.where(at, high, new.high))


def _refuse_unsettled(toolpath: Toolpath, unsettled: npt.NDArray[np.bool_], creeping: Rows) -> None:
    """Refuse a path on which that is so at more than a few poses; ``creeping`` (n,): at how many each joint creeps."""
    if unsettled.sum() > max(10, 0.01 * len(unsettled)):
        k = int(np.argmax(unsettled))
        many, where = int(unsettled.sum()), place(toolpath, k)
        what = f"{where}: joint state and correction do not agree at {many} poses: every correction turns a joint"
        joint, count = int(np.argmax(creeping)), int(creeping.max())
        if 2 * count >= many:
            raise SolveError(
                f"{what} around again: at {count} of them joint {joint + 1} moves by less from pose to pose than it is "
                "corrected, so that the correction decides its direction. Let it move: another place of the part or "
                "the rail, another turn, a coarser sampling.spacing"
            )
        remedy = "Check gap, breakaway and side of the backlash in the model"
        raise SolveError(f"{what} around again. {remedy}")


def _solved(
    arm: EquippedArm,
    toolpath: Toolpath,
    target: Frame,
    *,
    wrench: Floats,
    state: Floats,
    seed: Floats,
    near: StartValues | None,
) -> Command:
    """Commands of poses with known states.

    Raises:
        SolveError: a pose has none; names the worst.
    """
    command = arm.command(toolpath, target, wrench=wrench, state=state, seed=seed, near=near)
    bad = ~command.converged
    if bad.any():
        worst = np.argsort(np.where(np.isfinite(command.error), command.error, np.inf))[::-1][:5]
        names = "; ".join(f"{place(toolpath, int(k))}: {command.error[k]:.1e}" for k in worst if bad[k])
        raise SolveError(
            f"{int(bad.sum())} of {len(bad)} poses have no command whose deflected TCP stands at the nominal pose "
            f"within {TOLERANCE:g} m and rad; the worst: {names}"
        )
    return command
