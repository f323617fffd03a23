"""ComplianceModel: a robot, the effects it shows, and their values; read from and written to model/1 files."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import tomli_w

from stiffness.effects import BASE, BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect, Parameter
from stiffness.errors import ModelError
from stiffness.model.correlation import Correlations, read_correlations

Floats = npt.NDArray[np.float64]
GRAVITY = ("uncompensated", "calibrated-out")
SCHEMA = "model/1"
_TOP = {"schema", "robot", "gravity", "reference_temperature", "base", "tip", "provenance", "effects", "correlations"}


@dataclass(frozen=True, repr=False)
class ComplianceModel:
    """Values of the effects that a robot shows.

    Attributes:
        source: the file, as the user named it.
        robot: name or path, as the file says.
        gravity: ``uncompensated`` or ``calibrated-out`` (measurement-session.md).
        reference_temperature: deg C where the robot model is true.
        base, tip: frames that the model was made with; None where the file does not say.
        values: effect -> parameter -> array, in SI.
        sd: the same for standard deviations, where given.
        identified: effect -> per-joint booleans, where the file says.
        tools: effect -> name of the tool it holds for (scope ``tool``).
        provenance: free text by key: kind, source, load_range, preload_side, ...
        correlations: between the numbers of the model, where identification gave them.
    """

    source: str
    robot: str
    gravity: str
    reference_temperature: float
    base: str | None
    tip: str | None
    values: Mapping[str, Mapping[str, Floats]]
    sd: Mapping[str, Mapping[str, Floats]] = field(default_factory=dict)
    identified: Mapping[str, npt.NDArray[np.bool_]] = field(default_factory=dict)
    tools: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)
    correlations: Correlations | None = None

    def __repr__(self) -> str:
        return f"ComplianceModel({self.source!r}, {self.robot}, {', '.join(self.values)})"

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects of the model, in the order of the catalogue."""
        return tuple(e for e in CATALOGUE if e.name in self.values)

    def applied(self, tool: str) -> tuple[tuple[Effect, ...], tuple[str, ...]]:
        """Effects that act on a planned path with a tool of this name, and the names of those that do not."""
        yes = [e for e in self.effects if e.scope == "robot" or (e.scope == "tool" and self.tools[e.name] == tool)]
        return tuple(yes), tuple(e.name for e in self.effects if e not in yes)


def load_model(path: str | Path, joints: int = 6) -> ComplianceModel:
    """Read a model/1 file.

    Raises:
        ModelError: names the file, the key, the value and what was expected.
    """
    name = str(path)
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as e:
        raise ModelError(f"{name}: cannot read the model: {e}") from e
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as e:
        raise ModelError(f"{name}: not a TOML file: {e}") from e
    return _model(name, table, joints)


def builtin_model(robot: str) -> Path | None:
    """The published stiffness set of a built-in robot, if there is one."""
    path = Path(str(resources.files("stiffness") / "model" / "data" / f"{robot}.toml"))
    return path if path.exists() else None


def _model(name: str, table: dict[str, Any], joints: int) -> ComplianceModel:
    _known(name, "", table, _TOP)
    if table.get("schema") != SCHEMA:
        raise ModelError(f"{name}: schema = {table.get('schema')!r}; expected {SCHEMA!r}")
    _typed(name, table, "robot", str, "the name of a built-in robot or a path")
    gravity = table.get("gravity", GRAVITY[0])
    if gravity not in GRAVITY:
        raise ModelError(f"{name}: gravity = {gravity!r}; expected one of {', '.join(GRAVITY)}")
    (temperature,) = _array(name, "reference_temperature", table.get("reference_temperature", 20.0), 1)
    for key in ("base", "tip"):
        _typed(name, {key: "", **table}, key, str, "the name of a frame")
    _typed(name, {"provenance": {}, **table}, "provenance", dict, "a table")
    effects = table.get("effects")
    if not isinstance(effects, dict) or not effects:
        raise ModelError(f"{name}: no [effects.*] table; a model needs at least [effects.{BASE.name}]")
    unknown = [e for e in effects if e not in BY_NAME]
    if unknown:
        raise ModelError(
            f"{name}: unknown effect {', '.join(unknown)}; known are {', '.join(BY_NAME)}; an effect of another "
            "package needs that package installed beside this program (entry point compensator.effects)"
        )
    if BASE.name not in effects:
        raise ModelError(f"{name}: [effects.{BASE.name}] is missing: it is the base model of every other effect")
    read = {e: _effect(name, BY_NAME[e], t, joints) for e, t in effects.items()}
    return ComplianceModel(
        source=name,
        robot=table["robot"],
        gravity=gravity,
        reference_temperature=float(temperature),
        base=table.get("base"),
        tip=table.get("tip"),
        values={e: r[0] for e, r in read.items()},
        sd={e: r[1] for e, r in read.items() if r[1]},
        identified={e: r[2] for e, r in read.items() if r[2] is not None},
        tools={e: effects[e].get("tool", "tool") for e in read if BY_NAME[e].scope == "tool"},
        provenance=table.get("provenance", {}),
        correlations=read_correlations(name, table.get("correlations"), _counts(read)),
    )


def _counts(read: Mapping[str, tuple[Mapping[str, Floats], Any, Any]]) -> dict[str, int]:
    return {f"{e}.{p}": len(numbers) for e, (values, _, _) in read.items() for p, numbers in values.items()}


def _known(name: str, place: str, table: Mapping[str, Any], keys: set[str]) -> None:
    extra = [k for k in table if k not in keys]
    if extra:
        raise ModelError(f"{name}: unknown key {place}{extra[0]}; expected some of {', '.join(sorted(keys))}")


def _typed(name: str, table: Mapping[str, Any], key: str, kind: type, expected: str, place: str = "") -> None:
    if not isinstance(table.get(key), kind):
        raise ModelError(f"{name}: {place}{key} = {table.get(key)!r}; expected {expected}")


def _effect(
    name: str, effect: Effect, table: Any, joints: int
) -> tuple[dict[str, Floats], dict[str, Floats], npt.NDArray[np.bool_] | None]:
    place = f"effects.{effect.name}"
    if not isinstance(table, dict):
        raise ModelError(f"{name}: {place} is not a table")
    names = [p.name for p in effect.parameters]
    tool = {"tool"} if effect.scope == "tool" else set()
    allowed = {*names, *(f"sd_{_bare(p)}" for p in names), "identified"} | tool
    _known(name, place + ".", table, allowed)
    _typed(name, {"tool": "", **table}, "tool", str, "the name of the tool it was measured with", place + ".")
    values, sd = {}, {}
    for p in effect.parameters:
        if p.name in table:
            values[p.name] = _numbers(name, f"{place}.{p.name}", table[p.name], p, joints)
        elif p.default is not None:
            values[p.name] = np.full(p.count(joints), p.default)
            values[p.name].setflags(write=False)
        else:
            raise ModelError(f"{name}: {place}.{p.name} is missing: {p.meaning}, {p.unit}")
        key = f"sd_{_bare(p.name)}"
        if key in table:
            sd[p.name] = _array(name, f"{place}.{key}", table[key], p.count(joints))
            if np.any(sd[p.name] < 0):
                raise ModelError(f"{name}: {place}.{key}: a standard deviation is negative")
    problem = effect.check(values)
    if problem:
        raise ModelError(f"{name}: {place}.{problem}")
    identified = None
    if "identified" in table:
        flags = table["identified"]
        if not isinstance(flags, list) or len(flags) != joints or not all(isinstance(f, bool) for f in flags):
            raise ModelError(f"{name}: {place}.identified = {flags!r}; expected {joints} booleans")
        identified = np.array(flags)
        identified.setflags(write=False)
    return values, sd, identified


def _bare(parameter: str) -> str:
    """k_nm_per_rad -> nm_per_rad: the interface writes sd_nm_per_rad."""
    return parameter.removeprefix("k_")


def _array(name: str, place: str, given: Any, count: int) -> Floats:
    numbers = given if isinstance(given, list) else [given]
    if len(numbers) != count or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in numbers):
        raise ModelError(f"{name}: {place} = {given!r}; expected {count} number{'s' if count > 1 else ''}")
    try:
        array = np.array(numbers, dtype=float)
    except OverflowError as e:
        raise ModelError(f"{name}: {place} = {given!r}; a number is too large") from e
    array.setflags(write=False)
    if not np.all(np.isfinite(array)):
        raise ModelError(f"{name}: {place} = {given!r}; every number must be finite")
    return array


def _numbers(name: str, place: str, given: Any, p: Parameter, joints: int) -> Floats:
    array = _array(name, place, given, p.count(joints))
    bad = np.flatnonzero((array < p.low) | (array > p.high))
    if len(bad):
        raise ModelError(
            f"{name}: {place}[{bad[0] + 1}] = {array[bad[0]]:g} {p.unit} is outside {p.low:g} ... {p.high:g} "
            f"({p.meaning})"
        )
    return array


def save_model(model: ComplianceModel, path: str | Path) -> None:
    """Write a model/1 file; reading it again gives the same numbers to the last bit."""
    Path(path).write_text(model_text(model), encoding="utf-8", newline="\n")


def model_text(model: ComplianceModel) -> str:
    """The model as the text of a model/1 file."""
    table: dict[str, Any] = {"schema": SCHEMA, "robot": model.robot, "gravity": model.gravity}
    table["reference_temperature"] = model.reference_temperature
    for key in ("base", "tip"):
        if getattr(model, key) is not None:
            table[key] = getattr(model, key)
    if model.provenance:
        table["provenance"] = dict(model.provenance)
    table["effects"] = {e.name: _effect_table(model, e) for e in model.effects}
    if model.correlations is not None:
        table["correlations"] = model.correlations.table()
    return tomli_w.dumps(table)


def _effect_table(model: ComplianceModel, effect: Effect) -> dict[str, Any]:
    table: dict[str, Any] = {}
    if effect.name in model.tools:
        table["tool"] = model.tools[effect.name]
    for p in effect.parameters:
        numbers = model.values[effect.name][p.name].tolist()
        table[p.name] = numbers if len(numbers) > 1 else numbers[0]
        if p.name in model.sd.get(effect.name, {}):
            table[f"sd_{_bare(p.name)}"] = model.sd[effect.name][p.name].tolist()
    if effect.name in model.identified:
        table["identified"] = model.identified[effect.name].tolist()
    return table
