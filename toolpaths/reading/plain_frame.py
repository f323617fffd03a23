"""PlainFrame: a frame in plain numbers, for readers that place one point a line: arrays of three take far longer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from toolpaths.frame import Vector

Rows = tuple[Vector, Vector, Vector]
NOWHERE: Vector = (0.0, 0.0, 0.0)
UPRIGHT: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
SAME = 1e-9


@dataclass(frozen=True, slots=True)
class PlainFrame:
    """An inner frame in an outer one: p_outer = rotation p_inner + origin.

    Attributes:
        origin: m.
        rows: of the rotation; None: there is none.
    """

    origin: Vector = NOWHERE
    rows: Rows | None = None

    @classmethod
    def turned(cls, angles: Sequence[tuple[int, float]]) -> PlainFrame:
        """Rotations one after the other, each about an axis (0, 1, 2) of the frame that the ones before made, rad."""
        out = cls()
        for axis, angle in angles:
            if angle:
                out = out.then(cls(NOWHERE, _about(axis, angle)))
        return out

    @property
    def z(self) -> Vector:
        """Its z axis, in the outer frame."""
        return self.along((0.0, 0.0, 1.0))

    def out(self, p: Vector) -> Vector:
        """A point of the inner frame, in the outer one."""
        o = self.origin
        if self.rows is None:
            return p if o is NOWHERE else (p[0] + o[0], p[1] + o[1], p[2] + o[2])
        x, y, z = p
        a, b, c = self.rows
        return (
            a[0] * x + a[1] * y + a[2] * z + o[0],
            b[0] * x + b[1] * y + b[2] * z + o[1],
            c[0] * x + c[1] * y + c[2] * z + o[2],
        )

    def along(self, d: Vector) -> Vector:
        """A direction of the inner frame, in the outer one."""
        if self.rows is None:
            return d
        x, y, z = d
        a, b, c = self.rows
        return (
            a[0] * x + a[1] * y + a[2] * z,
            b[0] * x + b[1] * y + b[2] * z,
            c[0] * x + c[1] * y + c[2] * z,
        )

    def inward(self, p: Vector) -> Vector:
        """A point of the outer frame, in the inner one."""
        o = self.origin
        x, y, z = p[0] - o[0], p[1] - o[1], p[2] - o[2]
        if self.rows is None:
            return x, y, z
        a, b, c = self.rows
        return (
            a[0] * x + b[0] * y + c[0] * z,
            a[1] * x + b[1] * y + c[1] * z,
            a[2] * x + b[2] * y + c[2] * z,
        )

    def then(self, inner: PlainFrame) -> PlainFrame:
        """A frame that is given in this one, in the outer one."""
        origin = self.out(inner.origin)
        if inner.rows is None or self.rows is None:
            return PlainFrame(origin, self.rows or inner.rows)
        x, y, z = (self.along(column) for column in zip(*inner.rows, strict=True))
        return PlainFrame(origin, ((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])))

    def turns_as(self, other: PlainFrame) -> bool:
        """Whether both have the same rotation."""
        mine, theirs = self.rows or UPRIGHT, other.rows or UPRIGHT
        return all(abs(a - b) <= SAME for m, t in zip(mine, theirs, strict=True) for a, b in zip(m, t, strict=True))


def _about(axis: int, angle: float) -> Rows:
    """The rotation about x, y or z."""
    c, s = _cosine(angle), _cosine(angle - math.pi / 2)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    rows = [[0.0, 0.0, 0.0] for _ in range(3)]
    rows[axis][axis] = 1.0
    rows[u][u] = rows[v][v] = c
    rows[u][v], rows[v][u] = -s, s
    a, b, d = ((row[0], row[1], row[2]) for row in rows)
    return a, b, d


def _cosine(angle: float) -> float:
    """Exact at quarter turns, as programs have them."""
    quarters = angle / (math.pi / 2)
    whole = round(quarters)
    return (1.0, 0.0, -1.0, 0.0)[whole % 4] if abs(quarters - whole) < 1e-12 else math.cos(angle)
