"""Robot files: Denavit-Hartenberg rows in TOML, schema ``robot/1``. Format: docs/robots.md.

classic (Denavit & Hartenberg 1955): link = Rz(offset + sign q) Tz(d) Tx(a) Rx(alpha)
modified (Craig):                    link = Rx(alpha) Tx(a) Rz(offset + sign q) Tz(d)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, ValidationError

from stiffness.errors import RobotError
from stiffness.robot.link_shape import NO_SHAPES, RobotShapes
from stiffness.robot.reducer import ARCMIN, Reducer
from stiffness.robot.robot import Robot, placement
from stiffness.robot.tips import FLANGE, FormerFlange, Tip, chosen_tip
from stiffness.robot.toml_capsules import ShapesTable
from stiffness.rotation import rpy_rotation
from stiffness.schema import StrictTable, findings
from stiffness.text_file import toml_table

Floats = npt.NDArray[np.float64]
Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Length = Annotated[float, Field(ge=-20_000, le=20_000, allow_inf_nan=False, strict=True)]  # mm
Turn = Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False, strict=True)]  # deg
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False, strict=True)]
Rigidity = Annotated[float, Field(gt=0, le=1e9, allow_inf_nan=False, strict=True)]
Arcmin = Annotated[float, Field(ge=0, le=60, allow_inf_nan=False, strict=True)]

_STIFFEST = 2e4  # N*m/arcmin


class _Placement(StrictTable):
    xyz: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    rpy: tuple[Turn, Turn, Turn] = (0.0, 0.0, 0.0)

    def matrix(self) -> Floats:
        return placement(rpy_rotation(*(math.radians(v) for v in self.rpy)), np.array(self.xyz) * 1e-3)


class _Tip(_Placement):
    why: Annotated[str, Field(min_length=1)]


class _Former(StrictTable):
    tip: Annotated[str, Field(min_length=1)]
    xyz: tuple[Length, Length, Length]
    was: str
    now: str

    def flange(self) -> FormerFlange:
        return FormerFlange(self.tip, np.array(self.xyz) * 1e-3, self.was, self.now)


class _Reducer(StrictTable):
    rigidity_nm_per_arcmin: Annotated[tuple[Rigidity, ...], Field(min_length=1, max_length=5)] | None = None
    rigidity_nm_per_rad: Annotated[tuple[Rigidity, ...], Field(min_length=1, max_length=5)] | None = None
    breaks_nm: tuple[Positive, ...] = ()
    lost_motion_arcmin: Arcmin | None = None
    lost_motion_torque_nm: Positive | None = None
    backlash_arcmin: Arcmin | None = None
    gear_ratio: Annotated[float, Field(ge=1, le=10_000, allow_inf_nan=False, strict=True)] | None = None
    source: Annotated[str, Field(min_length=1)]


class _Joint(StrictTable):
    a: Length
    d: Length
    alpha: Turn
    offset: Turn
    sign: Literal[-1, 1] = 1
    limits: tuple[Finite, Finite]
    speed: Positive | None = None
    acceleration: Positive | None = None
    mass: Positive | None = None
    com: tuple[Length, Length, Length] | None = None
    name: str = ""
    source: str = ""
    reducer: _Reducer | None = None


class _File(StrictTable):
    schema_: Literal["robot/1"] = Field(alias="schema")
    name: str
    convention: Literal["classic", "modified"]
    sources: tuple[str, ...]
    assumptions: tuple[str, ...] = ()
    base: _Placement = _Placement()
    flange: _Placement = _Placement()
    tip: Annotated[str, Field(min_length=1)] = FLANGE
    tips: dict[str, _Tip] = Field(default_factory=dict)
    former_flange: _Former | None = None
    reach: Annotated[float, Field(gt=0, le=20_000, allow_inf_nan=False, strict=True)] | None = None
    joints: tuple[_Joint, ...]
    shapes: ShapesTable | None = None


def read(source: Path | Traversable, *, label: str, tip: str | None = None) -> Robot:
    """Read a robot TOML file.

    Args:
        label: what messages call the file.
        tip: frame on the flange that poses lead to; None: the flange itself.

    Raises:
        RobotError: the file cannot be read, a key or value in it is wrong, or it has no such tip.
    """
    try:
        file = _File.model_validate(toml_table(label, source, RobotError, "robot/1"))
    except ValidationError as error:
        raise RobotError(f"{label}: " + "; ".join(map(str, findings(error)))) from error
    stem = source.name.removesuffix(".toml")
    if file.name != stem:
        raise RobotError(f"{label}: name = {file.name!r}, expected the name of the file, {stem!r}")
    for k, joint in enumerate(file.joints):
        low, high = joint.limits
        if not low < high:
            raise RobotError(f"{label}: joints.{k + 1}.limits = [{low}, {high}]: the lower limit comes first, deg")
    return _robot(file, label, tip)


def _robot(file: _File, label: str, asked: str | None) -> Robot:
    tips = {name: Tip(name, given.matrix(), given.why) for name, given in file.tips.items()}
    former = None if file.former_flange is None else file.former_flange.flange()
    tip = chosen_tip(asked, robot=file.name, flange=file.tip, tips=tips, former=former)
    row = _classic if file.convention == "classic" else _modified
    rows = [row(joint) for joint in file.joints]
    before = np.array([b for b, _ in rows]).reshape(-1, 4, 4)
    after = np.array([a for _, a in rows]).reshape(-1, 4, 4)
    if rows:
        before[0] = file.base.matrix() @ before[0]
        after[-1] = after[-1] @ file.flange.matrix() @ tip.placement
    mass, com = _masses(file, label)
    if com is not None and len(com):
        com[-1] = (com[-1] - tip.placement[:3, 3]) @ tip.placement[:3, :3]
    reducers = tuple(_reducer(j.reducer, f"{label}: joints.{k + 1}.reducer") for k, j in enumerate(file.joints))
    return Robot(
        name=file.name,
        joint_names=tuple(j.name or f"joint-{k + 1}" for k, j in enumerate(file.joints)),
        before=before,
        axis=np.array([[0.0, 0.0, float(j.sign)] for j in file.joints]).reshape(-1, 3),
        after=after,
        lower=np.radians([j.limits[0] for j in file.joints]),
        upper=np.radians([j.limits[1] for j in file.joints]),
        velocity=_known([j.speed for j in file.joints]),
        acceleration=_known(given) if any(given := [j.acceleration for j in file.joints]) else None,
        mass=mass,
        com=com,
        mass_problem="" if mass is not None else f"{label} gives no masses",
        assumptions=file.assumptions,
        sources=file.sources
        + tuple(f"joint {k + 1}: {j.source}" for k, j in enumerate(file.joints) if j.source)
        + tuple(f"reducer of joint {k + 1}: {r.source}" for k, r in enumerate(reducers) if r),
        base="base",
        tip=tip.name,
        tip_why=tip.why,
        former_flange=former,
        reach=None if file.reach is None else file.reach * 1e-3,
        reducers=reducers if any(reducers) else None,
        shapes=_shapes(file, label, tip.placement),
    )


def _known(degrees: Sequence[float | None]) -> Floats:
    """(n,) rad; NaN where nothing is given."""
    return np.radians([math.nan if v is None else v for v in degrees])


def _shapes(file: _File, label: str, tip: Floats) -> RobotShapes:
    if file.shapes is None:
        return NO_SHAPES
    try:
        return file.shapes.shapes(len(file.joints), tip)
    except ValueError as error:
        raise RobotError(f"{label}: shapes: {error}") from error


def _reducer(given: _Reducer | None, place: str) -> Reducer | None:
    if given is None:
        return None
    per_arcmin, per_rad = given.rigidity_nm_per_arcmin, given.rigidity_nm_per_rad
    if (per_arcmin is None) == (per_rad is None):
        raise RobotError(f"{place}: give either rigidity_nm_per_arcmin or rigidity_nm_per_rad, as the data sheet does")
    if per_arcmin is not None and max(per_arcmin) > _STIFFEST:
        raise RobotError(
            f"{place}.rigidity_nm_per_arcmin = {list(per_arcmin)}: more than {_STIFFEST:g} N*m/arcmin: this looks like "
            "N*m/rad, which is rigidity_nm_per_rad"
        )
    reducer = Reducer(
        rigidity=per_rad if per_rad is not None else tuple(k / ARCMIN for k in per_arcmin or ()),
        source=given.source,
        breaks=given.breaks_nm,
        lost_motion=None if given.lost_motion_arcmin is None else given.lost_motion_arcmin * ARCMIN,
        lost_motion_torque=given.lost_motion_torque_nm,
        backlash=None if given.backlash_arcmin is None else given.backlash_arcmin * ARCMIN,
        gear_ratio=given.gear_ratio,
    )
    if problem := reducer.problem():
        raise RobotError(f"{place}.{problem}")
    return reducer


def _masses(file: _File, label: str) -> tuple[Floats | None, Floats | None]:
    """Masses (n,) kg and centres (n, 3) m: of all links or of none."""
    without = [k + 1 for k, j in enumerate(file.joints) if j.mass is None or j.com is None]
    if len(without) < len(file.joints) and without:
        raise RobotError(f"{label}: mass and com are given for some joints, but not for {without}: give all or none")
    if without:
        if any(j.mass is not None or j.com is not None for j in file.joints):
            raise RobotError(f"{label}: every joint needs both mass and com, or neither")
        return None, None
    return np.array([j.mass for j in file.joints]), np.array([j.com for j in file.joints]) * 1e-3


def _classic(joint: _Joint) -> tuple[Floats, Floats]:
    return _about_z(joint.offset), _along(0, 0, joint.d) @ _along(joint.a, 0, 0) @ _about_x(joint.alpha)


def _modified(joint: _Joint) -> tuple[Floats, Floats]:
    return _about_x(joint.alpha) @ _along(joint.a, 0, 0) @ _about_z(joint.offset), _along(0, 0, joint.d)


def _about_x(degrees: float) -> Floats:
    return placement(rpy_rotation(math.radians(degrees), 0, 0), (0, 0, 0))


def _about_z(degrees: float) -> Floats:
    return placement(rpy_rotation(0, 0, math.radians(degrees)), (0, 0, 0))


def _along(x: float, y: float, z: float) -> Floats:
    return placement(np.eye(3), np.array([x, y, z]) * 1e-3)
