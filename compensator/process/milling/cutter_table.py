"""[process.cutter] and [process.cutters.N] of a cell file: a cutter in mm and deg."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field, Strict, model_validator

from compensator.process.milling.shape import Shape
from compensator.toml_table import Number, TomlTable

if TYPE_CHECKING:
    from compensator.process.milling.cutter import Cutter

KEYS_OF = {"bull": ("corner_radius",), "taper": ("half_angle", "corner_radius"), "drill": ("point_angle",)}
NEEDED = {"bull": ("corner_radius",), "taper": ("half_angle",)}
SHAPED = ("corner_radius", "half_angle", "point_angle")
POINT_ANGLE = 118.0


class CylinderTable(TomlTable):
    """A cylinder of the shank or holder, mm."""

    diameter: Number = Field(gt=0, le=1000)
    length: Number = Field(gt=0, le=2000)


class CutterTable(TomlTable):
    """A cutter: mm, deg. ``helix`` and ``runout`` (mm) change the peak only; effects of a process hold for ``name``."""

    name: str | None = None
    shape: Shape
    diameter: Number = Field(gt=0, le=1000)
    flutes: Annotated[int, Strict()] = Field(ge=1, le=200)
    length: Number = Field(gt=0, le=2000)
    helix: Number = Field(default=30.0, ge=0, le=80)
    corner_radius: Number | None = Field(default=None, gt=0)
    half_angle: Number | None = Field(default=None, gt=0, lt=80)
    point_angle: Number | None = Field(default=None, ge=20, lt=180)
    runout: Number = Field(default=0.0, ge=0, le=1)
    shank: CylinderTable | None = None
    holder: list[CylinderTable] = Field(default_factory=list)

    @model_validator(mode="after")
    def _fits(self) -> CutterTable:
        if self.diameter < 0.05:
            raise ValueError(f"diameter = {self.diameter:g} mm: expected mm, this looks like metres")
        allowed = KEYS_OF.get(self.shape, ())
        for key in SHAPED:
            if getattr(self, key) is not None and key not in allowed:
                value = f"{key} = {getattr(self, key):g}"
                raise ValueError(f"{value} with shape = {self.shape!r}: it belongs to {_owners(key)}")
        for key in NEEDED.get(self.shape, ()):
            if getattr(self, key) is None:
                raise ValueError(f"{key} is missing: a cutter of shape {self.shape!r} needs it")
        if self.corner_radius is not None and self.corner_radius > 0.5 * self.diameter:
            raise ValueError(f"corner_radius = {self.corner_radius:g} mm: at most half of diameter = {self.diameter:g}")
        least = self.cutter().arc_height * 1e3
        if self.length < least:
            raise ValueError(f"length = {self.length:g} mm ends below the rounded or pointed end, {least:.3f} mm high")
        return self

    def cutter(self) -> Cutter:
        """In SI."""
        from compensator.process.milling.cutter import Cutter, ToolCylinder  # loads the compiler of the kernels

        half = self.half_angle or 0.0
        if self.shape == "drill":
            half = 0.5 * (self.point_angle or POINT_ANGLE)
        shank = [] if self.shank is None else [self.shank]
        stack = [ToolCylinder(0.5e-3 * c.diameter, 1e-3 * c.length, False) for c in shank]
        stack += [ToolCylinder(0.5e-3 * c.diameter, 1e-3 * c.length, True) for c in self.holder]
        return Cutter(
            self.shape,
            self.diameter * 1e-3,
            self.flutes,
            self.length * 1e-3,
            helix=float(np.radians(self.helix)),
            corner_radius=(self.corner_radius or 0.0) * 1e-3,
            half_angle=float(np.radians(half)),
            runout=self.runout * 1e-3,
            stack=tuple(stack),
        )


def _owners(key: str) -> str:
    return " and ".join(shape for shape, keys in KEYS_OF.items() if key in keys)
