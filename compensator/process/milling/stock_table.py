"""[process.stock] of a cell file: a mesh, a box or a cylinder in the work object, the finished part, the grid; mm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field, model_validator

from compensator.errors import CellError
from compensator.toml_table import Number, Three, TomlTable

if TYPE_CHECKING:
    from compensator.process.milling.stock import Stock

Pair = tuple[Number, Number]
SMALLEST, LARGEST = 1.0, 20_000.0  # mm


class StockCylinderTable(TomlTable):
    """A cylinder along z: middle, radius, lower and upper end, mm."""

    center: Pair
    radius: Number = Field(gt=0, le=10_000)
    z: Pair

    @model_validator(mode="after")
    def _upright(self) -> StockCylinderTable:
        if not self.z[0] < self.z[1]:
            raise ValueError(f"z = {list(self.z)}: the lower end first, then the upper one")
        _refuse_size("cylinder", max(2 * self.radius, self.z[1] - self.z[0]))
        return self


class StockTable(TomlTable):
    """What is machined. One of ``file``, ``box``, ``cylinder``; ``units`` are those of ``file`` and ``part``."""

    file: str | None = None
    units: Literal["mm", "inch", "m"] = "mm"
    box: tuple[Three, Three] | None = None
    cylinder: StockCylinderTable | None = None
    part: str | None = None
    grid: Number | None = Field(default=None, ge=0.01, le=50)

    @model_validator(mode="after")
    def _one(self) -> StockTable:
        given = [k for k in ("file", "box", "cylinder") if getattr(self, k) is not None]
        if len(given) != 1:
            raise ValueError(f"give one of file, box, cylinder; given: {', '.join(given) or 'none'}")
        if self.box is not None:
            low, high = np.array(self.box)
            if not np.all(low < high):
                raise ValueError(f"box = {[list(p) for p in self.box]}: the least corner first, then the largest one")
            _refuse_size("box", float((high - low).max()))
        if "units" in self.model_fields_set and self.file is None and self.part is None:
            raise ValueError(f"units = {self.units!r} belongs to a mesh: box and cylinder are in mm")
        return self

    def stock(self, folder: Path, source: str) -> Stock:
        """The stock, in SI; a mesh is read.

        Args:
            source: the cell, for messages.

        Raises:
            CellError: the mesh is refused.
        """
        from compensator.process.milling.stock import box_stock, cylinder_stock

        if self.file is not None:
            return _named(f"{source}: process.stock.file", folder / self.file, self.units)
        if self.box is not None:
            return box_stock(np.array(self.box[0]) * 1e-3, np.array(self.box[1]) * 1e-3)
        if self.cylinder is None:
            raise ValueError("no stock in a table that was checked")
        c = self.cylinder
        return cylinder_stock(np.array(c.center) * 1e-3, c.radius * 1e-3, (c.z[0] * 1e-3, c.z[1] * 1e-3))

    def finished_part(self, folder: Path, source: str) -> Stock | None:
        """The part, in SI, where one is named.

        Args:
            source: the cell, for messages.

        Raises:
            CellError: the mesh is refused.
        """
        return None if self.part is None else _named(f"{source}: process.stock.part", folder / self.part, self.units)


def _named(key: str, path: Path, units: str) -> Stock:
    """A mesh.

    Raises:
        CellError: as ``read_mesh``, with the key that names the file in front.
    """
    from compensator.process.milling.mesh_file import read_mesh

    try:
        return read_mesh(path, units)
    except CellError as e:
        raise CellError(f"{key}: {e}") from e


def _refuse_size(name: str, size: float) -> None:
    if not SMALLEST <= size <= LARGEST:
        raise ValueError(f"{name} is {size:g} mm large: expected mm, 1 mm to 20 m")
