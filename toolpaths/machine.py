"""Machine: what a file with rotary words was posted for, and where its tool stands in the work object.

Directions are those in which the TOOL turns relative to the work (right-handed, for growing angles), whatever part of
the machine moves: a table that turns right-handed about +z for growing C has the direction (0, 0, -1).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from toolpaths.frame import Floats, Vector

KINEMATICS = ("table", "head", "table-table", "head-head", "head-table")
UNIT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class RotaryAxis:
    """One rotary axis.

    Attributes:
        letter: A, B or C.
        direction: unit vector at zero angles, in the axes of the work object: the tool turns about it.
        centre: a point of the axis at zero angles, m in the work object; None: not known (then only G43.4 is read).
    """

    letter: str
    direction: Vector
    centre: Vector | None = None


@dataclass(frozen=True)
class Machine:
    """The machine that a file with rotary words was posted for.

    Attributes:
        kinematics: one of KINEMATICS, a word for each axis.
        axes: in that order; the first of two tables or heads carries the second.
        pivot: m from where the axes of the head meet to the tip of the tool; None: not known.
        systems: where G54, G55 ... lie in the work object, m; needed when a file uses several.
        start: where the tool stands when the file begins, m in the work object; None: not known.
        radii: of the registers D that G41 and G42 name, m.

    Raises:
        ValueError: the values contradict each other; names them.
    """

    kinematics: str = ""
    axes: tuple[RotaryAxis, ...] = ()
    pivot: float | None = None
    systems: Mapping[str, Vector] = field(default_factory=dict)
    start: Vector | None = None
    radii: Mapping[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.kinematics and self.kinematics not in KINEMATICS:
            raise ValueError(f"kinematics {self.kinematics!r}: one of {', '.join(KINEMATICS)} is expected")
        if len(self.axes) != len(self.places):
            given = f"{len(self.axes)} are given"
            raise ValueError(f"kinematics {self.kinematics!r} needs {len(self.places)} axes, {given}")
        letters = [a.letter for a in self.axes]
        if len(set(letters)) != len(letters) or not set(letters) <= set("ABC"):
            raise ValueError(f"axes {', '.join(letters)}: different ones of A, B, C are expected")
        for a in self.axes:
            if not abs(np.linalg.norm(a.direction) - 1.0) <= UNIT_TOLERANCE:
                raise ValueError(f"direction {a.direction} of axis {a.letter}: a unit vector is expected")

    @property
    def places(self) -> tuple[str, ...]:
        """table or head, for each axis."""
        return tuple(self.kinematics.split("-")) if self.kinematics else ()

    @property
    def letters(self) -> str:
        """The letters of the axes."""
        return "".join(a.letter for a in self.axes)

    def missing(self) -> str:
        """What has to be known of the machine to read rotary moves without G43.4; empty: nothing."""
        tables = [a.letter for a, p in zip(self.axes, self.places, strict=True) if p == "table" and a.centre is None]
        lacking = [f"centre of axis {letter}" for letter in tables]
        return " and ".join(lacking + ["pivot"] * ("head" in self.places and self.pivot is None))

    def poses(self, xyz: Floats, angles: Floats, tip: npt.NDArray[np.bool_]) -> tuple[Floats, Floats]:
        """(N, 3) tip and (N, 3) tool axis in the work object.

        Args:
            xyz: (N, 3) m as programmed.
            angles: (N, k) rad.
            tip: (N,) G43.4 is on: xyz is the tip in the work object already.
        """
        up = np.array([0.0, 0.0, 1.0])
        axis, place = np.tile(up, (len(xyz), 1)), xyz.copy()
        for a, where, angle in reversed(list(zip(self.axes, self.places, angles.T, strict=True))):
            if where == "head":
                axis = _turn(axis, a.direction, angle)
        if self.pivot is not None:
            place += self.pivot * (up - axis)
        for a, where, angle in zip(self.axes, self.places, angles.T, strict=True):
            if where == "table":
                centre = np.array(a.centre or (0.0, 0.0, 0.0))
                place = _turn(place - centre, a.direction, angle) + centre
                axis = _turn(axis, a.direction, angle)
        return np.where(tip[:, None], xyz, place), axis


def _turn(vectors: Floats, about: Vector, angle: Floats) -> Floats:
    """(N, 3) vectors turned by (N,) angles about a unit vector (Rodrigues)."""
    k, c, s = np.array(about), np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.asarray(vectors * c + np.cross(k, vectors) * s + (vectors @ k)[:, None] * k * (1.0 - c))
