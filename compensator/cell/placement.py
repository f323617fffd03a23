"""Placement: where part and tools are, and what is done there. Many placements can share one arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from compensator.cell.arm import Conditions
from compensator.cell.cell_file import Cell, to_copy
from compensator.cell.placement_tables import ExternalAxisTable
from compensator.cell.run_tables import ProgramTable, SamplingTable, SolveTable
from compensator.cell.surroundings import Surroundings, surroundings_of
from compensator.errors import CellError
from compensator.path.lean import CutterShape
from compensator.path.tool_set import ToolSet
from compensator.process.process import Process, ProcessContext
from toolpaths.frame import Frame
from toolpaths.machine import Machine

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class Placement:
    """Everything about a run but the arm and the toolpath.

    Attributes:
        source: the file that gives it, for messages.
        workobject: base -> the frame of the toolpath.
        tools: what hangs on the flange.
        process: what the cut does to the robot.
        conditions: gravity, temperature.
        touches: where the work object was touched off with the tool: points (3,) m of it, and postures (n,) rad; empty:
            it was not; None: not known.
        process_names: of the material and the cutter; "" where they are not told.
        absolute_accuracy: whether the controller's own calibration or elasticity option is on; None: not known.
        start: (n,) rad where the path starts from; None: not known.
        external: external axes of robot programs by name.
        machine: that the toolpath was posted for; None: not declared.
        solve, sampling, program: settings, in the units of the cell file.
        surroundings: what stands around and what the tools look like, as the cell file has it.
        cutters: shapes by the number of the tool; None: of all tools.
    """

    source: str
    workobject: Frame
    tools: ToolSet
    process: Process
    conditions: Conditions
    touches: tuple[Floats, ...] | None = None
    process_names: tuple[str, str] = ("", "")
    absolute_accuracy: bool | None = None
    start: Floats | None = None
    external: Mapping[str, ExternalAxisTable] = field(default_factory=dict)
    machine: Machine | None = None
    solve: SolveTable = field(default_factory=SolveTable)
    sampling: SamplingTable = field(default_factory=SamplingTable)
    program: ProgramTable = field(default_factory=ProgramTable)
    surroundings: Surroundings = field(default_factory=Surroundings)
    cutters: Mapping[int | None, CutterShape] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Placement({self.source!r}, {self.tools!r})"


def placement_of(cell: Cell) -> Placement:
    """The placement that a cell describes.

    Raises:
        CellError: work object or tool are missing: a robot program might have brought its own.
    """
    if cell.workobject.xyz is None:
        raise CellError(f"{cell.source}: workobject is missing{to_copy('workobject')}")
    if cell.tool is None and not cell.tools:
        either = "give either [tool] or [tools.1], [tools.2], ... by the number in the file"
        raise CellError(f"{cell.source}: {either}{to_copy('tool')}")
    by_number = {number: table.tool() for number, table in cell.tools.items()}
    tools = ToolSet(by_number) if cell.tool is None else ToolSet.of_one(cell.tool.tool())
    x, y, z = (float(v) for v in cell.mount.gravity_in_base())
    return Placement(
        source=cell.source,
        workobject=cell.workobject.frame(),
        tools=tools,
        process=cell.process.process(_context(cell, tools)),
        conditions=Conditions((x, y, z), cell.gravity, cell.temperature, cell.solve.complementary_stiffness),
        touches=cell.workobject.touches(),
        process_names=cell.process.names(),
        absolute_accuracy=cell.controller.absolute_accuracy,
        start=None if cell.start is None else np.radians(cell.start.joints),
        external=cell.external,
        machine=cell.posted_for(),
        solve=cell.solve,
        sampling=cell.sampling,
        program=cell.program,
        surroundings=surroundings_of(cell),
        cutters=cell.process.shapes(),
    )


def _context(cell: Cell, tools: ToolSet) -> ProcessContext:
    lengths = {0 if tools.any_number else k: float(np.linalg.norm(t.position)) for k, t in tools.by_number.items()}
    return ProcessContext(cell.source, cell.folder, cell.program.default_feed / 60e3, lengths)
