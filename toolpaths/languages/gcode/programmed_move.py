"""ProgrammedMove: one move as a block of G-code has it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from toolpaths.frame import Vector

Point = tuple[float, float]


@dataclass(frozen=True)
class ProgrammedMove:
    """A line, or an arc about ``center`` by ``sweep``; m in the coordinates in force (work object, or tilted plane).

    Attributes:
        start, end: m.
        mark: kind, as the track has it.
        feed: m/s.
        line: of the file.
        tool: its number.
        center: of an arc, m.
        normal: about which an arc turns.
        sweep: rad.
    """

    start: Vector
    end: Vector
    mark: int
    feed: float
    line: int
    tool: int
    center: Vector | None = None
    normal: Vector = (0.0, 0.0, 1.0)
    sweep: float = 0.0

    def way(self, at: Vector) -> Point:
        """Direction (unit) at one of its ends, in the plane XY; an arc there turns about +z."""
        if self.center is None:
            x, y = self.end[0] - self.start[0], self.end[1] - self.start[1]
        else:
            turn = math.copysign(1.0, self.sweep)
            x, y = -turn * (at[1] - self.center[1]), turn * (at[0] - self.center[0])
        length = math.hypot(x, y)
        return x / length, y / length
