"""Tool number, cutter and cutter compensation of an APT/CL file.

The numbers of a CL file are places of the cutter, not of the part's outline: CUTCOM asks the control for the small
difference between the cutter that CAM knew and the one in the spindle. In the SolidWorks CAM files that the tests
read, the path under CUTCOM keeps one tool radius from the wall of the part's mesh; in the NX file, its lead-in arcs
have the tool's radius, which no control could run if they were outlines.
"""

from __future__ import annotations

from toolpaths.languages.apt.words import CREO, AptStatement, number, refusal

_SIDES = {"LEFT", "RIGHT", "ON"}
_MORE = {"XYPLAN", "YZPLAN", "ZXPLAN", "ADJUST", "NOW", "NEXT"}  # plane, register: for the control only
_PROFILE = "OUTPUT_ON_PROFILE"  # what Creo writes in a comment for an outline


class AptTool:
    """The tool in use."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.number = 0
        self.diameter: float | None = None  # file units, from the last CUTTER or TLDATA
        self.profile = False

    def load(self, s: AptStatement) -> None:
        """LOAD/TOOL,n, LOADTL/n or TOOLNO/n."""
        minor = s.minor[1:] if s.word == "LOAD" and s.minor[:1] == ["TOOL"] else s.minor
        value = number(minor[0]) if minor and (s.word != "LOAD" or s.minor[0] == "TOOL") else None
        if value is None or not 0 <= value < 1e9 or value != int(value):
            raise refusal(self.source, s, "a tool number is expected", "Write LOAD/TOOL,n or LOADTL/n.")
        self.number = int(value)

    def cutter(self, s: AptStatement) -> None:
        """CUTTER/d,... or TLDATA/kind,d,...: the first number is the diameter."""
        self.diameter = next((v for v in map(number, s.minor) if v is not None), None)

    def comment(self, s: AptStatement) -> None:
        """What Creo writes as a comment: ``$$-> CUTTER / 10.0``, ``$$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_PROFILE``."""
        if not s.text.startswith(CREO):
            return
        word, _, rest = s.text[2:].partition("/")
        if word.strip().upper() == "CUTTER":
            self.cutter(AptStatement("CUTTER", rest, s.line))
        elif word.strip().upper() == "CUTCOM_GEOMETRY_TYPE":
            self.profile = rest.strip().upper() == _PROFILE

    def compensation(self, s: AptStatement) -> None:
        """CUTCOM/OFF, or LEFT, RIGHT, ON where the numbers are places of the cutter."""
        side, more = (s.minor or [""])[0], s.minor[1:]
        if side != "OFF" and side not in _SIDES:
            raise refusal(self.source, s, "cutter compensation: LEFT, RIGHT, ON or OFF is expected")
        if any(m not in _MORE and number(m) is None for m in more):
            raise refusal(self.source, s, f"cutter compensation: only {', '.join(sorted(_MORE))} may follow")
        if side == "OFF":
            return
        if self.profile or not (self.diameter or 0.0) > 0.0:
            given = "is not in the file" if self.diameter is None else f"has diameter {self.diameter:g}"
            why = f"it is on, and CUTCOM_GEOMETRY_TYPE says {_PROFILE}" if self.profile else f"and the cutter {given}"
            problem = f"cutter compensation, {why}: the path may be the part's outline, not the cutter's"
            raise refusal(self.source, s, problem, "Output the path of the cutter's centre.")
