"""Table of a cell file about the machine that a CNC program was posted for."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from compensator.toml_table import Number, Three, TomlTable, refuse_metres
from toolpaths.machine import Machine, RotaryAxis

#: G54 to G59.3 of G-code, G54 to G599 of SINUMERIK, numbers of presets of Klartext.
SystemName = Annotated[str, Field(pattern=r"^G5(?:[4-9]|\d\d)$|^G59\.[1-3]$|^\d{1,4}$")]


class MachineAxisTable(TomlTable):
    """A rotary axis: ``direction`` about which the tool turns relative to the work, ``centre`` on it, mm."""

    letter: Literal["A", "B", "C"]
    direction: Three
    centre: Three | None = None

    def axis(self) -> RotaryAxis:
        """In SI, direction of length 1."""
        length = float(np.linalg.norm(self.direction))
        if not length > 0:
            raise ValueError(f"direction of machine.axis {self.letter} is 0 0 0: a direction is expected")
        x, y, z = (v / length for v in self.direction)
        return RotaryAxis(self.letter, (x, y, z), None if self.centre is None else _metres(self.centre))


class MachineTable(TomlTable):
    """The machine that a CNC program with rotary words, or with several coordinate systems, was posted for; mm.

    ``start``: where the tool stands in the work object when the file begins, for files that do not name every axis
    before they cut. ``radii``: of the registers D of G41 and G42; 0 where CAM gave the path of the cutter's centre.
    """

    kinematics: Literal["", "table", "head", "table-table", "head-head", "head-table"] = ""
    pivot: Number | None = Field(default=None, gt=0, le=5000)
    axis: list[MachineAxisTable] = Field(default_factory=list)
    systems: dict[SystemName, Three] = Field(default_factory=dict)
    start: Three | None = None
    radii: dict[int, Annotated[Number, Field(ge=0, le=200)]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _complete(self) -> MachineTable:
        if not self.kinematics and not self.systems and self.start is None and not self.radii:
            what = "kinematics with [[machine.axis]], [machine.systems], [machine.radii], or start"
            raise ValueError(f"nothing is declared; give {what}")
        if self.pivot is not None:
            if "head" not in self.kinematics:
                raise ValueError(f"pivot = {self.pivot:g}: kinematics {self.kinematics!r} has no head")
            refuse_metres("machine.pivot", (self.pivot, 0.0, 0.0))
        self.machine()
        return self

    def machine(self) -> Machine:
        """In SI.

        Raises:
            ValueError: kinematics and axes contradict each other.
        """
        systems = {name: _metres(origin) for name, origin in self.systems.items()}
        pivot = None if self.pivot is None else self.pivot / 1e3
        start = None if self.start is None else _metres(self.start)
        radii = {number: radius / 1e3 for number, radius in self.radii.items()}
        axes = tuple(a.axis() for a in self.axis)
        return Machine(self.kinematics, axes, pivot=pivot, systems=systems, start=start, radii=radii)


def _metres(xyz: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = xyz
    return x / 1e3, y / 1e3, z / 1e3
