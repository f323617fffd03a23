"""What a filter in place has to change: per cutting move of a program, the poses that take its place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.frame import Frame
from toolpaths.interpreting.robot_moves import ARC, RobotMoves
from toolpaths.rewriting.filter import SAME_PLACE, SAME_TURN
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.toolpath import CUT
from toolpaths.writing.program import Floats, Program

Ints64 = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, repr=False)
class Correction:
    """New poses of one move, in the move's own frame; the last one is its end.

    Attributes:
        move: index of the move.
        pose: K frames, m.
        poses: (K,) indices in the program.
        moved: whether the end is another pose than the file has.
    """

    move: int
    pose: Frame
    poses: tuple[int, ...]
    moved: bool

    def __repr__(self) -> str:
        return f"Correction(move {self.move}, {len(self.poses)} poses)"


def corrections(moves: RobotMoves, program: Program, row: Floats) -> list[Correction]:
    """One per cutting move that changes, in the order of the moves.

    A move changes where its end is another pose than the file has, or where poses are put in before its end; an arc
    keeps the points that only stand for its roundness, unless one of its poses, or its start, is corrected.
    """
    pose = _in_own_frames(moves, program, row)
    same = _same(program)
    owner = np.ceil(np.asarray(row) - 1e-9).astype(np.int64)
    starts = np.searchsorted(owner, np.arange(len(moves) + 1))
    count = np.diff(starts)
    cuts = np.flatnonzero((moves.mark["kind"] == CUT) & (count > 0))
    moved = _moved(moves, cuts, pose.take(starts[cuts + 1] - 1))
    out = []
    changed = moved | (count[cuts] > 1)
    for move, end_moved in zip(cuts[changed].tolist(), moved[changed].tolist(), strict=True):
        part = slice(int(starts[move]), int(starts[move + 1]))
        whole = slice(max(part.start - 1, 0), part.stop)  # with the pose that it starts from
        if end_moved or not (moves.mark["word"][move] == ARC and same[whole].all()):
            poses = tuple(range(part.start, part.stop))
            out.append(Correction(move, pose.take(part), poses, end_moved))
    return out


def angles_of(found: list[Correction], count: int, spelled: Callable[[Floats], Floats]) -> Floats:
    """(N, 3) the turns of the N = ``count`` poses of a program as its language spells them, 0 where none changes."""
    out = np.zeros((count, 3))
    if found:
        out[np.concatenate([c.poses for c in found])] = spelled(np.concatenate([c.pose.rotation for c in found]))
    return out


def _same(program: Program) -> Bools:
    """(M,) poses that are commanded where they have to be."""
    nominal = program.position if program.nominal_position is None else program.nominal_position
    turned = program.rotation if program.nominal_rotation is None else program.nominal_rotation
    place = np.linalg.norm(program.position - np.asarray(nominal), axis=1) <= SAME_PLACE
    turn = np.abs(np.asarray(program.rotation) - np.asarray(turned)).max(axis=(1, 2), initial=0.0)
    return np.asarray(place & (turn <= SAME_TURN))


def _moved(moves: RobotMoves, cuts: Ints64, end: Frame) -> Bools:
    """(K,) whether the ends of the moves ``cuts`` are others than the file has; always where that has joint angles."""
    known = np.isfinite(moves.quaternion[cuts, 0])
    moved = np.ones(len(cuts), dtype=bool)
    place = np.linalg.norm(end.origin[known] - moves.position[cuts[known]], axis=1)
    turned = np.abs(end.rotation[known] - matrix_from_quaternion(moves.quaternion[cuts[known]]))
    turn = turned.max(axis=(1, 2), initial=0.0)
    moved[known] = (place > SAME_PLACE) | (turn > SAME_TURN)
    return moved


def _in_own_frames(moves: RobotMoves, program: Program, row: Floats) -> Frame:
    """The M poses of the program, each in the frame of the move that it belongs to."""
    owner = np.minimum(np.ceil(np.asarray(row) - 1e-9).astype(np.int64), len(moves) - 1)
    frame = moves.mark["frame"][owner]
    position, rotation = program.position.copy(), np.array(program.rotation)
    for number, main in enumerate(moves.from_main()):
        at = (frame == number) & (number != moves.main_frame)
        if at.any():
            position[at] = main.at(program.position[at])
            rotation[at] = main.rotation @ rotation[at]
    return Frame(rotation, position)
