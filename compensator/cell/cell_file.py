"""Cell: what stands around the robot, and what is done there. Reads cell/1 files."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import Field, ValidationError, model_validator

from compensator.cell.machine_table import MachineTable
from compensator.cell.placement_tables import (
    NO_WORKOBJECT,
    ExternalAxisTable,
    MountTable,
    StartTable,
    ToolTable,
    WorkObjectTable,
)
from compensator.cell.run_tables import ProgramTable, SamplingTable, SolveTable
from compensator.errors import CellError
from compensator.process.catalogue import PROCESSES
from compensator.process.process import ProcessTable
from compensator.toml_table import Number, TomlTable
from toolpaths.machine import Machine

AxisName = Annotated[str, Field(pattern=r"^eax_[a-f]$|^E[1-6]$|^GP[2-8] J[1-9]$")]
if TYPE_CHECKING:
    AnyProcessTable = ProcessTable
else:
    AnyProcessTable = Annotated[Union[tuple(PROCESSES.values())], Field(discriminator="kind")]  # noqa: UP007, made of a table


class Cell(TomlTable):
    """A cell/1 file, checked. ``folder`` is where it stands: paths in it are relative to that.

    Tool and work object may be left to a robot program; ``placement_of`` refuses where neither gives them.
    """

    schema_: Literal["cell/1"] = Field(alias="schema")
    robot: str
    model: str
    base: str | None = None
    tip: str | None = None
    gravity: Literal["uncompensated", "calibrated-out"] | None = None
    temperature: Number | None = Field(default=None, ge=-50, le=150)
    mount: MountTable = MountTable()
    tool: ToolTable | None = None
    tools: dict[int, ToolTable] = Field(default_factory=dict)
    workobject: WorkObjectTable = NO_WORKOBJECT
    machine: MachineTable | None = None
    external: dict[AxisName, ExternalAxisTable] = Field(default_factory=dict)
    start: StartTable | None = None
    process: AnyProcessTable
    solve: SolveTable = SolveTable()
    sampling: SamplingTable = SamplingTable()
    program: ProgramTable = ProgramTable()
    source: str = Field(default="", exclude=True)
    folder: Path = Field(default=Path(), exclude=True)

    @model_validator(mode="after")
    def _one_kind_of_tool(self) -> Cell:
        if self.tool is not None and self.tools:
            raise ValueError("give either [tool] or [tools.1], [tools.2], ... by the number in the file, not both")
        return self

    def __repr__(self) -> str:
        return f"Cell({self.source!r}, {self.robot}, {self.model})"

    def posted_for(self) -> Machine | None:
        """The machine that the toolpath was posted for, if declared; in SI."""
        return None if self.machine is None else self.machine.machine()


def load_cell(path: str | Path) -> Cell:
    """Read a cell/1 file.

    Raises:
        CellError: names the file, the key, the value and what was expected, all findings in one message.
    """
    name = str(path)
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as e:
        raise CellError(f"{name}: cannot read the cell: {e}") from e
    except tomllib.TOMLDecodeError as e:
        raise CellError(f"{name}: not a TOML file: {e}") from e
    for reserved in ("source", "folder", "schema_"):
        if reserved in table:
            raise CellError(f"{name}: unknown key {reserved}")
    try:
        return Cell.model_validate({**table, "source": name, "folder": Path(path).parent})
    except ValidationError as e:
        raise CellError(f"{name}: " + "; ".join(_finding(f) for f in e.errors())) from e


def _finding(f: Any) -> str:
    place = ".".join(str(p) for p in f["loc"] if p not in PROCESSES) or "the file as a whole"
    kind, given = f["type"], f.get("input")
    if kind == "extra_forbidden":
        return f"unknown key {place} = {given!r}; see docs/compensate.md for the keys and their units"
    if kind == "missing":
        return f"{place} is missing"
    shown = "" if isinstance(given, dict) else f" = {given!r}"
    return f"{place}{shown}: {f['msg'].removeprefix('Value error, ')}"
