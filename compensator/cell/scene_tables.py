"""Tables of a cell file about what stands around: [[scene]], [[tool.bodies]] and [collisions]; mm and deg."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, Strict, model_validator

from compensator.toml_table import Number, Three, TomlTable, refuse_radians
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_rpy

Floats = npt.NDArray[np.float64]
SMALLEST, LARGEST = 1.0, 50_000.0  # mm
Flag = Annotated[bool, Strict()]


class RodTable(TomlTable):
    """A cylinder along z: radius, lower and upper end, mm."""

    radius: Number = Field(gt=0, le=25_000)
    z: tuple[Number, Number]

    @model_validator(mode="after")
    def _upright(self) -> RodTable:
        if not self.z[0] < self.z[1]:
            raise ValueError(f"z = {list(self.z)}: the lower end first, then the upper one")
        _refuse_size("cylinder", max(2 * self.radius, self.z[1] - self.z[0]))
        return self


class BodyTable(TomlTable):
    """One body: ``mesh`` (a file, in ``units``), ``box`` (two corners) or ``cylinder``, at ``xyz`` and ``rpy``."""

    name: str = Field(min_length=1, max_length=60)
    mesh: str | None = None
    units: Literal["mm", "inch", "m"] = "mm"
    box: tuple[Three, Three] | None = None
    cylinder: RodTable | None = None
    xyz: Three = (0.0, 0.0, 0.0)
    rpy: Three = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _one_shape(self) -> BodyTable:
        given = [k for k in ("mesh", "box", "cylinder") if getattr(self, k) is not None]
        if len(given) != 1:
            raise ValueError(f"{self.name}: give one of mesh, box, cylinder; given: {', '.join(given) or 'none'}")
        if "units" in self.model_fields_set and self.mesh is None:
            raise ValueError(f"{self.name}: units = {self.units!r} belongs to a mesh: box and cylinder are in mm")
        if self.box is not None:
            low, high = np.array(self.box)
            if not np.all(low < high):
                raise ValueError(f"{self.name}: box = {[list(p) for p in self.box]}: the least corner first")
            _refuse_size(f"{self.name}: box", float((high - low).max()))
        refuse_radians(f"{self.name}: rpy", self.rpy)
        return self

    def placed(self) -> Frame:
        """Where it stands, in SI."""
        return Frame(matrix_from_rpy(np.radians(self.rpy)), np.array(self.xyz) / 1e3)


class SceneTable(BodyTable):
    """A body of the cell.

    ``frame``: ``base`` (it stands on the floor), ``workobject`` (it goes with the part) or ``robot`` (it rides on the
    rail with the base). ``sacrificial``: the cutter may go into it on a feed.
    """

    frame: Literal["base", "workobject", "robot"] = "base"
    sacrificial: Flag = False


class CollisionsTable(TomlTable):
    """How collisions are looked for: mm.

    ``margin``: nearer than this is a warning. ``step``: how far the farthest point may move between two looks inside
    the margin. ``neighbours``: pairs of bodies that may touch. ``packages``: folders of the meshes of a URDF.
    ``stock``: arm and spindle keep out of the whole stock, or of the finished part only.
    """

    check: Flag = True
    margin: Number = Field(default=10.0, ge=0, le=500)
    step: Number = Field(default=2.0, ge=0.1, le=100)
    neighbours: tuple[tuple[str, str], ...] = ()
    packages: tuple[str, ...] = ()
    stock: Literal["whole", "part"] = "whole"


def _refuse_size(name: str, size: float) -> None:
    if not SMALLEST <= size <= LARGEST:
        raise ValueError(f"{name} is {size:g} mm large: expected mm, {SMALLEST:g} mm to {LARGEST / 1e3:g} m")
