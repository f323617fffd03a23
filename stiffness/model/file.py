"""Model files, schema ``model/1``: the tables of the file; that of an effect is made from its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import BeforeValidator, Field, PlainValidator, Strict, ValidationError, ValidationInfo, create_model
from pydantic_core import PydanticCustomError

from stiffness.effects import BASE, BY_NAME
from stiffness.effects.effect import Effect, Parameter
from stiffness.errors import ModelError
from stiffness.model.correlations import Correlations
from stiffness.schema import SchemaFinding, StrictTable, findings, meant

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Text = Annotated[str, Strict()]

SCHEMA = "model/1"
GRAVITY = ("uncompensated", "calibrated-out")


def numbers(count: int, given: Any) -> Floats:
    """``count`` finite numbers, one of them with or without brackets, as a read-only array."""
    listed = given if isinstance(given, list) else [given]
    if len(listed) != count or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in listed):
        raise _refusal(f" = {given!r}; expected {count} number{'s' if count > 1 else ''}")
    try:
        array = np.array(listed, dtype=float)
    except OverflowError as e:
        raise _refusal(f" = {given!r}; a number is too large") from e
    array.setflags(write=False)
    if not np.all(np.isfinite(array)):
        raise _refusal(f" = {given!r}; every number must be finite")
    return array


def _refusal(after_key: str) -> PydanticCustomError:
    """What is wrong with a value, in words that follow its key."""
    return PydanticCustomError("refused", "{after_key}", {"after_key": after_key})


class ModelFile(StrictTable):
    """The top of the file; effects and correlations have tables of their own.

    The description of a field is what messages expect of its key.
    """

    schema_: Literal["model/1"] = Field(None, alias="schema", validate_default=True, description=repr(SCHEMA))
    robot: Text = Field(None, validate_default=True, description="the name of a built-in robot or a path")
    gravity: Literal["uncompensated", "calibrated-out"] = Field(
        "uncompensated", description=f"one of {', '.join(GRAVITY)}"
    )
    reference_temperature: Annotated[float, BeforeValidator(lambda given: float(numbers(1, given)[0]))] = 20.0
    base: Text | None = Field(None, description="the name of a frame")
    tip: Text | None = Field(None, description="the name of a frame")
    provenance: dict[str, Any] = Field({}, description="a table")
    effects: Any = None
    correlations: Any = None


@dataclass(frozen=True, repr=False)
class EffectValues:
    """The table of an effect: parameter -> numbers, and their standard deviations where given.

    ``identified`` (n,) tells the joints that have been identified, ``tool`` the tool that the effect was measured with;
    ``process`` the names of its material and cutter. None where the table has no such key.
    """

    values: Mapping[str, Floats]
    sd: Mapping[str, Floats]
    identified: Bools | None
    tool: str | None
    process: tuple[str, str] | None = None


def read_tables(
    source: str, table: Mapping[str, Any], joints: int
) -> tuple[ModelFile, dict[str, EffectValues], Correlations | None]:
    """The keys at the top of a model file, its effects in the order of the file, and its correlations.

    Raises:
        ModelError: names the file, the key, the value and what was expected.
    """
    if not table:
        raise ModelError(f"{source}: the file is empty; a model, to copy and to adapt:\n{_to_copy(SCHEMA)}")
    try:
        file = ModelFile.model_validate(table)
    except ValidationError as error:
        raise _refused(source, "", ModelFile, error) from error
    effects = {name: _effect(source, BY_NAME[name], given, joints) for name, given in _known(source, file).items()}
    if file.correlations is None:
        return file, effects, None
    counts = {f"{e}.{p}": len(array) for e, read in effects.items() for p, array in read.values.items()}
    return file, effects, _correlations(source, file.correlations, counts)


def _known(source: str, file: ModelFile) -> dict[str, Any]:
    """The tables of the effects: there are some, the base model is among them, and the catalogue has them all."""
    effects = file.effects
    if not isinstance(effects, dict) or not effects:
        need = f"a model needs at least [effects.{BASE.name}], to copy and to adapt:\n{_to_copy()}"
        raise ModelError(f"{source}: no [effects.*] table; {need}")
    unknown = [name for name in effects if name not in BY_NAME]
    if unknown:
        raise ModelError(
            f"{source}: unknown effect {', '.join(unknown)}{meant(unknown[0], BY_NAME)}; known are "
            f"{', '.join(BY_NAME)}; an effect of another "
            "package needs that package installed beside this program (entry point compensator.effects)"
        )
    if BASE.name not in effects:
        raise ModelError(f"{source}: [effects.{BASE.name}] is missing: it is the base model of every other effect")
    return effects


def _to_copy(schema: str = "") -> str:
    """The least that a model has."""
    (stiffness,) = (p for p in BASE.parameters if p.default is None)
    lines = [f'schema = "{schema}"', 'robot = "abb-irb6600-175-255"'] if schema else []
    lines += [f"[effects.{BASE.name}]", f"{stiffness.name} = [3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4]"]
    return "\n".join(f"    {line}" for line in lines)


# ---- effects


def sd_key(parameter: str) -> str:
    """k_nm_per_rad -> sd_nm_per_rad: the key of a parameter's standard deviations."""
    return f"sd_{parameter.removeprefix('k_')}"


def effect_table(effect: Effect, joints: int) -> type[StrictTable]:
    """The schema of an effect's table on a robot with so many joints."""
    fields: dict[str, Any] = {}
    if effect.scope == "tool":
        fields["tool"] = (Text, Field("tool", description="the name of the tool it was measured with"))
    if effect.scope == "process":
        for key in ("material", "cutter"):
            fields[key] = (Text, Field("", description=f"the name of the {key} it was measured with"))
    for p in effect.parameters:
        count = p.count(joints)
        must = ... if p.default is None else None
        fields[p.name] = (
            Annotated[Any, PlainValidator(partial(_within, p, count))],
            Field(must, description=f"{p.meaning}, {p.unit}"),
        )
        fields[sd_key(p.name)] = (Annotated[Any, PlainValidator(partial(_deviations, count))], None)
    fields["identified"] = (Annotated[Any, PlainValidator(partial(_flags, joints))], None)
    return create_model(effect.name, __base__=StrictTable, **fields)


def _within(p: Parameter, count: int, given: Any) -> Floats:
    array = numbers(count, given)
    bad = np.flatnonzero((array < p.low) | (array > p.high))
    if len(bad):
        raise _refusal(f"[{bad[0] + 1}] = {array[bad[0]]:g} {p.unit} is outside {p.low:g} ... {p.high:g} ({p.meaning})")
    return array


def _deviations(count: int, given: Any) -> Floats:
    array = numbers(count, given)
    if np.any(array < 0):
        raise _refusal(": a standard deviation is negative")
    return array


def _flags(joints: int, given: Any) -> Bools:
    if not isinstance(given, list) or len(given) != joints or not all(isinstance(f, bool) for f in given):
        raise _refusal(f" = {given!r}; expected {joints} booleans")
    flags = np.array(given)
    flags.setflags(write=False)
    return flags


def _effect(source: str, effect: Effect, given: Any, joints: int) -> EffectValues:
    place, table = f"effects.{effect.name}", effect_table(effect, joints)
    if not isinstance(given, dict):
        raise ModelError(f"{source}: {place} is not a table")
    try:
        read = dict(table.model_validate(given))
    except ValidationError as error:
        raise _refused(source, f"{place}.", table, error) from error
    values, sd = {}, {}
    for p in effect.parameters:
        values[p.name] = _default(p, joints) if read[p.name] is None else read[p.name]
        if read[sd_key(p.name)] is not None:
            sd[p.name] = read[sd_key(p.name)]
    if problem := effect.check(values):
        raise ModelError(f"{source}: {place}.{problem}")
    process = (read["material"], read["cutter"]) if effect.scope == "process" else None
    return EffectValues(values, sd, read["identified"], read.get("tool"), process=process)


def _default(p: Parameter, joints: int) -> Floats:
    array = np.full(p.count(joints), p.default)
    array.setflags(write=False)
    return array


# ---- correlations


def _names(given: Any, info: ValidationInfo) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(n, str) for n in given) or len(set(given)) != len(given):
        raise _refusal(": expected names as joint-stiffness.k_nm_per_rad[1], once each")
    for name in given:
        parameter, _, index = name.removesuffix("]").partition("[")
        if not (index.isdigit() and 1 <= int(index) <= (info.context or {}).get(parameter, 0)):
            raise _refusal(f": {name!r} is no number of this model")
    return tuple(given)


def _matrix(given: Any, info: ValidationInfo) -> Floats:
    count = len(info.data.get("names", ()))
    try:
        matrix = np.array(given, dtype=float)
    except (TypeError, ValueError) as e:
        raise _refusal(f": expected rows of numbers: {e}") from e
    proper = matrix.shape == (count, count) and np.all(np.isfinite(matrix))
    if not (proper and np.array_equal(matrix, matrix.T) and np.all(abs(matrix) <= 1) and np.all(np.diag(matrix) == 1)):
        raise _refusal(f": expected {count} x {count} numbers, symmetric, between -1 and 1, with 1 on the diagonal")
    matrix.setflags(write=False)
    return matrix


class _CorrelationTable(StrictTable):
    """``names`` are checked against the context: effect.parameter -> how many numbers it has."""

    names: Annotated[Any, PlainValidator(_names)]
    matrix: Annotated[Any, PlainValidator(_matrix)]


def _correlations(source: str, given: Any, counts: Mapping[str, int]) -> Correlations:
    if not isinstance(given, dict) or set(given) != set(_CorrelationTable.model_fields):
        raise ModelError(f"{source}: correlations: expected the keys names and matrix")
    try:
        table = _CorrelationTable.model_validate(given, context=dict(counts))
    except ValidationError as error:
        raise _refused(source, "correlations.", _CorrelationTable, error) from error
    return Correlations(table.names, table.matrix)


# ---- refusals


def _refused(source: str, place: str, table: type[StrictTable], error: ValidationError) -> ModelError:
    """The first finding, unknown keys before all others: a misspelt key explains what is missing."""
    found = sorted(findings(error), key=lambda f: f.kind != "unknown")
    return ModelError(f"{source}: {_words(place, table, found[0])}")


def _words(place: str, table: type[StrictTable], f: SchemaFinding) -> str:
    expected = {field.alias or name: field.description for name, field in table.model_fields.items()}
    key = f.key.removesuffix("_")  # of a field whose name Python or pydantic keeps
    if f.kind == "unknown":
        return f"unknown key {place}{f.key}; expected some of {', '.join(sorted(expected))}"
    if f.kind == "missing":
        return f"{place}{key} is missing: {expected[key]}"
    if f.code == "refused":
        return f"{place}{key}{f.why}"
    return f"{place}{key} = {f.given!r}; expected {expected[key]}"
