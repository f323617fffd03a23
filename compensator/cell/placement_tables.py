"""Tables of a cell file that place things: mount, tool, work object, start, external axes."""

from __future__ import annotations

import re
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, Strict, field_validator, model_validator

from compensator.cell.scene_tables import BodyTable
from compensator.toml_table import Number, Three, TomlTable, refuse_metres, refuse_radians
from stiffness.robot.load import JOINTS
from stiffness.robot.robot import STANDARD_GRAVITY
from stiffness.schema import listed_numbers
from stiffness.statics.tool import Tool
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_rpy

Floats = npt.NDArray[np.float64]


class MountTable(TomlTable):
    """Base in the world, deg; gravity is -z of the world."""

    rpy: Three = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _units(self) -> MountTable:
        refuse_radians("mount.rpy", self.rpy)
        return self

    def gravity_in_base(self) -> Floats:
        """(3,) m/s2."""
        return np.asarray(matrix_from_rpy(np.radians(self.rpy)).T @ np.array(STANDARD_GRAVITY))


class ToolTable(TomlTable):
    """Flange -> TCP, mm and deg; mass kg; com mm in the flange frame; ``bodies``: what it looks like, flange frame."""

    xyz: Three
    rpy: Three = (0.0, 0.0, 0.0)
    mass: Number | None = Field(default=None, ge=0, le=5000)
    com: Three | None = None
    name: str = "tool"
    bodies: tuple[BodyTable, ...] = ()

    @model_validator(mode="after")
    def _complete(self) -> ToolTable:
        refuse_metres("tool.xyz", self.xyz)
        refuse_metres("tool.com", self.com or (0.0, 0.0, 0.0))
        refuse_radians("tool.rpy", self.rpy)
        if self.mass and self.com is None:
            raise ValueError("mass is given without com, where its weight acts; add com = [x, y, z] in mm")
        return self

    def tool(self) -> Tool:
        """In SI."""
        com = None if self.com is None else np.array(self.com) / 1e3
        rotation = matrix_from_rpy(np.radians(self.rpy))
        return Tool(rotation, np.array(self.xyz) / 1e3, mass=self.mass or 0.0, com=com, name=self.name)


class WorkObjectTable(TomlTable):
    """Base -> the frame that the CAM file is written in, mm and deg; without ``xyz`` a robot program has its own.

    ``touched_off``: where the tool touched the part when the work object was taught: points of the work object, mm, or
    joint angles, deg; empty: it was measured otherwise, such as with a tracker.
    """

    xyz: Three | None = None
    rpy: Three = (0.0, 0.0, 0.0)
    touched_off: tuple[tuple[Number, ...], ...] | None = None

    @model_validator(mode="after")
    def _checked(self) -> WorkObjectTable:
        refuse_metres("workobject.xyz", self.xyz or (0.0, 0.0, 0.0))
        refuse_radians("workobject.rpy", self.rpy)
        if self.xyz is None and self.touched_off is None:
            raise ValueError("xyz is missing: where the zero of the toolpath stands in the base, mm")
        for k, entry in enumerate(self.touched_off or ()):
            if len(entry) not in (3, JOINTS):
                raise ValueError(
                    f"touched_off[{k + 1}] has {len(entry)} numbers: expected the 3 of a point in the work object, "
                    f"mm, or the {JOINTS} of a posture, deg"
                )
            if len(entry) == JOINTS:
                refuse_radians(f"workobject.touched_off[{k + 1}]", entry)
        return self

    def frame(self) -> Frame:
        """The work object in the base, in SI."""
        return Frame(matrix_from_rpy(np.radians(self.rpy)), np.array(self.xyz or (0.0, 0.0, 0.0)) / 1e3)

    def touches(self) -> tuple[Floats, ...] | None:
        """Points (3,) m in the work object and postures (n,) rad; None: how it was taught is not known."""
        if self.touched_off is None:
            return None
        return tuple(np.array(e) / 1e3 if len(e) == 3 else np.radians(e) for e in self.touched_off)


NO_WORKOBJECT = WorkObjectTable.model_construct(xyz=None, rpy=(0.0, 0.0, 0.0), touched_off=None)  # left to a program


class ControllerTable(TomlTable):
    """What the controller does by itself: ``absolute_accuracy``, its own calibration or elasticity option; None: not
    known."""

    absolute_accuracy: Annotated[bool, Strict()] | None = None


class StartTable(TomlTable):
    """Where the path starts from: joint angles in deg."""

    joints: list[Number]

    @model_validator(mode="after")
    def _units(self) -> StartTable:
        refuse_radians("start.joints", tuple(self.joints))
        return self


MACHINES = 16  # of MACHINE_DEF
ROUNDED = 1e-3  # of the length of a direction: 0.7071 is meant as the half of the root of 2


def _quarters_in_rad(angle: float) -> bool:
    """Whether an angle is 0 or some quarter turns, one turn at most, in rad, as far as two digits tell."""
    quarters = round(angle / (np.pi / 2))
    return abs(quarters) <= 4 and abs(angle - quarters * np.pi / 2) < 5e-3


def _of_length_one(direction: tuple[float, float, float]) -> str:
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return "a direction of length 1 in base axes is expected"
    return f"its length is {length:.4g}; of length 1 it is {[round(v / length, 7) + 0.0 for v in direction]}"


class ExternalAxisTable(TomlTable):
    """What an external axis carries; mm, base axes.

    ``robot``: a rail, ``direction`` is the way the base goes as the value rises (mm). ``part``: a table, which turns
    about ``direction`` through ``center`` (deg). ``nothing``: it may move as it likes.
    ``free``: where it stands is chosen for a CAM file, within ``range``; a rail may go along the path, with ``speed``
    (mm/s) and ``acceleration`` (mm/s2) at most; a table may turn along it where both are given (deg/s, deg/s2).
    ``unit``: what the controller calls the mechanical unit of a table that it coordinates, ABB's name or KUKA's number
    in MACHINE_DEF; ``unit_xyz``, ``unit_rpy``: where its frame stands in the base with the axis at 0, mm and deg.
    """

    carries: Literal["robot", "part", "nothing"]
    direction: Three = (0.0, 0.0, 0.0)
    center: Three = (0.0, 0.0, 0.0)
    free: Annotated[bool, Strict()] = False
    range: Annotated[tuple[Number, Number], listed_numbers(2)] | None = None
    speed: Number | None = Field(default=None, gt=0, le=10000)
    acceleration: Number | None = Field(default=None, gt=0, le=20000)
    unit: Annotated[str, Strict()] | Annotated[int, Strict()] | None = None
    unit_xyz: Three | None = None
    unit_rpy: Three = (0.0, 0.0, 0.0)

    @property
    def turns(self) -> bool:
        """Whether it is a table that may turn along a path."""
        return self.carries == "part" and self.free and self.speed is not None

    @field_validator("direction")
    @classmethod
    def _rounded_direction(cls, direction: tuple[float, float, float]) -> tuple[float, float, float]:
        """Of length 1 where it is so but for rounding."""
        length = float(np.linalg.norm(direction))
        x, y, z = (v / length if abs(length - 1.0) < ROUNDED else v for v in direction)
        return x, y, z

    @model_validator(mode="after")
    def _freedom(self) -> ExternalAxisTable:
        limits = [key for key in ("range", "speed", "acceleration") if getattr(self, key) is not None]
        if not self.free:
            if limits:
                raise ValueError(f"{limits[0]} is of an axis that is chosen: set free = true, or take it away")
            return self
        if self.carries == "nothing":
            raise ValueError('free = true of an axis that carries nothing: what is chosen carries "robot" or "part"')
        if self.range is None:
            raise ValueError("range is missing: the lowest and highest value, mm of a rail, deg of a table")
        low, high = self.range
        if not low < high:
            raise ValueError(f"range = [{low:g}, {high:g}]: the lowest value first, and a higher one behind it")
        if self.carries == "robot" and high - low < 20.0:
            raise ValueError(f"range = [{low:g}, {high:g}]: {high - low:g} mm of a rail: is this in m? mm are expected")
        if self.carries == "part" and high - low < 0.1:
            raise ValueError(f"range = [{low:g}, {high:g}]: less than 0.1 deg of a table: is this in rad?")
        if self.carries == "part" and _quarters_in_rad(low) and _quarters_in_rad(high):
            what = f"range = [{low:g}, {high:g}]: quarter turns of a table in rad? deg are expected"
            raise ValueError(f"{what}: [{np.degrees(low):.0f}, {np.degrees(high):.0f}]")
        if self.carries == "part" and high - low > 720.0:
            raise ValueError(f"range = [{low:g}, {high:g}]: more than two turns of a table, deg")
        if self.carries == "part" and len(limits) == 2:
            other = "acceleration" if limits[1] == "speed" else "speed"
            what = f"{limits[1]} without {other}: a table turns along a path with both, deg/s and deg/s2"
            raise ValueError(f"{what}, and is set once without them: give {other}, or take {limits[1]} away")
        return self

    @model_validator(mode="after")
    def _unit(self) -> ExternalAxisTable:
        given = [key for key in ("unit", "unit_xyz", "unit_rpy") if key in self.model_fields_set]
        if not given:
            return self
        if self.carries != "part":
            raise ValueError(f'{given[0]} is of a table (carries = "part"), which the controller coordinates')
        if self.unit is None or self.unit_xyz is None:
            missing = "unit" if self.unit is None else "unit_xyz"
            what = "the name of the mechanical unit (ABB) or its number in MACHINE_DEF (KUKA)"
            raise ValueError(f"{missing} is missing: {what}, and where its frame stands with the axis at 0, mm")
        if isinstance(self.unit, str) and not re.fullmatch(r"[A-Za-z]\w{0,31}", self.unit, re.ASCII):
            raise ValueError(f"unit = {self.unit!r}: a name such as \"STN1\", or a number such as 2, is expected")
        if isinstance(self.unit, int) and not 1 <= self.unit <= MACHINES:
            raise ValueError(f"unit = {self.unit}: a number in MACHINE_DEF is 1 ... {MACHINES}")
        refuse_metres("unit_xyz", self.unit_xyz)
        refuse_radians("unit_rpy", self.unit_rpy)
        return self

    def unit_frame(self) -> Frame | None:
        """The frame of its mechanical unit in the base with the axis at 0, in SI; None: not given."""
        if self.unit_xyz is None:
            return None
        return Frame(matrix_from_rpy(np.radians(self.unit_rpy)), np.array(self.unit_xyz) / 1e3)

    @model_validator(mode="after")
    def _complete(self) -> ExternalAxisTable:
        if self.carries == "nothing":
            return self
        if "direction" not in self.model_fields_set:
            what = "the way of the base as the value rises" if self.carries == "robot" else "that the table turns about"
            raise ValueError(f"direction is missing: {what}, of length 1 in base axes, such as [0.0, 1.0, 0.0]")
        if not abs(float(np.linalg.norm(self.direction)) - 1.0) < 1e-6:
            raise ValueError(f"direction = {list(self.direction)}: {_of_length_one(self.direction)}")
        if self.carries == "part" and "center" not in self.model_fields_set:
            raise ValueError("center is missing: a point on the axis of the table, mm in the base")
        if self.carries == "robot" and "center" in self.model_fields_set:
            raise ValueError("center is of a table (carries = \"part\"): a rail has none")
        refuse_metres("center", self.center)
        return self
