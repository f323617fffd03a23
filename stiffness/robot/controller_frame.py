"""Frames of a URDF that a controller measures from: tools from its flange, positions from its base."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_ALONG = 1e-3  # rad between z and the axis: URDFs round their angles


@dataclass(frozen=True)
class ControllerFrame:
    """A frame of a URDF that controllers measure from, as seen from the link that was taken by default.

    Attributes:
        name: of the link. distance: m. angle: rad.
        on_axis: its z is along the axis of the joint beside it, as that of a controller's frame.
        mount: roll, pitch, yaw, deg, of a base in the root of the URDF where its z is not along that of the root.
    """

    name: str
    distance: float
    angle: float
    on_axis: bool
    mount: tuple[float, float, float] | None = None

    @property
    def away(self) -> bool:
        """Whether it is not the link that was taken under another name."""
        return self.distance > 1e-5 or self.angle > 1e-4

    def __str__(self) -> str:
        return f"{self.name!r} stands {self.distance * 1e3:.4g} mm away, turned by {math.degrees(self.angle):.4g} deg"


def frame_at(name: str, pose: Floats, axis: Floats) -> ControllerFrame:
    """A frame by its pose (4, 4), m, in the link that was taken, and the axis (3,) of the joint beside it there."""
    return ControllerFrame(name, float(np.linalg.norm(pose[:3, 3])), _angle(pose), along(pose, axis))


def named(name: str, *plain: str) -> bool:
    """Whether a link has one of these names, with or without a prefix."""
    return any(name == p or name.endswith(f"_{p}") for p in plain)


def along(pose: Floats, axis: Floats) -> bool:
    """Whether z of a pose (4, 4) is along an axis (3,), in either sense."""
    return float(np.linalg.norm(np.cross(pose[:3, 2], axis))) < _ALONG


def _angle(pose: Floats) -> float:
    turn = pose[:3, :3]
    twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return float(np.arctan2(np.linalg.norm(twice), np.trace(turn) - 1.0))
