"""Cutter: the shape of what cuts, of the shank and of the holder; SI."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import cos, pi, sin, tan

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.profile import (
    BALL,
    BODY,
    COS,
    LENGTH,
    PROFILE_COLUMNS,
    RC,
    SHOULDER,
    SIN,
    E,
    profile_distance,
)
from compensator.process.milling.shape import Shape

Floats = npt.NDArray[np.float64]

@dataclass(frozen=True)
class ToolCylinder:
    """A cylinder of a tool above the cutting edge: ``radius`` and ``length`` in m, ``holder`` or shank."""

    radius: float
    length: float
    holder: bool


@dataclass(frozen=True)
class Cutter:
    """A milling cutter or drill; the TCP is its tip, on the axis.

    Attributes:
        shape: of the outline.
        diameter: m, at the tip of a taper (the arc of its corner or ball included), else of the body.
        flutes: cutting edges.
        length: m of cutting edge from the tip.
        helix: rad.
        corner_radius: m; of a bull and a taper.
        half_angle: rad between the side of a taper and the axis; of a drill half of its point angle.
        runout: m that the middle of the edges is beside the axis of the spindle.
        stack: what is above the edge, from there upwards.
    """

    shape: Shape
    diameter: float
    flutes: int
    length: float
    helix: float = 0.0
    corner_radius: float = 0.0
    half_angle: float = 0.0
    runout: float = 0.0
    stack: tuple[ToolCylinder, ...] = ()

    @property
    def radius(self) -> float:
        """Half of the diameter, m."""
        return 0.5 * self.diameter

    @property
    def arc(self) -> float:
        """Radius of the arc between bottom and side, m."""
        return self.radius if self.shape == "ball" else self.corner_radius

    @property
    def arc_height(self) -> float:
        """Height where the arc, or the point of a drill, ends, m."""
        if self.shape == "drill":
            return self.radius / tan(self.half_angle)
        return self.arc * (1.0 - sin(self.half_angle))

    @property
    def largest_radius(self) -> float:
        """m, of the part that cuts."""
        if self.shape != "taper":
            return self.radius
        at_arc = self.radius - self.arc * (1.0 - cos(self.half_angle))
        return at_arc + (self.length - self.arc_height) * tan(self.half_angle)

    @property
    def lag(self) -> float:
        """rad that the edge is behind its tip, per m up the tool."""
        return tan(self.helix) / self.radius

    @property
    def stick_out(self) -> float:
        """Edge, shank and holder together, m."""
        return self.length + sum(c.length for c in self.stack)

    @cached_property
    def profile(self) -> Floats:
        """Row of numbers for the kernels, see kernels/profile.py."""
        p = np.zeros(PROFILE_COLUMNS)
        drill = self.shape == "drill"
        p[E], p[RC] = (0.0 if drill else self.radius - self.arc), (0.0 if drill else self.arc)
        p[SIN], p[COS] = sin(self.half_angle), cos(self.half_angle)
        p[LENGTH], p[BODY] = self.length, self.largest_radius
        p[SHOULDER] = self.arc_height if drill else self.length
        p[BALL] = self.shape == "ball"
        p.setflags(write=False)
        return p

    @property
    def cylinders(self) -> Floats:
        """(K, 4) lower and upper end (m above the tip), radius, 1 shank or 2 holder."""
        ends = self.length + np.cumsum([0.0, *(c.length for c in self.stack)])
        rows = [(ends[k], ends[k + 1], c.radius, 2.0 if c.holder else 1.0) for k, c in enumerate(self.stack)]
        return np.array(rows).reshape(-1, 4)

    @property
    def tooth_steps(self) -> Floats:
        """(flutes,) m that a tooth stands out further than the one before it; the first one is at the run-out."""
        out = self.runout * np.cos(2.0 * pi * np.arange(self.flutes) / self.flutes)
        return out - np.roll(out, -1)

    def distance(self, rho: Floats, s: Floats) -> Floats:
        """Signed distance to the part that cuts, m, negative inside.

        Args:
            rho: (N,) m from the axis; s: (N,) m up the tool from the tip.
        """
        row, places = self.profile[None], zip(rho, s, strict=True)
        return np.array([profile_distance(row, 0, r, h, longer=0.0).d for r, h in places])
