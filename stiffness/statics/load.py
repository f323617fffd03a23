"""Loads on the links of an arm, and what crosses a place: all that acts outward of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from stiffness.statics.deflected_arm import DeflectedArm


@dataclass(frozen=True)
class Load:
    """A wrench on a link, about a point fixed to it.

    Attributes:
        link: that it acts on: 0 base ... n flange.
        point: (3,) m in the frame of the link, or of ``point_link`` where that is another one.
        wrench: (6,) N and N*m, in base axes, about the point.
    """

    link: int
    point: ca.SX
    wrench: ca.SX
    point_link: int | None = None


def with_loads(
    outward: tuple[ca.SX, ca.SX],
    arm: DeflectedArm,
    link: int,
    *,
    weights: Sequence[tuple[int, ca.SX, ca.SX]],
    loads: Sequence[Load],
) -> tuple[ca.SX, ca.SX]:
    """Force and moment about the base origin of all ``outward`` of a link, and of what acts on the link itself."""
    force, moment = outward
    for on, point, f in weights:
        if on == link:
            force, moment = force + f, moment + ca.cross(arm.links[link].at(point), f)
    for load in loads:
        if load.link == link:
            f = load.wrench[:3]
            moves_with = arm.links[link if load.point_link is None else load.point_link]
            force, moment = force + f, moment + load.wrench[3:] + ca.cross(moves_with.at(load.point), f)
    return force, moment
