"""Arcs of SINUMERIK programs: by centre, radius or opening angle, through a point, tangential, with whole turns.

Source: NC programming, Fundamentals, circular interpolation; alarm 14040 (ends that miss the circle: by MD21000, 0.01
mm, or MD21010, 0.1 % of the radius, as delivered).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from toolpaths.frame import Vector
from toolpaths.interpreting.arcs import circle_through
from toolpaths.languages.siemens.block import Given
from toolpaths.reading.cnc_motion import CncArc
from toolpaths.reading.plane_arc import RadiusTolerance, centre_of_radius, in_plane, radii, sweep_about, tangent_arc

TOLERANCE = RadiusTolerance(1e-5, 1e-3, math.inf)
MOST_TURNS = 999
_CENTRES = ("I", "J", "K")


class ArcStart(NamedTuple):
    """Where an arc starts.

    Attributes:
        at: the tool, m in the frame in force.
        normal: 0, 1, 2: the axis at right angles to the plane.
        pole: of polar words, m in the plane.
        motion: 2 and 3 (G2, G3), CIP or CT.
        relative: G91.
        heading: in which the last move arrived in the plane of CT; None: in none.
    """

    at: Vector
    normal: int
    pole: tuple[float, float]
    motion: int | str | None
    relative: bool
    heading: tuple[float, float] | None


class SiemensArc:
    """An arc of one block.

    Args:
        tool: where it starts.
        values: of the block.
        unit: m of a length.
        end: where the words of the block lead, m.

    Attributes:
        end: of the arc; with an opening angle and a centre it follows from them.
    """

    def __init__(self, tool: ArcStart, values: Mapping[str, Given], unit: float, end: Vector) -> None:
        self.values, self.unit, self.end = values, unit, end
        self.start, self.normal, self.pole = tool.at, tool.normal, tool.pole
        self.motion, self._heading = tool.motion, tool.heading
        self.clockwise, self._mode = tool.motion == 2, "IC" if tool.relative else "AC"

    def found(self) -> CncArc | None:
        """Centre and sweep; None: it is straight.

        Raises:
            ValueError: the words do not make an arc.
        """
        if any(v != v for v in self.start):
            unknown = "".join(c for c, v in zip("XYZ", self.start, strict=True) if v != v)
            raise ValueError(
                f"an arc, but where it starts is not known ({unknown})", "Name X, Y and Z in G0 or G1 first."
            )
        try:
            if self.motion == "CIP":
                return self._through()
            if self.motion == "CT":
                return self._tangential()
            return self._turned()
        except ValueError as problem:
            raise ValueError(str(problem.args[0]), "Check the arc, or post lines instead.") from None

    def length(self, arc: CncArc | None) -> float:
        """m along the arc, or to its end."""
        if arc is None:
            return math.dist(self.start, self.end)
        axis = np.array(arc.axis if arc.axis else np.eye(3)[arc.normal])
        out, way = np.array(self.start) - arc.center, np.array(self.end) - np.array(self.start)
        rise = float(way @ axis)
        return math.hypot(float(np.linalg.norm(out - (out @ axis) * axis)) * arc.sweep, rise)

    def _turned(self) -> CncArc:
        """G2 and G3."""
        values, start = self.values, self.start
        named = [name for name in _CENTRES if name in values]
        if len([1 for given in (named, "CR" in values, "AR" in values and not named) if given]) > 1:
            raise ValueError("an arc by more than one of I J K, CR and AR")
        if named:
            center = self._centre(named)
            if "AR" in values:
                self._turn_end(center)
        elif "CR" in values:
            radius, least = self._plain("CR") * self.unit, TOLERANCE.least
            center = centre_of_radius(radius, start, self.end, self.normal, clockwise=self.clockwise, tolerance=least)
        elif "AR" in values:
            center = self._centre_of_angle()
        elif "AP" in values or "RP" in values:
            center = self.pole
        else:
            raise ValueError("an arc without centre (I, J, K), radius CR or opening angle AR")
        TOLERANCE.check(*radii(start, self.end, center, self.normal))
        sweep = sweep_about(center, start, self.end, self.normal, clockwise=self.clockwise)
        turns = self._plain("TURN")
        if turns != int(turns) or not 0 <= turns <= MOST_TURNS:
            raise ValueError(f"TURN={turns:g}: a whole number of turns up to {MOST_TURNS} is expected")
        sweep += math.copysign(turns * math.tau, sweep)
        return CncArc(in_plane(start, center, self.normal), self.normal, sweep)

    def _centre(self, named: list[str]) -> tuple[float, float]:
        if _CENTRES[self.normal] in named:
            raise ValueError(f"{_CENTRES[self.normal]} is no centre word of the plane G{19 - self.normal}")
        center = []
        for k in ((self.normal + 1) % 3, (self.normal + 2) % 3):
            given = self.values.get(_CENTRES[k], 0.0)
            mode, value = given if isinstance(given, tuple) else ("IC", given)
            if mode not in ("AC", "IC") or isinstance(value, str):
                raise ValueError(f"{_CENTRES[k]}={mode}(...): AC or IC is expected")
            center.append(value * self.unit + (self.start[k] if mode == "IC" else 0.0))
        return center[0], center[1]

    def _turn_end(self, center: tuple[float, float]) -> None:
        """An opening angle with a centre: the end follows."""
        u, v = (self.normal + 1) % 3, (self.normal + 2) % 3
        if "XYZ"[u] in self.values or "XYZ"[v] in self.values:
            raise ValueError("an arc by its opening angle AR, its centre and its end")
        angle = -self._opening() if self.clockwise else self._opening()
        du, dv = self.start[u] - center[0], self.start[v] - center[1]
        c, s = math.cos(angle), math.sin(angle)
        self.end = in_plane(self.end, (center[0] + c * du - s * dv, center[1] + s * du + c * dv), self.normal)

    def _centre_of_angle(self) -> tuple[float, float]:
        """An opening angle with an end: the centre follows."""
        angle = self._opening()
        u, v = (self.normal + 1) % 3, (self.normal + 2) % 3
        half = math.hypot(self.end[u] - self.start[u], self.end[v] - self.start[v]) / 2
        radius = math.copysign(half / math.sin(angle / 2), math.pi - angle)
        return centre_of_radius(radius, self.start, self.end, self.normal, clockwise=self.clockwise, tolerance=1e-9)

    def _opening(self) -> float:
        angle = self._plain("AR")
        if not 0 < angle < 360:
            raise ValueError(f"AR={angle:g}: an opening angle above 0 and below 360 is expected")
        return math.radians(angle)

    def _through(self) -> CncArc:
        """CIP: by way of a point."""
        if "TURN" in self.values:
            raise ValueError("CIP with TURN")
        via = []
        for k, name in enumerate(("I1", "J1", "K1")):
            given = self.values.get(name, self.start[k] / self.unit)
            mode, value = given if isinstance(given, tuple) else (self._mode if name in self.values else "AC", given)
            if mode not in ("AC", "IC") or isinstance(value, str):
                raise ValueError(f"{name}={mode}(...): AC or IC is expected")
            via.append(value * self.unit + (self.start[k] if mode == "IC" else 0.0))
        points = [np.array([p]) for p in (self.start, via, self.end)]
        center, axis, sweep, _, flat = circle_through(points[0], points[1], points[2])
        if flat[0]:
            raise ValueError("CIP: start, intermediate point and end are on one line")
        (x, y, z), (i, j, k_) = center[0].tolist(), axis[0].tolist()
        return CncArc((x, y, z), -1, float(sweep[0]), (i, j, k_))

    def _tangential(self) -> CncArc | None:
        """CT: in the direction in which the last move arrived."""
        if "TURN" in self.values:
            raise ValueError("CT with TURN")
        heading = self._heading
        if heading is None:
            raise ValueError("CT, but no move in the plane before it has a direction")
        if (found := tangent_arc(self.start, self.end, heading, self.normal)) is None:
            return None
        return CncArc(in_plane(self.start, found[0], self.normal), self.normal, found[1])

    def _plain(self, name: str) -> float:
        value = self.values.get(name, 0.0)
        if not isinstance(value, float):
            raise ValueError(f"{name}: a plain number is expected")
        return value
