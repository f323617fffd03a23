"""Whether the poses that a filter commands along an arc of a program still lie on one arc."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpaths.interpreting.arcs import circle_through
from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.rewriting.filter import SAME_PLACE
from toolpaths.rotation import quaternion_from_matrix, slerp_quaternion
from toolpaths.writing.program import Floats, Program

ARC_PLACE = 1e-5  # m that commanded poses may lie off one arc
ARC_TURN = 2e-4  # rad that they may be turned off the turn from its start to its end
Rows = npt.NDArray[np.intp]


class ProgramArcs:
    """The arcs of one program.

    Args:
        program: commanded poses in the main frame of ``moves``.
        row: of each pose.
    """

    def __init__(self, moves: RobotMoves, program: Program, row: Floats) -> None:
        self.moves, self.program, self.row = moves, program, row
        self._ends, self._vias, self._own = moves.in_main(moves.position), moves.in_main(moves.via), moves.from_main()

    def via(self, r: int, poses: Rows) -> tuple[Floats, bool] | None:
        """The via point (3,) in the frame of move ``r`` and whether it moved; None where the poses are on no arc.

        Args:
            poses: of the program, from the arc's start to its end.
        """
        ends, main = self._ends[r - 1 : r + 1], self._vias[r]
        if not np.isfinite(ends[0]).all():  # it starts from joint angles
            nominal = self.program.position if self.program.nominal_position is None else self.program.nominal_position
            ends = np.array([nominal[poses[:1]][0], ends[1]])
        center, normal, sweep, share, _ = circle_through(ends[:1], main[None], ends[1:])
        t = self.row[poses] - (r - 1)
        shift = self.program.position[poses] - _on_circle(ends[0], center[0], normal[0], sweep[0] * t)
        moved = np.array([np.interp(share[0], t, column) for column in shift.T])
        if not self._one_turn(poses, t):
            return None
        if np.linalg.norm(moved) < SAME_PLACE and np.abs(shift).max() < SAME_PLACE:
            return self.moves.via[r], False
        if not self._one_arc(poses, main + moved):
            return None
        return self._own[int(self.moves.mark["frame"][r])].at(main + moved), True

    def _one_arc(self, k: Rows, via: Floats) -> bool:
        points = self.program.position[k]
        center, normal, _, _, flat = circle_through(points[:1], via[None], points[-1:])
        if flat[0]:
            return False
        arm = points - center
        height = arm @ normal[0]
        radius = np.linalg.norm(arm - height[:, None] * normal, axis=1)
        return bool(np.hypot(height, radius - radius[0]).max() <= ARC_PLACE)

    def _one_turn(self, k: Rows, t: Floats) -> bool:
        q = quaternion_from_matrix(self.program.rotation[k])
        way = slerp_quaternion(np.repeat(q[:1], len(k), axis=0), np.repeat(q[-1:], len(k), axis=0), t)
        return bool(2.0 * np.sqrt(np.maximum(0.0, 1.0 - np.sum(way * q, axis=1) ** 2)).max() <= ARC_TURN)


def _on_circle(start: Floats, center: Floats, normal: Floats, angle: Floats) -> Floats:
    """Points (K, 3) of a circle, ``angle`` (K,) from ``start`` on."""
    out = start - center
    side = np.cross(normal, out)
    return np.asarray(center + np.cos(angle)[:, None] * out + np.sin(angle)[:, None] * side)
