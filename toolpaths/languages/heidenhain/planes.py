"""Datum shift (cycle 7), rotation (cycle 10), presets (cycle 247) and tilted planes (PLANE, cycle 19) of Klartext.

Sources: iTNC 530 and TNC 620 conversational programming. PLANE SPATIAL: rotations about the untilted X, Y, Z in this
order (TNC 620, "tilting sequence A-B-C"), cycle 19 the same where the machine has spatial angles in it; EULER: about Z,
the new X and the new Z. A datum shift before the tilt counts in the untilted system, one behind it in the tilted one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import NamedTuple

from toolpaths.frame import Vector
from toolpaths.languages.heidenhain.formula import NUMBER, PARAMETER, QParameters
from toolpaths.reading.plain_frame import NOWHERE, PlainFrame

_VALUE = rf"([-+]?\s*(?:{NUMBER}|{PARAMETER}))"
_ANGLES = {
    "SPATIAL": ("SPA", "SPB", "SPC"),
    "EULER": ("EULPR", "EULNU", "EULROT"),
    "RELATIV": ("SPA", "SPB", "SPC"),
    "RELATIVE": ("SPA", "SPB", "SPC"),
    "VECTOR": ("BX", "BY", "BZ", "NX", "NY", "NZ"),
}
_REFUSED = {
    "PROJECTED": "by projection angles",
    "POINTS": "by points",
    "AXIAL": "by positions of the rotary axes",
}
_WORD = re.compile(
    rf"\s*(?:(SPA|SPB|SPC|EULPR|EULNU|EULROT|[BN][XYZ]|MB|ABST|DIST|FMAX|F)\s*(?:{_VALUE}|(MAX))?|"
    r"(TURN|MOVE|STAY)|(SEQ\s*[-+]|SYM\s*[-+]|TABLE\s+ROT|COORD\s+ROT|MAX|AUTO)|(\S))"
)
_FLAT = 1e-6


class Plane(NamedTuple):
    """A PLANE block, or cycle 19.

    Attributes:
        frame: the tilt; on top of the one before where ``adds``.
        turns: the control turns the rotary axes.
        keeps: the tip stays where it is on the work.
        adds: PLANE RELATIV.
    """

    frame: PlainFrame
    turns: bool
    keeps: bool
    adds: bool = False


def plane(text: str, parameters: QParameters) -> Plane:
    """What stands behind PLANE.

    Raises:
        ValueError: a form that is not read.
    """
    kind, _, rest = text.strip().partition(" ")
    if kind in _REFUSED:
        raise ValueError(f"PLANE {kind}: a plane {_REFUSED[kind]}", "Post PLANE SPATIAL or PLANE VECTOR.")
    if kind != "RESET" and kind not in _ANGLES:
        raise ValueError(f"PLANE {kind[:20]}: SPATIAL, VECTOR, EULER, RELATIV or RESET is expected")
    values: dict[str, float] = {}
    way = ""
    for name, value, most, how, _, other in _WORD.findall(rest):
        if other:
            raise ValueError(f"{other!r} in PLANE {text.strip()[:50]}: no word that is read")
        if name and (value or most):
            values[name] = math.inf if most else parameters.number(value)
        way = how or way
    if not way:
        raise ValueError(f"PLANE {kind} without TURN, MOVE or STAY")
    keeps = way == "MOVE" and not (values.get("ABST") or values.get("DIST"))
    if kind == "RESET":
        return Plane(PlainFrame(), way != "STAY", keeps)
    named = _ANGLES[kind]
    given = {n: values[n] for n in named if n in values}
    if kind.startswith("RELATIV"):
        if len(given) != 1:
            raise ValueError("PLANE RELATIV with one of SPA, SPB, SPC is expected")
    elif len(given) != len(named):
        raise ValueError(f"PLANE {kind} without {', '.join(n for n in named if n not in given)}")
    return Plane(_tilt(kind, given), way != "STAY", keeps, kind.startswith("RELATIV"))


def spatial(angles: Mapping[str, float]) -> PlainFrame:
    """Rotations about the untilted X, Y, Z, one after the other; deg by A, B, C."""
    return PlainFrame.turned([(k, math.radians(angles.get("ABC"[k], 0.0))) for k in (2, 1, 0)])


def _tilt(kind: str, given: Mapping[str, float]) -> PlainFrame:
    if kind == "EULER":
        about = zip((2, 0, 2), (given[n] for n in _ANGLES["EULER"]), strict=True)
        return PlainFrame.turned([(axis, math.radians(angle)) for axis, angle in about])
    if kind == "VECTOR":
        return _by_vectors((given["BX"], given["BY"], given["BZ"]), (given["NX"], given["NY"], given["NZ"]))
    return spatial({name[-1]: angle for name, angle in given.items()})


def _by_vectors(base: Vector, normal: Vector) -> PlainFrame:
    """z along the normal, x as near to the base vector as it can be; both may be of any length."""
    z = _unit(normal)
    along = sum(b * n for b, n in zip(base, z, strict=True))
    x = _unit((base[0] - along * z[0], base[1] - along * z[1], base[2] - along * z[2]))
    y = z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]
    return PlainFrame(NOWHERE, ((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])))


def _unit(v: Vector) -> Vector:
    size = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if not _FLAT < size < math.inf:
        raise ValueError("PLANE VECTOR: a vector has no length, or both have one direction")
    return v[0] / size, v[1] / size, v[2] / size


class KlartextFrames:
    """The frames in force; ``offsets``: where presets lie in the work object, m."""

    def __init__(self, offsets: Mapping[str, Vector]) -> None:
        self.offsets = offsets
        self._preset: str | None = None
        self._base = PlainFrame()
        self._before, self._behind = NOWHERE, NOWHERE  # datum shifts before and behind the tilt, m
        self.tilt = PlainFrame()
        self._turn = 0.0  # deg, of cycle 10

    def total(self) -> PlainFrame:
        """The frame that coordinates count in, in the work object."""
        tilted = self._base.then(PlainFrame(self._before)).then(self.tilt)
        return tilted.then(PlainFrame(self._behind)).then(PlainFrame.turned([(2, math.radians(self._turn))]))

    def preset(self, name: str, used: bool) -> None:
        """CYCL DEF 247; ``used``: coordinates were read already.

        Raises:
            ValueError: a second one, and how the two lie to each other is not known.
        """
        before = self._preset or ("another" if used else name)
        self._preset = name
        if self.offsets:
            if name not in self.offsets:
                raise ValueError(f"preset {name}: the machine's offsets name only {', '.join(self.offsets)}")
            self._base = PlainFrame(self.offsets[name])
        elif before != name:
            problem = f"preset {name} after {before}: how the two lie to each other is not in the file"
            raise ValueError(problem, "Post with one of them, or declare their offsets in [machine] of the cell.")

    def shift(self, axis: int, value: float, *, relative: bool) -> None:
        """Cycle 7, one axis, m.

        Raises:
            ValueError: a second shift in a tilted plane, or one while cycle 10 is on.
        """
        tilted = self.tilt.rows is not None
        at = self._behind if tilted and self._before == NOWHERE else self._before
        new = at[axis] + value if relative else value
        if self._turn and new != at[axis]:
            raise ValueError("a datum shift while a rotation (cycle 10) is on", "Write ROT+0 before it.")
        if tilted and self._before != NOWHERE and new not in (at[axis], 0.0):
            raise ValueError(
                "a datum shift in the tilted plane, and one before it",
                "Post one of them, or set the first to 0 before it.",
            )
        moved = [*at]
        moved[axis] = new
        shifted = moved[0], moved[1], moved[2]
        if tilted and self._before == NOWHERE:
            self._behind = shifted
        else:
            self._before = NOWHERE if shifted == (0.0, 0.0, 0.0) else shifted

    def rotate(self, angle: float, *, relative: bool) -> None:
        """Cycle 10, deg about the tool axis."""
        self._turn = self._turn + angle if relative else angle

    def incline(self, to: Plane) -> None:
        """A tilted plane, or none.

        Raises:
            ValueError: a shift or rotation that counts in the plane before is on.
        """
        new = self.tilt.then(to.frame) if to.adds else to.frame
        if not new.turns_as(self.tilt) and (any(self._behind) or self._turn):
            what = "a rotation (cycle 10)" if self._turn else "a datum shift (cycle 7)"
            raise ValueError(f"another plane while {what} of the plane before is on", "Set it to 0 first.")
        self.tilt = new
