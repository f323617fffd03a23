"""Moves of an INFORM job: positions in the robot frame, RCONF, speeds, stops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_motoman, motoman_from_matrix
from toolpaths.toolpath import CUT
from toolpaths.writing.blending import blending
from toolpaths.writing.numbers import number
from toolpaths.writing.program import Floats, Program


@dataclass(frozen=True)
class InformMoves:
    """The moves of a program.

    Attributes:
        program: where they come from.
        speed: (N,) mm/s in steps of 0.1.
        stop: (N,) poses to stand at (PL=0).
    """

    program: Program
    speed: Floats
    stop: npt.NDArray[np.bool_]

    def numbers(self, block: npt.NDArray[np.intp]) -> Floats:
        """(M, 6) X Y Z mm, Rx Ry Rz deg of the TCP in the robot frame, as they will be printed."""
        work = self.program.workobject
        position = work.at(self.program.position[block])
        angles = _rounded(work.rotation @ self.program.rotation[block])
        return np.asarray(np.column_stack((np.round(position * 1e3, 3), angles)) + 0.0)


def _rounded(rotation: Floats) -> Floats:
    """(M, 3) Rx Ry Rz in steps of 0.0001 deg.

    Ry and Rz are taken for Rx as printed: near Ry = 90 deg, where Rx and Rz turn about the same axis, their
    two roundings would add up to more than one.
    """
    angles = np.zeros((len(rotation), 3))
    angles[:, 0] = np.round(np.degrees(motoman_from_matrix(rotation)[:, 0]), 4)
    rest = rotation @ matrix_from_motoman(-np.radians(angles))
    angles[:, 1] = np.degrees(np.arctan2(-rest[:, 2, 0], np.hypot(rest[:, 0, 0], rest[:, 1, 0])))
    angles[:, 2] = np.degrees(np.arctan2(-rest[:, 0, 1], rest[:, 1, 1]))
    return np.asarray(np.round(angles, 4))


def moves(program: Program) -> InformMoves:
    """Speeds and stops of a program."""
    speed = np.where(program.kind == CUT, program.feed, program.rapid_speed) * 1e3
    return InformMoves(program, np.maximum(np.round(speed, 1), 0.1), _stops(program))


def _stops(program: Program) -> npt.NDArray[np.bool_]:
    """(N,) poses that must not be rounded.

    A job cannot bound the rounding: without PL the controller rounds by as much as speed and acceleration
    ask, at most half a segment. So a pose is passed only where half the shorter segment would be allowed.
    """
    radius = blending(program).radius[1:-1]  # first: it takes more room than all that follows
    step = np.linalg.norm(np.diff(program.position, axis=0), axis=1)
    shorter = np.minimum(step[:-1], step[1:])
    stop = np.ones(len(program), dtype=bool)
    stop[1:-1] = (radius <= 0.0) | (radius < 0.5 * shorter * (1.0 - 1e-9))
    return stop


def rconf(program: Program, block: npt.NDArray[np.intp]) -> list[str]:
    """RCONF of each pose: no-flip, lower arm, rear, R, T, S beyond 180 deg, then 18 that are not used.

    Sources: DX100 HW0482494, 4.1.3 (order; 0 is flip, upper arm, front, less than 180 deg); Yaskawa's YMConnect SDK,
    ``Figure`` (no-flip: axis B negative; lower arm: the elbow bends beyond 180 deg; rear: the wrist is behind axis S).
    The NX100 and older define flip by axis R (RE-CSO-A031, 3.9): jobs for those are not written.
    """
    degrees = np.round(np.degrees(program.joints[block]), 6) + 0.0
    c = np.zeros(len(degrees), dtype=np.int64) if program.configuration is None else program.configuration[block]
    noflip, lower, rear = degrees[:, 4] < 0.0, (c >> 1) & 1, (c >> 2) & 1
    turned = ~((degrees > -180.0) & (degrees <= 180.0))
    bits = np.column_stack((noflip, lower, rear, turned[:, 3], turned[:, 5], turned[:, 0])).astype(np.int64)
    keys = bits @ (1 << np.arange(6))
    texts = [",".join(str(k >> i & 1) for i in range(6)) + ",0" * 18 for k in range(64)]
    return [texts[k] for k in keys.tolist()]


def frame_text(frame: Frame) -> tuple[str, ...]:
    """X Y Z in mm, Rx Ry Rz in deg, as text."""
    values = (*(frame.origin * 1e3), *np.degrees(motoman_from_matrix(frame.rotation)))
    return tuple(number(float(v), d) for v, d in zip(values, (4, 4, 4, 5, 5, 5), strict=True))
