"""DeflectedArm: the frames of an arm whose joints and places have given way, in symbols."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class LinkFrame:
    """Rotation (3, 3) and origin (3,) of a frame in the base."""

    rotation: ca.SX
    origin: ca.SX

    def at(self, point: ca.SX) -> ca.SX:
        """A point of the frame, in the base."""
        return self.origin + ca.mtimes(self.rotation, point)

    def then(self, rotation: ca.SX, origin: ca.SX) -> LinkFrame:
        """The frame that stands at (rotation, origin) in this one."""
        return LinkFrame(ca.mtimes(self.rotation, rotation), self.at(origin))


@dataclass(frozen=True)
class DeflectedArm:
    """Frames of a deflected arm: ``links`` 0..n, ``joints`` before their rotation, ``places`` as if they did not yield.

    ``angles`` (n,) rad are those of the links, ``displacements`` [d; phi] those of the places that yield, ``axes``
    (3,) directions of the joints in the base.
    """

    angles: ca.SX
    displacements: Mapping[int, ca.SX]
    links: tuple[LinkFrame, ...]
    joints: tuple[LinkFrame, ...]
    axes: tuple[ca.SX, ...]
    places: tuple[LinkFrame, ...]
