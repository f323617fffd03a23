"""Material: the coefficients of the cutting force and how sure they are. Reads material/1 files and built-in sets."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from math import pi
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, Strict, ValidationError, model_validator

from compensator.errors import CellError
from compensator.toml_table import Number, TomlTable
from stiffness.schema import findings

Floats = npt.NDArray[np.float64]
Text = Annotated[str, Strict()]
Pair = tuple[Number, Number]
Row = tuple[Number, Number, Number, Number, Number, Number]

NAMES = ("ktc", "krc", "kac", "kte", "kre", "kae")
SI = np.array([1e6, 1e6, 1e6, 1e3, 1e3, 1e3])  # N/mm2 and N/mm to N/m2 and N/m


class CoefficientsTable(TomlTable):
    """The six numbers, N/mm2 and N/mm; what a set does not have is left out."""

    ktc: Number | None = None
    krc: Number | None = None
    kac: Number | None = None
    kte: Number | None = None
    kre: Number | None = None
    kae: Number | None = None

    def given(self) -> dict[str, float]:
        """Name -> number of those that are there."""
        return {k: v for k in NAMES if (v := getattr(self, k)) is not None}


class KienzleTable(TomlTable):
    """Specific force N/mm2 at a chip of 1 mm, and its exponent: F = kc11 b h^(1 - mc); of the normal force if known."""

    kc11: Number = Field(gt=0)
    mc: Number = Field(ge=0, lt=1)
    kn11: Number | None = Field(default=None, gt=0)
    mn: Number | None = Field(default=None, ge=0, lt=1)

    @model_validator(mode="after")
    def _both(self) -> KienzleTable:
        if (self.kn11 is None) != (self.mn is None):
            raise ValueError("kn11 and mn belong together")
        return self


class RangeTable(TomlTable):
    """Where the numbers were measured: mm, m/min, words."""

    feed_per_tooth_mm: Pair | None = None
    speed_m_min: Pair | None = None
    tool: Text | None = None


class MaterialFile(TomlTable):
    """A material/1 file."""

    schema_: Literal["material/1"] = Field(alias="schema")
    name: Text
    source: Text
    sign: Text
    sd_source: Text | None = None
    coefficients: CoefficientsTable | None = None
    kienzle: KienzleTable | None = None
    sd: CoefficientsTable = CoefficientsTable()
    covariance: tuple[Row, Row, Row, Row, Row, Row] | None = None
    range: RangeTable = RangeTable()

    @model_validator(mode="after")
    def _complete(self) -> MaterialFile:
        if (self.coefficients is None) == (self.kienzle is None):
            raise ValueError("give either [coefficients] or [kienzle]")
        if self.coefficients is not None and not self.coefficients.given():
            raise ValueError("[coefficients] is empty: at least ktc is needed")
        if any(v < 0 for v in self.sd.given().values()):
            raise ValueError("a standard deviation in [sd] is negative")
        if self.covariance is not None:
            matrix = np.array(self.covariance)
            if not np.allclose(matrix, matrix.T, rtol=1e-6) or np.linalg.eigvalsh(matrix).min() < -1e-6 * matrix.max():
                raise ValueError("covariance: expected a symmetric matrix without negative variances")
        return self


@dataclass(frozen=True, repr=False)
class Material:
    """Coefficients of one material with one kind of tool.

    Attributes:
        name: as in files and messages. source, sign: where the numbers and the sense of the axial term come from.
        coefficients: (6,) N/m2 and N/m in the order of NAMES; 0 where a set has none.
        missing: names without a number.
        covariance: (6, 6) in the same units, or None where nothing is known.
        feed_per_tooth, speed: m, m/s, ranges that it was measured in, or None. tool: in words.
        label: what was done to the numbers; empty: nothing.
    """

    name: str
    source: str
    sign: str
    coefficients: Floats
    missing: tuple[str, ...] = ()
    covariance: Floats | None = None
    feed_per_tooth: tuple[float, float] | None = None
    speed: tuple[float, float] | None = None
    tool: str = ""
    label: str = ""

    def __repr__(self) -> str:
        values = ", ".join(f"{n} {v:.4g}" for n, v in zip(NAMES, self.coefficients / SI, strict=True))
        return f"Material({self.name!r}: {values})"

    @property
    def sd(self) -> Floats | None:
        """(6,) standard deviations."""
        return None if self.covariance is None else np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def builtin_materials() -> tuple[str, ...]:
    """Names of the built-in sets, sorted."""
    return tuple(sorted(_builtin_files()))


@dataclass(frozen=True, repr=False)
class MaterialText:
    """A material as it was given: a set with power laws has its six numbers at the feed at hand only.

    Attributes:
        source: the file, or where in the cell it stands, for messages.
        file: what was read.
    """

    source: str
    file: MaterialFile

    def __repr__(self) -> str:
        return f"MaterialText({self.file.name!r})"

    def at(self, feed_per_tooth: float | None = None) -> Material:
        """The six numbers; ``feed_per_tooth``: m, at hand.

        Raises:
            CellError: the set has power laws, and no feed is known.
        """
        return _at(self.file, self.source, feed_per_tooth)


def find_material(name_or_path: str, folder: Path, key: str = "material") -> MaterialText:
    """A built-in set or a material/1 file.

    Args:
        folder: what a relative path starts from. key: where it is named, for messages.

    Raises:
        CellError: no such set, or its file is refused; names the file, the key and what was expected.
    """
    builtin = _builtin_files().get(name_or_path)
    if builtin is not None:
        return material_text_of(builtin.read_text(encoding="utf-8"), f"built-in material {name_or_path}")
    path = folder / name_or_path
    if path.suffix != ".toml":
        known = ", ".join(builtin_materials())
        what = f"{key} = {name_or_path!r} is not known"
        raise CellError(f"{what}: expected a path to a material/1 file (.toml), or one of {known}")
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as e:
        raise CellError(f"{key} = {name_or_path!r}: {path}: cannot read the material: {e}") from e
    return material_text_of(text, str(path))


def given_material(coefficients: CoefficientsTable, source: str) -> MaterialText:
    """The six numbers of a cell."""
    file = MaterialFile.model_validate(
        {"schema": "material/1", "name": "coefficients of the cell", "source": source, "sign": "as in the cell",
         "coefficients": coefficients.given()}
    )  # fmt: skip
    return MaterialText(source, file)


def load_material(name_or_path: str, folder: Path, feed_per_tooth: float | None = None) -> Material:
    """A built-in set or a material/1 file at a feed per tooth (m); refusals as ``find_material`` and ``at``."""
    return find_material(name_or_path, folder).at(feed_per_tooth)


def _builtin_files() -> dict[str, Traversable]:
    folder = files("compensator") / "process" / "milling" / "materials"
    return {f.name[:-5]: f for f in folder.iterdir() if f.name.endswith(".toml")}


def material_text_of(text: str, source: str) -> MaterialText:
    """The text of a material/1 file; ``source`` names it in messages.

    Raises:
        CellError: names the file, the key, the value and what was expected.
    """
    try:
        return MaterialText(source, MaterialFile.model_validate(tomllib.loads(text)))
    except tomllib.TOMLDecodeError as e:
        raise CellError(f"{source}: not a TOML file: {e}") from e
    except ValidationError as e:
        raise CellError(f"{source}: " + "; ".join(str(f) for f in findings(e))) from e


def _at(file: MaterialFile, source: str, feed_per_tooth: float | None) -> Material:
    label = ""
    if file.kienzle is not None:
        if feed_per_tooth is None or not feed_per_tooth > 0:
            raise CellError(f"{source}: [kienzle] needs the feed per tooth of the job, which is not known")
        given = _linear(file.kienzle, 2.0 / pi * feed_per_tooth * 1e3)
        law = f"kc1.1 = {file.kienzle.kc11:g} N/mm2, mc = {file.kienzle.mc:g}"
        label = f"numbers from {law}, at {feed_per_tooth * 1e3:.3g} mm per tooth"
    elif file.coefficients is not None:
        given = file.coefficients.given()
    low_high = file.range
    return Material(
        file.name,
        file.source.strip(),
        file.sign.strip(),
        np.array([given.get(n, 0.0) for n in NAMES]) * SI,
        missing=tuple(n for n in NAMES if n not in given),
        covariance=_covariance(file, given),
        feed_per_tooth=_scaled(low_high.feed_per_tooth_mm, 1e-3),
        speed=_scaled(low_high.speed_m_min, 1 / 60),
        tool=low_high.tool or "",
        label=label,
    )


def _scaled(pair: Pair | None, by: float) -> tuple[float, float] | None:
    return None if pair is None else (pair[0] * by, pair[1] * by)


def _linear(k: KienzleTable, h: float) -> dict[str, float]:
    """Tangent of the power law at the chip thickness ``h`` mm: a slope (N/mm2) and what it leaves at h = 0 (N/mm)."""
    out = {"ktc": (1 - k.mc) * k.kc11 * h**-k.mc, "kte": k.mc * k.kc11 * h ** (1 - k.mc)}
    if k.kn11 is not None and k.mn is not None:
        out |= {"krc": (1 - k.mn) * k.kn11 * h**-k.mn, "kre": k.mn * k.kn11 * h ** (1 - k.mn)}
    return out


def _covariance(file: MaterialFile, given: Mapping[str, float]) -> Floats | None:
    scale = np.outer(SI, SI)
    if file.covariance is not None:
        return np.array(file.covariance) * scale
    sd = file.sd.given()
    if not sd:
        return None
    return np.diag([sd.get(n, 0.0) if n in given else 0.0 for n in NAMES]) ** 2 * scale
