"""Contact: which pose of a program made a point of the part: the last one whose cutter touches the point.

The cutter is a body of revolution about the tool axis: a cylinder with a rounded edge (flat: none, ball: all of it).
Between two rows of a cut the tool passes the point where its axis is nearest; there its distance counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.session.path_trace import CommandedRows

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

TOUCHES = 2e-4  # m between a nominal point and the cutter that made it: chords and rounding of CAM
PIECE = 256  # points at a time


@dataclass(frozen=True)
class TouchingCutter:
    """Radius, radius of its rounded edge, and length of the cutting edge, m."""

    radius: float
    corner: float
    length: float

    def distance(self, across: Floats, up: Floats) -> Floats:
        """m from its surface, negative inside, at ``across`` m from its axis and a height ``up`` over its tip."""
        x, y = across - (self.radius - self.corner), self.corner - up
        edge = np.hypot(np.maximum(x, 0), np.maximum(y, 0)) + np.minimum(np.maximum(x, y), 0) - self.corner
        return np.where(up > self.length, np.hypot(np.maximum(across - self.radius, 0), up - self.length), edge)


def contacts(point: Floats, rows: CommandedRows, cutter: TouchingCutter) -> Floats:
    """(N,) index of the pose that made each point (N, 3), base; NaN where none did."""
    first = np.flatnonzero(rows.cut[1:] & rows.cut[:-1])
    begin, way = rows.nominal[first], rows.nominal[first + 1] - rows.nominal[first]
    axis = rows.path_axes[first][:, :, 2]  # out of the tool, into the work
    length = np.maximum(np.sum(way**2, axis=1), 1e-18)
    out = np.full(len(point), np.nan)
    for at in range(0, len(point) if len(first) else 0, PIECE):
        some = slice(at, at + PIECE)
        to = point[some, None] - begin[None]  # (P, S, 3)
        share = np.clip(np.einsum("psk,sk->ps", to, way) / length, 0.0, 1.0)
        off = to - share[:, :, None] * way
        up = -np.einsum("psk,sk->ps", off, axis)
        across = np.linalg.norm(off + up[:, :, None] * axis, axis=2)
        touches = np.abs(cutter.distance(across, up)) < TOUCHES
        last = touches.shape[1] - 1 - np.argmax(touches[:, ::-1], axis=1)
        found = touches.any(axis=1)
        mine = np.arange(len(last))
        out[some] = np.where(found, first[last] + share[mine, last], np.nan)
    return out
