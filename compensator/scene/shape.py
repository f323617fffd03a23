"""Shapes of bodies: capsule, cylinder, box and mesh, and the spheres and boxes that hold them; SI."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

MOST_CELLS = 64  # spheres that cover one shape


class Held(NamedTuple):
    """What holds a shape: ``half`` (3,) edges of a box round ``middle`` (3,), grown by ``radius`` on all sides; m."""

    middle: Floats
    half: Floats
    radius: float


@dataclass(frozen=True, eq=False)
class CapsuleShape:
    """All that is nearer than ``radius`` to a piece of the z axis, ``length`` long, its middle at 0."""

    radius: float
    length: float

    @property
    def held(self) -> Held:
        """What holds it."""
        return Held(np.zeros(3), np.array([0.0, 0.0, 0.5 * self.length]), self.radius)

    @cached_property
    def cover(self) -> Floats:
        """(S, 4) middles and radii of spheres that cover it."""
        return _covered(self.held)


@dataclass(frozen=True, eq=False)
class CylinderShape:
    """A cylinder along z, its middle at 0."""

    radius: float
    length: float

    @property
    def held(self) -> Held:
        """What holds it."""
        return Held(np.zeros(3), np.array([self.radius, self.radius, 0.5 * self.length]), 0.0)

    @cached_property
    def cover(self) -> Floats:
        """(S, 4) middles and radii of spheres that cover it."""
        return _covered(self.held)


@dataclass(frozen=True, eq=False)
class BoxShape:
    """A box with edges ``size`` (3,) along x, y, z, its middle at 0."""

    size: Floats

    @property
    def held(self) -> Held:
        """What holds it."""
        return Held(np.zeros(3), 0.5 * self.size, 0.0)

    @cached_property
    def cover(self) -> Floats:
        """(S, 4) middles and radii of spheres that cover it."""
        return _covered(self.held)


@dataclass(frozen=True, eq=False, repr=False)
class MeshShape:
    """Facets ``faces`` (F, 3) of ``vertices`` (V, 3)."""

    vertices: Floats
    faces: Ints

    def __repr__(self) -> str:
        return f"MeshShape({len(self.faces)} facets)"

    @cached_property
    def held(self) -> Held:
        """What holds it."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        return Held(0.5 * (low + high), 0.5 * (high - low), 0.0)

    @cached_property
    def cover(self) -> Floats:
        """(S, 4) middles and radii of spheres that cover it."""
        return _covered(self.held)


Shape3 = CapsuleShape | CylinderShape | BoxShape | MeshShape


def _covered(held: Held) -> Floats:
    """(S, 4) spheres over near-cubes of the box that holds a shape."""
    edge = 2.0 * held.half + 2.0 * held.radius
    long = edge.max()
    parts = np.maximum(np.rint(edge / max(edge.min(), long / 8.0)), 1.0).astype(int)
    while parts.prod() > MOST_CELLS:
        parts[np.argmax(parts)] -= 1
    cell = edge / parts
    axes = [(np.arange(p) + 0.5) * c - 0.5 * e for p, c, e in zip(parts, cell, edge, strict=True)]
    middle = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) + held.middle
    if held.radius > 0.0 and not held.half[:2].any():  # a capsule: spheres on its axis, none at corners
        radius = float(np.hypot(held.radius, 0.5 * cell[2]))
    else:
        radius = 0.5 * float(np.linalg.norm(cell))
    return np.column_stack([middle, np.full(len(middle), radius)])
