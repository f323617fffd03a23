"""Cell: what stands around the robot, and what is done there. Reads cell/1 files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args

from pydantic import AfterValidator, BaseModel, Field, ValidationError, model_validator

from compensator.cell.machine_table import MachineTable
from compensator.cell.placement_tables import (
    NO_WORKOBJECT,
    ControllerTable,
    ExternalAxisTable,
    MountTable,
    StartTable,
    ToolTable,
    WorkObjectTable,
)
from compensator.cell.run_tables import ProgramTable, SamplingTable, SolveTable
from compensator.cell.scene_tables import CollisionsTable, SceneTable
from compensator.errors import CellError
from compensator.process.catalogue import PROCESSES
from compensator.process.process import ProcessTable
from compensator.toml_table import Number, TomlTable
from stiffness.schema import SchemaFinding, findings, meant
from stiffness.text_file import toml_table
from toolpaths.external_axes import axis_number
from toolpaths.machine import Machine

AXIS_NAMES = r"eax_[a-f]|E[1-6]|GP[2-8] J[1-9]"


def _axis_name(name: str) -> str:
    if not re.fullmatch(AXIS_NAMES, name):
        raise ValueError(
            "expected the name of an external axis: E1 ... E6 or eax_a ... eax_f, which are the same six, or "
            "GP2 J1 ... GP8 J9 of a Fanuc group, as in [external.E1]"
        )
    return name


AxisName = Annotated[str, AfterValidator(_axis_name)]
FREE_AXES = 2  # that are chosen together
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
    controller: ControllerTable = ControllerTable()
    start: StartTable | None = None
    process: AnyProcessTable
    solve: SolveTable = SolveTable()
    sampling: SamplingTable = SamplingTable()
    program: ProgramTable = ProgramTable()
    scene: tuple[SceneTable, ...] = ()
    collisions: CollisionsTable = CollisionsTable()
    source: str = Field(default="", exclude=True)
    folder: Path = Field(default=Path(), exclude=True)

    @model_validator(mode="after")
    def _one_kind_of_tool(self) -> Cell:
        if self.tool is not None and self.tools:
            raise ValueError("give either [tool] or [tools.1], [tools.2], ... by the number in the file, not both")
        names = [entry.name for entry in self.scene]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"scene: {twice[0]!r} stands twice: messages name a body by its name")
        free = [name for name, axis in self.external.items() if axis.free]
        if len(free) > FREE_AXES:
            raise ValueError(f"external: {', '.join(free)} are free: {FREE_AXES} at most are chosen together")
        slots = [axis_number(name) for name in free]
        if None in slots:
            name = free[slots.index(None)]
            what = f"external.{name}.free: an axis of another group is not chosen"
            raise ValueError(f"{what}; E1 ... E6 and eax_a ... eax_f are")
        turning = [name for name in free if self.external[name].turns]
        tables = [name for name in free if self.external[name].carries == "part"]
        if turning and len(tables) > 1:
            both = " and ".join(tables)
            what = f"external.{turning[0]}.speed: {both} are tables: one that turns along a path is alone"
            raise ValueError(f"{what}; take speed and acceleration away, and both are set once")
        if len(set(slots)) < len(slots):
            raise ValueError(f"external: {' and '.join(free)} are two names of one axis")
        numbered = {name: number for name in self.external if (number := axis_number(name)) is not None}
        for name, number in numbered.items():
            other = next(n for n in numbered if numbered[n] == number)
            if self.external[other] != self.external[name]:
                raise ValueError(f"external: {other} and {name} are two names of one axis: they have to tell the same")
        return self

    def __repr__(self) -> str:
        return f"Cell({self.source!r}, {self.robot}, {self.model})"

    def posted_for(self) -> Machine | None:
        """The machine that the toolpath was posted for, if declared; in SI."""
        return None if self.machine is None else self.machine.machine()


def load_cell(path: str | Path, *, model_needed: bool = True) -> Cell:
    """Read a cell/1 file; ``model`` may be missing where it is not needed.

    Raises:
        CellError: names the file, the key, the value and what was expected, all findings in one message.
    """
    table = toml_table(str(path), Path(path), CellError, schema="cell/1")
    return checked_cell(table if model_needed else {"model": "", **table}, str(path), Path(path).parent)


def checked_cell(table: dict[str, Any], name: str, folder: Path) -> Cell:
    """The cell of the tables of a cell/1 file.

    Args:
        name: of the file, for messages. folder: that paths in it are relative to.

    Raises:
        CellError: as ``load_cell``.
    """
    for reserved in ("source", "folder", "schema_"):
        if reserved in table:
            raise CellError(f"{name}: unknown key {reserved}")
    try:
        return Cell.model_validate({**table, "source": name, "folder": folder})
    except ValidationError as e:
        found = findings(e)
        missing = [f.key for f in found if f.kind == "missing"]
        raise CellError(f"{name}: {'; '.join(map(_words, found))}{to_copy(*missing)}") from e


def to_copy(*missing: str) -> str:
    """Lines for keys and tables that are missing, in the order of the file."""
    lines = [line for key, text in _EXAMPLES.items() if key in missing for line in text.splitlines()]
    return "".join(["; to copy and to adapt:", *(f"\n    {line}" for line in lines)]) if lines else ""


_EXAMPLES = {
    "schema": 'schema = "cell/1"',
    "robot": 'robot = "abb-irb6600-175-255"  # or a file; `compensator robots` lists the built-in ones',
    "model": 'model = "stiffness.toml"  # of `compensator identify`, by hand, or a built-in robot\'s name',
    "tool": "[tool]\nxyz = [0.0, 0.0, 250.0]  # flange to TCP, mm",
    "workobject": "[workobject]\nxyz = [1500.0, -200.0, 800.0]  # base to the frame of the CAM file, mm",
    "process": """[process]
kind = "constant"
frame = "path"  # x along the feed, z out of the tool into the work
wrench = [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]  # on the robot, about the TCP, N and N*m""",
}


def _words(f: SchemaFinding) -> str:
    first, *rest = f.key.split(".")
    place = ".".join([first, *(rest[1:] if first == "process" and rest[:1] and rest[0] in PROCESSES else rest)])
    if f.kind == "unknown":
        shown = "" if isinstance(f.given, dict) else f" = {f.given!r}"
        near = meant(place.rpartition(".")[2], _KEYS, 0.75)
        return f"unknown key {place}{shown}; see docs/compensate.md for the keys and their units{near}"
    if f.kind == "missing":
        return f"{place} is missing"
    if f.code == "union_tag_not_found":
        return f"{place}.kind is missing; known are {', '.join(PROCESSES)}"
    if f.why.startswith(f"{place}."):
        return f.why
    shown = "" if isinstance(f.given, dict) else f" = {f.given!r}"
    return f"{place or 'the file as a whole'}{shown}: {f.why}"


def _keys_of(table: type[BaseModel]) -> Iterator[str]:
    for name, given in table.model_fields.items():
        yield given.alias or name
        for part in (given.annotation, *get_args(given.annotation)):
            if isinstance(part, type) and issubclass(part, BaseModel):
                yield from _keys_of(part)


_TABLES: tuple[type[BaseModel], ...] = (Cell, *PROCESSES.values())
_KEYS = {key for table in _TABLES for key in _keys_of(table)}
