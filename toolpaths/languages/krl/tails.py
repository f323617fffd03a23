"""What stands behind the target of a KRL motion line: speed, rounding, tool and base."""

from __future__ import annotations

import math
import re

from toolpaths.interpreting.program_text import Statement
from toolpaths.interpreting.values import ExpressionError
from toolpaths.languages.krl.expressions import Value
from toolpaths.languages.krl.frames import MountedFrames
from toolpaths.languages.krl.names import KrlNames
from toolpaths.languages.krl.program import KrlProgram

#: #BASE or #TOOL at the end of a relative move.
SYSTEM = re.compile(r"(?<!\s)\s*+#(?:BASE|TOOL)\s*+$", re.I)
FASTEST = 3.0  # m/s, KUKA's own bound of $VEL.CP
_TAIL = re.compile(r"\s*((?:C_\w+\s*)*)(?:WITH\s+(.*))?$", re.I | re.S)
_WITH = re.compile(r"(\$[A-Z_]+(?:\.[A-Z]+)?)\s*=\s*(.*)$", re.I | re.S)
Tail = tuple[float, float, int, int]


class KrlTails:
    """Reads the tails of one run; equal ones are worked out once."""

    def __init__(self, program: KrlProgram, names: KrlNames, mounted: MountedFrames) -> None:
        self.program, self.names, self.mounted = program, names, mounted
        self._known: dict[str, Tail] = {}

    def forget(self) -> None:
        """Speed, rounding, tool or base may be others from here on."""
        self._known.clear()

    def tail(self, s: Statement, tail: str, word: str) -> Tail:
        """Feed mm/s, rounding mm, tool and base of what stands behind the target; ``word`` is PTP, LIN or CIRC."""
        key = f"{word} {tail}"
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = self._worked_out(s, SYSTEM.sub("", tail), word)
        return known

    def _worked_out(self, s: Statement, tail: str, word: str) -> Tail:
        tail, behind = _behind(tail)
        match = _TAIL.match(tail)
        if not match:
            what = "CA: an arc by its angle" if re.match(r"\s*,\s*CA", tail, re.I) else repr(tail.strip()[:40])
            remedy = "Give via point and end of at most one turn."
            self.program.refuse(s.start, f"{what} behind the target is not read", remedy)
        mode = self.names.get("$IPO_MODE")
        if mode is not None and mode.value == "#TCP":
            self.program.refuse(s.start, "$IPO_MODE #TCP: a tool that stands still", "The arm has to hold the tool.")
        own = self._with(s, match[2] or "")
        speed = own.get("$VEL", own.get("$VEL.CP", self._speed()))
        if word != "PTP":
            self.check_speed(s.start, speed)
        feed = speed * 1e3 if isinstance(speed, float) and 0.0 < speed < math.inf and word != "PTP" else math.nan
        rounded = (match[1] + behind).upper()
        zone = self._number("$APO.CDIS") if "C_DIS" in rounded else math.nan if rounded.strip() else 0.0
        return feed, zone, self.mounted.tool(s, own.get("$TOOL")), self.mounted.base(s, own.get("$BASE"))

    def check_speed(self, at: int, speed: Value) -> None:
        """Refuse a $VEL.CP that is meant in mm/s."""
        if isinstance(speed, float) and speed > FASTEST:
            problem = f"$VEL.CP = {speed:g}: it is in m/s, KUKA takes at most {FASTEST:g}"
            self.program.refuse(at, problem, f"Write {speed * 1e-3:g} where {speed:g} mm/s is meant.")

    def _speed(self) -> Value:
        if speed := self.names.get("$VEL.CP"):
            return speed.value
        speeds = self.names.get("$VEL")
        value = speeds.value if speeds else None
        return value.get("CP") if isinstance(value, dict) else None

    def _number(self, name: str) -> float:
        variable = self.names.get(name)
        return variable.value if variable and isinstance(variable.value, float) else math.nan

    def _with(self, s: Statement, text: str) -> dict[str, Value]:
        """What stands behind WITH, for this line alone: speed, tool number, base number."""
        out: dict[str, Value] = {}
        for piece in _pieces(text):
            if not (match := _WITH.match(piece.strip())):
                continue
            name, inner = match[1].upper(), re.match(r"\w+\s*\((.*)\)\s*$", match[2], re.S)
            first = _pieces(inner[1])[0] if inner else match[2]
            try:
                value = self.names.value(first)
            except ExpressionError as e:
                self.program.refuse(s.start, f"{name}: {e}")
            if name in ("$TOOL", "$BASE") and isinstance(value, dict) and "TOOL_NO" in value:
                value = value["TOOL_NO" if name == "$TOOL" else "BASE_NO"]
            out[name] = value
        return out


def _behind(tail: str) -> tuple[str, str]:
    """What stands behind a target without the C_... at its end (at most two), and these."""
    behind = ""
    for _ in range(2):
        rest, _, word = tail.rstrip().rpartition(" ")
        if not re.fullmatch(r"C_\w+", word, re.I):
            break
        tail, behind = rest, f"{word} {behind}"
    return tail, behind


def _pieces(text: str) -> list[str]:
    """At commas outside brackets."""
    out, depth, start = [], 0, 0
    for i, c in enumerate(text):
        depth += (c in "{([") - (c in "})]")
        if c == "," and depth == 0:
            out.append(text[start:i])
            start = i + 1
    return [*out, text[start:]]
