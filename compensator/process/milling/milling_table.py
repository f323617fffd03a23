"""[process] with kind = "milling": cutters, stock and material of a cell file, read and checked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import Field, model_validator

from compensator.errors import CellError
from compensator.process.milling.cutter_table import CutterTable
from compensator.process.milling.material import CoefficientsTable, MaterialText, find_material, given_material
from compensator.process.milling.stock_table import StockTable
from compensator.process.milling.used_tools import Spindle
from compensator.process.process import ProcessContext, ProcessTable, cutter_name
from compensator.toml_table import Number

if TYPE_CHECKING:
    from compensator.process.milling.cutter import Cutter
    from compensator.process.milling.milling import MillingProcess

RPM = 1.0 / 60.0  # rev/s


class MillingTable(ProcessTable):
    """The wrench computed from cutter, material and stock.

    ``cutter`` for a path with one tool, ``cutters`` by the number of the tool in the file. ``spindle_rpm`` and
    ``spindle`` where the toolpath gives none. ``coupled``: a preview solves force and deflection together.
    """

    kind: Literal["milling"]
    material: str | None = None
    coefficients: CoefficientsTable | None = None
    spindle_rpm: Number | None = Field(default=None, gt=0, le=200_000)
    spindle: Literal["m3", "m4"] | None = None
    cutter: CutterTable | None = None
    cutters: dict[int, CutterTable] = Field(default_factory=dict)
    stock: StockTable
    coupled: bool = True

    @model_validator(mode="after")
    def _one_of_each(self) -> MillingTable:
        if (self.material is None) == (self.coefficients is None):
            what = "material and coefficients are both given" if self.material else "neither of them is given"
            raise ValueError(f"{what}: give material (a built-in set or a material/1 file), or coefficients")
        if self.coefficients is not None and "ktc" not in self.coefficients.given():
            raise ValueError("coefficients has no ktc: at least ktc is needed, N/mm2")
        if (self.cutter is None) == (not self.cutters):
            what = "both are given" if self.cutter else "there is no cutter"
            raise ValueError(f"{what}: give either [process.cutter], or [process.cutters.N] by the number in the file")
        return self

    def names(self) -> tuple[str, str]:
        """A path with several cutters has the names of all: what was learnt of one does not hold for it."""
        cutters = [self.cutter] if self.cutter else [self.cutters[n] for n in sorted(self.cutters)]
        return self.material or "", "; ".join(dict.fromkeys(cutter_name(c) for c in cutters))

    def process(self, context: ProcessContext) -> MillingProcess:
        """The process.

        Raises:
            CellError: material or mesh are refused, or a cutter is longer than its tool.
        """
        from compensator.process.milling.milling import MillingProcess, Shop  # loads the compiler of the kernels

        cutters: dict[int | None, Cutter] = {number: table.cutter() for number, table in self.cutters.items()}
        if self.cutter is not None:
            cutters[None] = self.cutter.cutter()
        for number, cutter in cutters.items():
            _refuse_longer_than_tool(context, number, cutter)
        shop = Shop(
            stock=self.stock.stock(context.folder, context.source),
            stock_file="" if self.stock.file is None else str(context.folder / self.stock.file),
            units=self.stock.units,
            part=self.stock.finished_part(context.folder, context.source),
            grid=None if self.stock.grid is None else self.stock.grid * 1e-3,
        )
        return MillingProcess(
            context,
            material=self._material(context),
            cutters=cutters,
            shop=shop,
            spindle=Spindle(
                speed=None if self.spindle_rpm is None else self.spindle_rpm * RPM,
                sense={"m3": 1, "m4": -1, None: 0}[self.spindle],
            ),
            coupled=self.coupled,
        )

    def _material(self, context: ProcessContext) -> MaterialText:
        if self.coefficients is not None:
            return given_material(self.coefficients, f"{context.source}: process.coefficients")
        return find_material(self.material or "", context.folder, f"{context.source}: process.material")


def _refuse_longer_than_tool(context: ProcessContext, number: int | None, cutter: Cutter) -> None:
    """Refuse edge, shank and holder that together reach beyond the flange."""
    lengths = context.tool_lengths
    length = lengths.get(number or 0, lengths.get(0, 0.0)) if lengths else 0.0
    if length and cutter.stick_out > length * (1 + 1e-9):
        key = "process.cutter" if number is None else f"process.cutters.{number}"
        raise CellError(
            f"{context.source}: {key}: edge, shank and holder are {cutter.stick_out * 1e3:g} mm long, and the flange "
            f"is {length * 1e3:g} mm from the TCP (tool.xyz): the cutter is longer than its stick-out. Check tool.xyz, "
            "and length, which is that of the cutting edge from the tip"
        )
