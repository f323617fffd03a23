"""session.toml of schema ``measurement-session/1``: how a session was measured, in SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, ValidationError, field_validator, model_validator

from stiffness.rotation import rpy_rotation
from stiffness.schema import SchemaFinding, StrictTable, findings, meant
from stiffness.session.table import SessionError
from stiffness.statics.tool import Tool
from stiffness.text_file import parsed_toml

Floats = npt.NDArray[np.float64]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Noise = Annotated[float, Field(ge=0, strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, strict=True, allow_inf_nan=False)]
Flag = Annotated[bool, Field(strict=True)]
Three = tuple[Number, Number, Number]

_FARTHEST = 50.0  # m: nothing that sits on a robot is farther from its link
_COARSEST = 0.01  # m: no tracker is as bad as that; metres taken for millimetres look so


@dataclass(frozen=True, eq=False)
class Reflector:
    """A laser-tracker target: ``position`` (3,) m in the frame of ``link``, a guess where not ``exact``."""

    name: str
    link: int
    position: Floats
    exact: bool
    group: str | None


@dataclass(frozen=True, eq=False)
class SessionTool:
    """What hangs on the flange: TCP ``rotation`` (3, 3), ``position`` (3,) m; ``mass`` kg, None: not known;
    ``com`` (3,) m in the flange frame, None: not known."""

    name: str
    rotation: Floats
    position: Floats
    mass: float | None
    com: Floats | None

    def tool(self) -> Tool:
        """As the statics take it: a mass that is not known weighs nothing."""
        return Tool(rotation=self.rotation, position=self.position, mass=self.mass or 0.0, com=self.com, name=self.name)


@dataclass(frozen=True)
class Instruments:
    """One-sigma noise of a single reading, per axis: ``tracker`` m, ``tracker_angle`` rad (None: not given),
    ``force`` N, ``torque`` N*m."""

    tracker: float
    tracker_angle: float | None
    force: float
    torque: float


@dataclass(frozen=True)
class Purpose:
    """What a set-up is for: ``joint`` counted from 1, ``points``: A, B, C -> index of the reflector."""

    joint: int | None
    points: Mapping[str, int]


class Units(StrictTable):
    """Units of samples.csv and of every number in session.toml."""

    length: Literal["mm", "m"]
    angle: Literal["deg", "rad"]

    @property
    def metre(self) -> float:
        """m per unit of length."""
        return 1e-3 if self.length == "mm" else 1.0

    @property
    def radian(self) -> float:
        """rad per unit of angle."""
        return math.pi / 180 if self.angle == "deg" else 1.0


class WrenchTable(StrictTable):
    """How f* and m* are written."""

    frame: Literal["base", "tool"]
    about: Literal["tcp", "flange", "base"]


class _Tool(StrictTable):
    xyz: Three
    rpy: Three = (0.0, 0.0, 0.0)
    mass: Noise | None = None
    com: Three | None = None
    name: Annotated[str, Field(min_length=1)] = "tool"

    @model_validator(mode="after")
    def _complete(self) -> _Tool:
        if self.mass and self.com is None:
            raise ValueError("mass without com: the weight acts at the centre of mass; add com = [x, y, z]")
        return self


class _Reflector(StrictTable):
    link: Annotated[int, Field(ge=0, strict=True)]
    position: Three
    exact: Flag = True
    group: Annotated[str, Field(min_length=1)] | None = None


class _Instruments(StrictTable):
    tracker: Positive
    tracker_angle: Positive | None = None
    force: Noise | None = None
    torque: Noise | None = None


class _Setup(StrictTable):
    purpose: Annotated[str, Field(pattern=r"^joint-[1-9]$")] | None = None
    points: dict[Literal["A", "B", "C"], str] = Field(default_factory=dict)


class SessionFile(StrictTable):
    """session.toml as it stands, in its own units; the properties of the next classes are SI."""

    schema_: Literal["measurement-session/1"] = Field(alias="schema")
    robot: Annotated[str, Field(min_length=1)]
    samples: Annotated[str, Field(min_length=1)]
    base: str | None = None
    tip: str | None = None
    gravity: Literal["uncompensated", "calibrated-out"] = "uncompensated"
    registered: Flag = True
    reference_temperature: Number | None = None
    units: Units
    wrench: WrenchTable | None = None
    tool: _Tool | None = None
    reflectors: Annotated[dict[str, _Reflector], Field(min_length=1)]
    instruments: _Instruments
    setups: dict[int, _Setup] = Field(default_factory=dict)

    @field_validator("setups", mode="before")
    @classmethod
    def _numbered(cls, table: object) -> object:
        for key in table if isinstance(table, dict) else ():
            if not str(key).removeprefix("-").isdigit():
                raise ValueError(f"[setups.{key}]: expected the number in column setup, like [setups.4]")
        return table


def read_file(label: str, raw: bytes) -> SessionFile:
    """Read session.toml.

    Raises:
        SessionError: no TOML, an unknown or missing key, a word or number that is not understood.
    """
    try:
        file = SessionFile.model_validate(parsed_toml(label, raw, SessionError, "measurement-session/1"))
    except ValidationError as error:
        raise SessionError(f"{label}: " + "; ".join(map(_problem, findings(error)))) from error
    if file.instruments.tracker * file.units.metre > _COARSEST:
        raise SessionError(
            f"{label}: instruments.tracker = {file.instruments.tracker:g}: in {file.units.length} that is "
            "more than 10 mm; expected the noise of one reading, in units.length"
        )
    return file


def _problem(found: SchemaFinding) -> str:
    """A finding with the remedy."""
    if found.kind == "unknown":
        return f"{found}{meant(found.key.rpartition('.')[2], _KEYS)}"
    return f"{found}; add it" if found.kind == "missing" else str(found)


_KEYS = {
    name.rstrip("_")
    for table in (SessionFile, Units, WrenchTable, _Tool, _Reflector, _Instruments, _Setup)
    for name in table.model_fields
}


def reflectors(label: str, file: SessionFile, joints: int) -> tuple[Reflector, ...]:
    """The reflectors in the order of the file, in SI.

    Raises:
        SessionError: a link that the robot does not have, a position beyond reason, a group in pieces.
    """
    found = []
    for name, given in file.reflectors.items():
        if given.link > joints:
            raise SessionError(
                f"{label}: reflectors.{name}.link = {given.link}: the robot has the links 0 (base) ... "
                f"{joints} (flange)"
            )
        position = _metres(label, file, f"reflectors.{name}.position", given.position)
        found.append(Reflector(name=name, link=given.link, position=position, exact=given.exact, group=given.group))
    first: dict[str, Reflector] = {}
    for r in found:
        if r.group is None:
            continue
        origin = first.setdefault(r.group, r)
        for key, has, expected in (("link", r.link, origin.link), ("exact", r.exact, origin.exact)):
            if has != expected:
                raise SessionError(
                    f"{label}: reflectors.{r.name}.{key} = {str(has).lower()}: {origin.name} of the same "
                    f"group {r.group!r} has {str(expected).lower()}; a group is one rigid probe"
                )
    return tuple(found)


def tool(label: str, file: SessionFile) -> SessionTool | None:
    """The tool in SI."""
    given = file.tool
    if given is None:
        return None
    rotation = rpy_rotation(*(angle * file.units.radian for angle in given.rpy))
    rotation.setflags(write=False)
    com = None if given.com is None else _metres(label, file, "tool.com", given.com)
    return SessionTool(
        name=given.name,
        rotation=rotation,
        position=_metres(label, file, "tool.xyz", given.xyz),
        mass=given.mass,
        com=com,
    )


def purposes(label: str, file: SessionFile, known: tuple[Reflector, ...], joints: int) -> dict[int, Purpose]:
    """Set-up number -> what it is for."""
    index = {r.name: k for k, r in enumerate(known)}
    found = {}
    for number, given in file.setups.items():
        for point, name in given.points.items():
            if name not in index:
                raise SessionError(
                    f"{label}: setups.{number}.points.{point} = {name!r}: no such reflector, known are "
                    f"{', '.join(index)}{meant(name, index)}"
                )
        joint = None if given.purpose is None else int(given.purpose.removeprefix("joint-"))
        if joint is not None and joint > joints:
            key = f"setups.{number}.purpose = {given.purpose!r}"
            raise SessionError(f"{label}: {key}: the robot has {joints} joints")
        found[number] = Purpose(joint, {str(p): index[name] for p, name in given.points.items()})
    return found


def instruments(label: str, file: SessionFile, forces: bool) -> Instruments:
    """The noise in SI; with forces in the samples their noise must be given."""
    given = file.instruments
    missing = [key for key, value in (("force", given.force), ("torque", given.torque)) if value is None]
    if forces and missing:
        raise SessionError(
            f"{label}: key instruments.{missing[0]} is missing: the samples have a wrench; add its noise"
        )
    force, torque = given.force or 0.0, given.torque or 0.0
    return Instruments(given.tracker * file.units.metre, given.tracker_angle, force, torque)


def _metres(label: str, file: SessionFile, key: str, xyz: tuple[float, float, float]) -> Floats:
    position = np.array(xyz) * file.units.metre
    position.setflags(write=False)
    if np.linalg.norm(position) > _FARTHEST:
        raise SessionError(
            f"{label}: {key} = {list(xyz)}: more than {_FARTHEST:g} m away; is units.length = "
            f"{file.units.length!r} right?"
        )
    return position
