"""Cell: what stands around the robot, and what the job is. Reads cell/1 files."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, Strict, ValidationError, model_validator

from compensator.errors import CellError
from stiffness.robot.robot import STANDARD_GRAVITY
from stiffness.statics.predictor import Tool
from toolpaths.machine import Machine, RotaryAxis
from toolpaths.rotation import matrix_from_rpy

Floats = npt.NDArray[np.float64]
Number = Annotated[float, Strict()]  # TOML has numbers: "250" and "250 mm" are mistakes
Three = tuple[Number, Number, Number]
Six = tuple[Number, Number, Number, Number, Number, Number]
_DEFAULT_SPACING = 10.0


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=False)


def _in_mm(name: str, xyz: tuple[float, float, float]) -> None:
    length = float(np.linalg.norm(xyz))
    if 0 < length < 5:
        raise ValueError(f"{name} is {length:g} mm long: expected mm, this looks like metres")


def _in_degrees(name: str, angles: tuple[float, ...]) -> None:
    for a in angles:
        quarters = round(abs(a) / (np.pi / 2))
        if 1 <= quarters <= 4 and abs(abs(a) - quarters * np.pi / 2) < 1e-3:
            raise ValueError(f"{name} holds {a:g}: expected deg, this looks like a multiple of pi/2 in rad")


class Mount(_Table):
    """Base in the world, deg; gravity is -z of the world."""

    rpy: Three = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _units(self) -> Mount:
        _in_degrees("mount.rpy", self.rpy)
        return self


class ToolTable(_Table):
    """Flange -> TCP, mm and deg; mass kg; com mm in the flange frame."""

    xyz: Three
    rpy: Three = (0.0, 0.0, 0.0)
    mass: Number | None = Field(default=None, ge=0, le=5000)
    com: Three | None = None
    name: str = "tool"

    @model_validator(mode="after")
    def _complete(self) -> ToolTable:
        _in_mm("tool.xyz", self.xyz)
        _in_mm("tool.com", self.com or (0.0, 0.0, 0.0))
        _in_degrees("tool.rpy", self.rpy)
        if self.mass and self.com is None:
            raise ValueError("mass is given without com, where its weight acts; add com = [x, y, z] in mm")
        return self

    def tool(self) -> Tool:
        """In SI."""
        com = None if self.com is None else np.array(self.com) / 1e3
        return Tool(matrix_from_rpy(np.radians(self.rpy)), np.array(self.xyz) / 1e3, self.mass or 0.0, com, self.name)


class WorkObject(_Table):
    """Base -> the frame that the CAM file is written in, mm and deg."""

    xyz: Three
    rpy: Three = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _units(self) -> WorkObject:
        _in_mm("workobject.xyz", self.xyz)
        _in_degrees("workobject.rpy", self.rpy)
        return self

    def matrix(self) -> Floats:
        """(4, 4) in SI."""
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = matrix_from_rpy(np.radians(self.rpy)), np.array(self.xyz) / 1e3
        return pose


class Start(_Table):
    """Where the path starts from: joint angles in deg."""

    joints: list[Number]

    @model_validator(mode="after")
    def _units(self) -> Start:
        _in_degrees("start.joints", tuple(self.joints))
        return self


class Constant(_Table):
    """The same wrench at every cutting pose: on the robot, about the TCP, N and N*m."""

    kind: Literal["constant"]
    frame: Literal["path", "tool", "workobject", "base"]
    wrench: Six


class Table(_Table):
    """A wrench per pose or per source line, from a csv file relative to the cell."""

    kind: Literal["table"]
    frame: Literal["path", "tool", "workobject", "base"]
    file: str


class Solve(_Table):
    """Bounds and freedoms of the solve: mm, deg.

    ``fade``: how far from the part, along a rapid, a correction fades in and out.
    ``min_*``: how near a singularity a pose may come; ``min_singular_value`` (translations divided by half
    the reach) holds for arms without a spherical wrist, angles and distance (mm) for the others.
    """

    max_correction: Number = Field(default=5.0, gt=0, le=100)
    free_tool_axis: Annotated[bool, Strict()] = True
    complementary_stiffness: Annotated[bool, Strict()] = True
    fade: Number = Field(default=20.0, gt=0, le=1000)
    min_wrist_angle: Number = Field(default=2.0, gt=0, lt=90)
    min_elbow_angle: Number = Field(default=2.0, gt=0, lt=90)
    min_shoulder: Number = Field(default=20.0, gt=0, le=1000)
    min_singular_value: Number = Field(default=0.02, gt=0, lt=1)
    max_joint_step: Number = Field(default=30.0, gt=0, le=180)


class Sampling(_Table):
    """How arcs and long moves become points: mm and deg."""

    chord: Number = Field(default=0.01, gt=0, le=10)
    angle: Number = Field(default=0.1, gt=0, le=10)
    spacing: Number = Field(default=_DEFAULT_SPACING, gt=0, le=1000)


class ProgramTable(_Table):
    """What the written program is called, its speed in the air and where the toolpath gives none (mm/min)."""

    name: str = "PART1"
    rapid_feed: Number = Field(default=30000.0, gt=0, le=300000)
    default_feed: Number = Field(default=1000.0, gt=0, le=300000)


class ExternalAxis(_Table):
    """What an external axis of a robot program carries; mm, base axes.

    ``robot``: a rail, ``direction`` is the way the base goes as the value rises (mm). ``part``: a table, which turns
    about ``direction`` through ``center`` (deg). ``nothing``: it may move as it likes.
    """

    carries: Literal["robot", "part", "nothing"]
    direction: Three = (0.0, 0.0, 0.0)
    center: Three = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _complete(self) -> ExternalAxis:
        if self.carries == "nothing":
            return self
        if not abs(float(np.linalg.norm(self.direction)) - 1.0) < 1e-6:
            raise ValueError(f"direction = {list(self.direction)}: a direction of length 1 in base axes is expected")
        if self.carries == "part" and "center" not in self.model_fields_set:
            raise ValueError("center is missing: a point on the axis of the table, mm in the base")
        if self.carries == "robot" and "center" in self.model_fields_set:
            raise ValueError("center is of a table (carries = \"part\"): a rail has none")
        _in_mm("center", self.center)
        return self


class MachineAxis(_Table):
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


class MachineTable(_Table):
    """The machine that a G-code file with rotary words, or with several of G54 ... G59.3, was posted for; mm."""

    kinematics: Literal["", "table", "head", "table-table", "head-head", "head-table"] = ""
    pivot: Number | None = Field(default=None, gt=0, le=5000)
    axis: list[MachineAxis] = []
    systems: dict[Annotated[str, Field(pattern=r"^G5[4-9]$|^G59\.[1-3]$")], Three] = {}

    @model_validator(mode="after")
    def _complete(self) -> MachineTable:
        if not self.kinematics and not self.systems:
            raise ValueError("nothing is declared; give kinematics with [[machine.axis]], or [machine.systems]")
        if self.pivot is not None:
            if "head" not in self.kinematics:
                raise ValueError(f"pivot = {self.pivot:g}: kinematics {self.kinematics!r} has no head")
            _in_mm("machine.pivot", (self.pivot, 0.0, 0.0))
        self.machine()
        return self

    def machine(self) -> Machine:
        """In SI.

        Raises:
            ValueError: kinematics and axes contradict each other.
        """
        systems = {name: _metres(origin) for name, origin in self.systems.items()}
        pivot = None if self.pivot is None else self.pivot / 1e3
        return Machine(self.kinematics, tuple(a.axis() for a in self.axis), pivot, systems)


def _metres(xyz: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = xyz
    return x / 1e3, y / 1e3, z / 1e3


class Cell(_Table):
    """A cell/1 file, checked. ``folder`` is where it stands: paths in it are relative to that.

    Tool and work object may be left to a robot program; ``job_of`` refuses where neither gives them.
    """

    schema_: Literal["cell/1"] = Field(alias="schema")
    robot: str
    model: str
    base: str | None = None
    tip: str | None = None
    gravity: Literal["uncompensated", "calibrated-out"] | None = None
    temperature: Number | None = Field(default=None, ge=-50, le=150)
    mount: Mount = Mount()
    tool: ToolTable | None = None
    tools: dict[int, ToolTable] = {}
    workobject: WorkObject = WorkObject(xyz=(0.0, 0.0, 0.0))
    machine: MachineTable | None = None
    external: dict[Annotated[str, Field(pattern=r"^eax_[a-f]$|^E[1-6]$|^GP[2-8] J[1-9]$")], ExternalAxis] = {}
    start: Start | None = None
    process: Annotated[Constant | Table, Field(discriminator="kind")]
    solve: Solve = Solve()
    sampling: Sampling = Sampling()
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

    def gravity_in_base(self) -> Floats:
        """(3,) m/s2."""
        return np.asarray(matrix_from_rpy(np.radians(self.mount.rpy)).T @ np.array(STANDARD_GRAVITY))


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
    place = ".".join(str(p) for p in f["loc"] if p not in ("constant", "table")) or "the file as a whole"
    kind, given = f["type"], f.get("input")
    if kind == "extra_forbidden":
        return f"unknown key {place} = {given!r}; see docs/compensate.md for the keys and their units"
    if kind == "missing":
        return f"{place} is missing"
    shown = "" if isinstance(given, dict) else f" = {given!r}"
    return f"{place}{shown}: {f['msg'].removeprefix('Value error, ')}"
