"""KlartextMotion: where the blocks of a Klartext program move the tool: L, LN, LP, C, CP, CR, CT, RND, CHF.

Source: iTNC 530 and TNC 620 conversational programming, path functions; ends of an arc may miss it by 0.016 mm
(machine parameter circleDeviation).
"""

from __future__ import annotations

import math

from toolpaths.frame import Vector
from toolpaths.languages.heidenhain.block import KlartextBlock
from toolpaths.languages.heidenhain.planes import KlartextFrames, spatial
from toolpaths.machine import Machine
from toolpaths.reading.cnc_feed import PER_TURN, CncFeed
from toolpaths.reading.cnc_motion import CHAMFER, ROUND, CncArc, CncMotion, Corner
from toolpaths.reading.plane_arc import RadiusTolerance, centre_of_radius, in_plane, radii, sweep_about, tangent_arc
from toolpaths.reading.track import CUT_MARK, RAPID_MARK

MM, INCH = 1e-3, 25.4e-3
TIP_WORD = "M128", "M128 and LN with TX TY TZ"
TOLERANCE = RadiusTolerance(16e-6, 0.0, 16e-6)
MOST_TURNS = 100
PLACES = frozenset(("X", "Y", "Z", "IX", "IY", "IZ"))
ROTARY = frozenset(("A", "B", "C", "IA", "IB", "IC"))
POLAR = frozenset(("PR", "PA", "IPR", "IPA"))
SAME_ANGLE = 1e-9  # rad


class KlartextMotion(CncMotion):
    """The tool of one file.

    Attributes:
        unit: m of a length.
        pole: of CC, m in the plane ``pole_normal`` of the frame in force.
        spatial_angles: FUNCTION TCPM AXIS SPAT: A, B, C are spatial angles.
        plunge: share of the feed along the tool axis into the work, of M103.
    """

    def __init__(self, source: str, machine: Machine | None) -> None:
        super().__init__(source, "heidenhain", machine, TIP_WORD)
        self.unit = MM
        self.feed = CncFeed()
        self.frames = KlartextFrames(machine.systems if machine else {})
        self.pole: tuple[float, float] | None = None
        self.pole_normal = 2
        self.spatial_angles = self.shortest = False
        self.plunge: float | None = None
        self.tool_feed = math.nan  # of TOOL CALL
        self._spatial = dict.fromkeys("ABC", 0.0)

    @property
    def feed_unit(self) -> float:
        """m of the length in F: mm, in programs in inch 0.1 inch."""
        return self.unit if self.unit == MM or self.feed.mode == PER_TURN else self.unit / 10.0

    def rate(self, block: KlartextBlock) -> float:
        """m/s of the block; NaN: rapid."""
        if block.feed == "MAX":
            return math.nan
        if block.feed == "AUTO":
            if not self.tool_feed > 0:
                raise ValueError("F AUTO, but TOOL CALL gives no feed", "Write F with a number.")
            self.feed.give(self.tool_feed)
        elif isinstance(block.feed, float):
            self.feed.give(block.feed)
        return self.feed.rate(self.feed_unit)

    def line_to(self, block: KlartextBlock, line: int) -> None:
        """L and LN."""
        places = not PLACES.isdisjoint(block.values)
        vector = {"TX", "TY", "TZ"} & block.values.keys()
        turned = [*(ROTARY & block.values.keys()), *block.unknown]
        before = self.rotary.angles
        if turned:
            self._turn(block, alone=not places)
        if vector:
            self._point(block)
        if not (places or vector or turned):
            if block.feed is not None:
                self.rate(block)
            return
        end = self._end(block)
        feed = self.rate(block)
        if turned and not places and not self.rotary.used and not self.vectors:
            if feed == feed:
                raise ValueError(
                    "rotary axes turn at a feed, and the machine is not known", "Declare [machine] in the cell."
                )
            self.track.event(self.text, line)
            return
        rapid = feed != feed
        if self.plunge is not None and not rapid:
            feed = self._plunging(feed, end)
        time = self.turning_time(feed, math.dist(self.at, end), before, self.feed.word) if turned else math.nan
        self.go(RAPID_MARK if rapid else CUT_MARK, end, feed, line, time=time)

    def polar_line(self, block: KlartextBlock, line: int) -> None:
        """LP."""
        end, feed = self._polar_end(block), self.rate(block)
        self.go(RAPID_MARK if feed != feed else CUT_MARK, end, feed, line)

    def set_pole(self, block: KlartextBlock) -> None:
        """CC: the centre of circles, and the pole; two of X, Y, Z give its plane, none takes where the tool is."""
        named = {name[-1] for name in block.values}
        if len(named) > 2 or not named <= set("XYZ"):
            raise ValueError("CC with two of X, Y, Z is expected")
        if len(named) == 2:
            normal = next(k for k in range(3) if "XYZ"[k] not in named)
            old = self.pole if normal == self.pole_normal else None
            self.pole_normal = normal
        else:
            self.pole_normal, old = (self.pole_normal if named else self.normal), self.pole
        place = []
        for n, k in enumerate(((self.pole_normal + 1) % 3, (self.pole_normal + 2) % 3)):
            given = self._coordinate(block, k)
            if given is None and named:
                given = old[n] if old else None
            place.append(self.at[k] if given is None else given)
        if any(v != v for v in place):
            raise ValueError("CC, but where the tool is, is not known")
        self.pole = place[0], place[1]

    def circle(self, block: KlartextBlock, line: int) -> None:
        """C: about the pole, to the end named."""
        center, normal = self._center(), self.pole_normal
        self._sweep(CncArc(center, normal, 0.0), self._end(block), block, line)

    def polar_circle(self, block: KlartextBlock, line: int) -> None:
        """CP: about the pole, to an angle or by one; with the third axis a helix."""
        center, normal = self._center(), self.pole_normal
        if {"PR", "IPR"} & block.values.keys() or not {"PA", "IPA"} & block.values.keys():
            raise ValueError("CP with PA or IPA is expected, without PR")
        end = self._polar_end(block)
        if "IPA" not in block.values:
            self._sweep(CncArc(center, normal, 0.0), end, block, line)
            return
        angle = block.values["IPA"]
        if not 0 < abs(angle) <= MOST_TURNS * 360.0:
            raise ValueError(f"CP IPA{angle:+g}: an angle up to {MOST_TURNS} turns is expected")
        if block.turn and block.turn != (1 if angle > 0 else -1):
            raise ValueError(f"CP IPA{angle:+g} with DR{'+' if block.turn > 0 else '-'}: both signs have to agree")
        self.sweep(CncArc(center, normal, math.radians(angle)), end, self._cut(block), line)

    def circle_by_radius(self, block: KlartextBlock, line: int) -> None:
        """CR."""
        end, radius = self._in_tool_plane(block, "CR"), block.values.get("R", 0.0) * self.unit
        if not radius:
            raise ValueError("CR without a radius R")
        center = centre_of_radius(
            radius, self.at, end, self.normal, clockwise=self._clockwise(block), tolerance=TOLERANCE.least
        )
        arc = CncArc(in_plane(self.at, center, self.normal), self.normal, 0.0)
        self._sweep(arc, end, block, line, checked=True)

    def tangential(self, block: KlartextBlock, line: int, *, polar: bool) -> None:
        """CT and CTP: in the direction in which the last move arrived."""
        end = self._polar_end(block) if polar else self._in_tool_plane(block, "CT")
        normal = self.pole_normal if polar else self.normal
        heading = self.heading(normal)
        if heading is None:
            raise ValueError("CT, but no move in the plane before it has a direction")
        feed = self._cut(block)
        if (found := tangent_arc(self.at, end, heading, normal)) is None:
            self.go(CUT_MARK, end, feed, line)
        else:
            self.sweep(CncArc(in_plane(self.at, found[0], normal), normal, found[1]), end, feed, line)

    def corner_between(self, kind: str, size: float, block: KlartextBlock, line: int) -> None:
        """RND and CHF; their F counts in them only."""
        before = self.feed.word
        feed = self._cut(block)
        self.feed.give(before)
        self.put_corner(Corner({"RND": ROUND, "CHF": CHAMFER}[kind], size * self.unit, feed, line))

    # Words

    def _sweep(
        self, arc: CncArc, end: Vector, block: KlartextBlock, line: int, *, checked: bool = False
    ) -> None:
        u, v = (arc.normal + 1) % 3, (arc.normal + 2) % 3
        center = arc.center[u], arc.center[v]
        if any(a != a for a in (*self.at, *end)):
            raise ValueError("an arc, but where it starts is not known", "Name X, Y and Z in a line first.")
        if not checked:
            TOLERANCE.check(*radii(self.at, end, center, arc.normal))
        sweep = sweep_about(center, self.at, end, arc.normal, clockwise=self._clockwise(block))
        self.sweep(arc._replace(sweep=sweep), end, self._cut(block), line)

    def _cut(self, block: KlartextBlock) -> float:
        feed = self.rate(block)
        if feed != feed:
            raise ValueError("an arc or corner at rapid (FMAX)", "Write F with a number.")
        return feed

    def _clockwise(self, block: KlartextBlock) -> bool:
        if not block.turn:
            raise ValueError("an arc without its sense DR+ or DR-")
        return block.turn < 0

    def _center(self) -> Vector:
        if self.pole is None:
            raise ValueError("no CC before it names the centre")
        return in_plane(self.at, self.pole, self.pole_normal)

    def _coordinate(self, block: KlartextBlock, k: int) -> float | None:
        """m along an axis, absolute or from where the tool is; None: it is not named."""
        letter = "XYZ"[k]
        if letter in block.values:
            if f"I{letter}" in block.values:
                raise ValueError(f"{letter} and I{letter} in one block")
            return block.values[letter] * self.unit
        if f"I{letter}" not in block.values:
            return None
        if self.at[k] != self.at[k]:
            raise ValueError(f"I{letter}, but where {letter} is, is not known", f"Move there with {letter} first.")
        return self.at[k] + block.values[f"I{letter}"] * self.unit

    def _end(self, block: KlartextBlock) -> Vector:
        x, y, z = (at if (v := self._coordinate(block, k)) is None else v for k, at in enumerate(self.at))
        return x, y, z

    def _in_tool_plane(self, block: KlartextBlock, name: str) -> Vector:
        if "XYZ"[self.normal] in block.values or f"I{'XYZ'[self.normal]}" in block.values:
            raise ValueError(f"{name} with {'XYZ'[self.normal]}: an arc out of the plane of the tool", "Post C or CP.")
        if any(v != v for v in self.at):
            raise ValueError("an arc, but where it starts is not known", "Name X, Y and Z in a line first.")
        return self._end(block)

    def _polar_end(self, block: KlartextBlock) -> Vector:
        """By PR and PA about the pole; what is not named stays as it is."""
        if self.pole is None:
            raise ValueError("polar coordinates, but no CC before them names the pole")
        u, v = (self.pole_normal + 1) % 3, (self.pole_normal + 2) % 3
        if PLACES & block.values.keys() - {"XYZ"[self.pole_normal], f"I{'XYZ'[self.pole_normal]}"}:
            raise ValueError("polar coordinates and X, Y or Z of their plane in one block")
        du, dv = self.at[u] - self.pole[0], self.at[v] - self.pole[1]
        radius, angle = math.hypot(du, dv), math.degrees(math.atan2(dv, du))
        given = block.values
        radius = given["PR"] * self.unit if "PR" in given else radius + given.get("IPR", 0.0) * self.unit
        angle = given["PA"] if "PA" in given else angle + given.get("IPA", 0.0)
        if radius != radius or angle != angle:
            raise ValueError("polar coordinates, but where the tool is, is not known", "Name both PR and PA.")
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        place = self.pole[0] + radius * c, self.pole[1] + radius * s
        return in_plane(self._end(block), place, self.pole_normal)

    def _plunging(self, feed: float, end: Vector) -> float:
        """M103: the speed along the tool axis into the work is at most its share of the feed."""
        way, down = math.dist(self.at, end), self.at[2] - end[2]
        if not (way > 0 and down > 0) or self.plunge is None:
            return feed
        return min(feed, feed * self.plunge * way / down)

    def _turn(self, block: KlartextBlock, *, alone: bool) -> None:
        """A, B, C."""
        angles = dict.fromkeys((name[-1] for name in block.unknown), math.nan)
        for name in [name for name in block.values if name in ROTARY]:
            at = self._spatial[name[-1]] if self.spatial_angles else self._turned.get(name[-1], math.nan)
            value = block.values[name] + (at if len(name) > 1 else 0.0)
            if value != value:
                raise ValueError(f"{name}, but where the axis is, is not known")
            if self.shortest and len(name) == 1 and at == at and not self.spatial_angles:
                value = at + (value - at + 180.0) % 360.0 - 180.0
            angles[name[-1]] = value
        if self.spatial_angles and self.tip:
            if block.unknown:
                raise ValueError("spatial angles that only the control knows")
            self._spatial |= angles
            self.point(spatial(self._spatial).z)
        else:
            self.turn_axes(angles, alone=alone)

    def _point(self, block: KlartextBlock) -> None:
        """TX, TY, TZ: from the tip to the spindle."""
        if not self.tip:
            raise ValueError("a tool vector (TX TY TZ) without M128 or FUNCTION TCPM")
        if self.swivelled:
            raise ValueError("a tool vector in a tilted plane", "Write PLANE RESET before M128.")
        i, j, k = (block.values.get(c, 0.0) for c in ("TX", "TY", "TZ"))
        self.point((i, j, k))
