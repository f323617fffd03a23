"""MOVARC of APT/CL: an arc or helix with its angle, that ends at the next GOTO, as Fusion 360 writes it.

Counterclockwise about i, j, k (ISO 4343). The post of Fusion 360 from before 2021 wrote the axis of the plane for arcs
of either sense: where the angle fits the end the other way round only, the arc turns so. A half circle fits both ways,
so that such a file is refused at its first one.
"""

from __future__ import annotations

import math

from toolpaths.languages.apt.circle import MOST_TURNS, TURN_SHARE, AptCircle
from toolpaths.languages.apt.words import AptStatement, number, numbers, refusal

_FORM = "x,y,z,i,j,k,r,ANGLE,a"
_REMEDY = "Take the post 'Common ISO 4343 APT' of 2021 or later, or let it output lines for arcs."


class MovedArcs:
    """The arcs of one file, and what they tell about its axes."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.old = False  # spelled as the post of before 2021 does
        self.either: AptStatement | None = None  # the first that fits both ways
        self.against: AptStatement | None = None  # the first that turns against its axis

    def read(self, s: AptStatement, *, fusion: bool) -> AptCircle:
        """The values of MOVARC; in a file of Fusion 360, numbers have a decimal point since 2021.

        Raises:
            ReadError: another form.
        """
        minor = s.minor
        if len(minor) != 9 or minor[7] != "ANGLE" or number(minor[8]) is None:
            raise refusal(self.source, s, f"MOVARC/{_FORM} is expected", "Output CIRCLE or GOTO points.")
        *v, angle = numbers(AptStatement(s.word, ",".join(minor[:7] + minor[8:]), s.line), (8,), self.source)
        if not 0.0 < angle <= 360.0 * MOST_TURNS:
            raise refusal(self.source, s, f"an angle above 0 and up to {MOST_TURNS:g} turns is expected")
        self.old = self.old or (fusion and any("." not in v for v in minor[:7]))
        return AptCircle(
            center=(v[0], v[1], v[2]), axis=(v[3], v[4], v[5]), radius=v[6], clockwise=False, angle=math.radians(angle)
        )

    def note(self, s: AptStatement, arc: AptCircle, sweep: float) -> None:
        """Refuse arcs of either sense where the file's axes are known not to tell it.

        Raises:
            ReadError: names the arc that may go either way.
        """
        if arc.angle is None:
            return
        if abs(math.remainder(arc.angle, math.pi)) <= TURN_SHARE * math.tau:
            self.either = self.either or s
        elif sweep < 0.0:
            self.against = self.against or s
        if self.either and (self.against or self.old):
            why = f"line {self.against.line} turns against its axis" if self.against else "its post told no sense"
            problem = f"which way round is not known: in this file {why}"
            raise refusal(self.source, self.either, problem, _REMEDY)
