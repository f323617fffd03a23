"""Coordinate systems that a CAM file names, and the way from one to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpaths.frame import Vector
from toolpaths.toolpath import Floats

TOLERANCE = 1e-3  # how far given axes may be from unit length and from right angles


@dataclass(frozen=True, repr=False)
class Frame:
    """Pose of one coordinate system in another: (3, 3) rotation, (3,) origin in the file's length unit."""

    rotation: Floats
    origin: Floats

    def point(self, p: Vector) -> Vector:
        """A place given in the inner system, in the outer one."""
        x, y, z = (self.rotation @ p + self.origin).tolist()
        return x, y, z

    def vector(self, v: Vector) -> Vector:
        """A direction given in the inner system, in the outer one."""
        x, y, z = (self.rotation @ v).tolist()
        return x, y, z

    def inverse(self) -> Frame:
        """The outer system in the inner one."""
        return Frame(self.rotation.T, -self.rotation.T @ self.origin)

    def times(self, inner: Frame) -> Frame:
        """The system ``inner``, given in this one, in the outer one."""
        return Frame(self.rotation @ inner.rotation, self.rotation @ inner.origin + self.origin)

    def same(self, other: Frame) -> bool:
        """Whether both are the same to the digits that files carry."""
        near = np.allclose(self.origin, other.origin, rtol=0, atol=1e-9)
        return near and np.allclose(self.rotation, other.rotation, rtol=0, atol=1e-12)


def frame_from_msys(values: list[float]) -> Frame:
    """The frame of origin, x axis and y axis, 9 numbers.

    Raises:
        ValueError: the axes are not of unit length or not at right angles.
    """
    origin, x, y = np.array(values).reshape(3, 3)
    lengths = np.linalg.norm([x, y], axis=1)
    if not np.all(np.abs(lengths - 1.0) <= TOLERANCE) or not abs(np.dot(x, y)) <= TOLERANCE:
        raise ValueError(f"axes of length {lengths[0]:.6g} and {lengths[1]:.6g}, or not at right angles")
    x = x / lengths[0]
    z = np.cross(x, y)
    z /= np.linalg.norm(z)
    return Frame(np.column_stack([x, np.cross(z, x), z]), origin)
