"""Frame: where a coordinate system stands in another one; one, or one per pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Vector = tuple[float, float, float]  # plain numbers, where there is one place a line and arrays take too long


@dataclass(frozen=True, repr=False, eq=False)
class Frame:
    """Rotation (..., 3, 3) and origin (..., 3) of an inner frame in an outer one: p_outer = rotation p_inner + origin.

    Leading axes broadcast against each other, so that one work object meets N poses.
    """

    rotation: Floats
    origin: Floats

    def __repr__(self) -> str:
        count = self.origin.shape[:-1]
        return f"Frame({'x'.join(map(str, count)) + ' poses' if count else np.round(self.origin, 6).tolist()})"

    @classmethod
    def identity(cls) -> Frame:
        """The outer frame itself."""
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def of(cls, matrix: Floats) -> Frame:
        """From homogeneous matrices (..., 4, 4)."""
        return cls(matrix[..., :3, :3], matrix[..., :3, 3])

    @property
    def matrix(self) -> Floats:
        """(..., 4, 4) homogeneous."""
        out = np.zeros((*self.origin.shape[:-1], 4, 4))
        out[..., :3, :3], out[..., :3, 3], out[..., 3, 3] = self.rotation, self.origin, 1.0
        return out

    def at(self, point: Floats) -> Floats:
        """Points (..., 3) of the inner frame, in the outer one."""
        return self.along(point) + self.origin

    def along(self, direction: Floats) -> Floats:
        """Directions (..., 3) of the inner frame, in the outer one."""
        if self.rotation.ndim == 2:
            return np.asarray(direction @ self.rotation.T)
        return np.asarray(np.einsum("...ij,...j->...i", self.rotation, direction))

    def inward(self, point: Floats) -> Floats:
        """Points (..., 3) of the outer frame, in the inner one."""
        out = np.asarray(point - self.origin)
        return out @ self.rotation if self.rotation.ndim == 2 else np.einsum("...ji,...j->...i", self.rotation, out)

    def then(self, inner: Frame) -> Frame:
        """A frame that is given in this one, in the outer one."""
        return Frame(self.rotation @ inner.rotation, self.at(inner.origin))

    def inverse(self) -> Frame:
        """The outer frame in the inner one."""
        back = np.swapaxes(self.rotation, -1, -2)
        return Frame(back, -Frame(back, self.origin).along(self.origin))

    def relative_to(self, other: Frame) -> Frame:
        """This frame in another one; both are given in the same outer one."""
        return Frame(np.swapaxes(other.rotation, -1, -2) @ self.rotation, other.inward(self.origin))

    @property
    def count(self) -> int:
        """How many there are, of N frames."""
        return len(self.origin)

    @property
    def z(self) -> Floats:
        """(..., 3) the z axes of the inner frames."""
        return self.rotation[..., 2]

    def mapped(self, change: Callable[[Frame, npt.NDArray[np.intp]], Frame]) -> Frame:
        """Other N frames, one of each; ``change``: K frames and their rows (K,) -> K frames."""
        return change(self, np.arange(self.count))

    def turned(self, by: Callable[[npt.NDArray[np.intp]], Floats]) -> Frame:
        """N frames at the same origins, turned about their own axes; ``by``: rows (K,) -> (3, 3) or (K, 3, 3)."""
        return Frame(self.rotation @ by(np.arange(self.count)), self.origin)

    def at_origins(self, origin: Floats) -> Frame:
        """N frames turned like these, at origins (N, 3)."""
        return Frame(self.rotation, origin)

    def take(self, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_] | slice | int) -> Frame:
        """Some of N frames, or one."""
        return Frame(self.rotation[rows], self.origin[rows])
