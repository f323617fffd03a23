"""trace.toml of schema ``trace/1``: how a program that ran was measured, in the units of the file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, Strict, ValidationError, model_validator

from compensator.errors import TraceError
from compensator.toml_table import Number, Three, TomlTable, refuse_metres
from stiffness.schema import findings, meant
from stiffness.text_file import toml_table

SCHEMA = "trace/1"
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict(), Field(min_length=1)]


class InstrumentTable(TomlTable):
    """``noise``: one sigma of a single reading, mm: of a length, along a normal, per axis of a position.

    ``latency``: s: a reading shows where the arm was so much before its row; estimated where it is not given.
    """

    noise: Number = Field(gt=0, le=10)
    latency: Number | None = Field(default=None, ge=-10, le=10)


class BallbarTable(TomlTable):
    """A ball-bar: mm, base; angles in deg, lengths expand by ``expansion_per_k`` from 20 deg C."""

    center: Three
    radius: Number = Field(gt=0, le=5000)
    calibrated: Flag = False
    length_sd: Number = Field(default=0.0, ge=0, le=1)
    temperature: Number | None = Field(default=None, ge=-50, le=150)
    expansion_per_k: Number | None = Field(default=None, ge=0, le=1e-3)
    start_angle: Number | None = None
    overshoot: Number | None = Field(default=None, ge=0, le=360)
    data_arc: Number | None = Field(default=None, gt=0, le=360)

    @model_validator(mode="after")
    def _units(self) -> BallbarTable:
        refuse_metres("ballbar.center", self.center)
        refuse_metres("ballbar.radius", (self.radius, 0.0, 0.0))
        if (self.temperature is None) != (self.expansion_per_k is None):
            raise ValueError("temperature and expansion_per_k belong together: give both, or neither")
        return self


class ProbeTable(TomlTable):
    """A touch probe. ``calibrated`` false: one offset along all normals is estimated; ``offset_sd`` mm, of it."""

    calibrated: Flag
    offset_sd: Number = Field(default=0.05, gt=0, le=5)


class TraceFile(TomlTable):
    """A trace/1 file, checked key by key; ``source``: as the user named it, ``folder``: paths are relative to it."""

    schema_: Literal["trace/1"] = Field(alias="schema")
    cell: Text
    program: Text
    samples: Text
    kind: Literal["positions", "ballbar", "surface"]
    registered: Flag = True
    dry: Flag = False
    approach: tuple[int, ...] | None = None
    instrument: InstrumentTable
    ballbar: BallbarTable | None = None
    probe: ProbeTable | None = None
    source: str = Field(default="", exclude=True)
    folder: Path = Field(default=Path(), exclude=True)

    @model_validator(mode="after")
    def _belongs_together(self) -> TraceFile:
        if self.kind == "ballbar" and self.ballbar is None:
            raise ValueError("kind = 'ballbar' needs [ballbar] with center and radius, mm in the base")
        if self.kind != "ballbar" and self.ballbar is not None:
            raise ValueError(f"[ballbar] with kind = {self.kind!r}: take it out, or set kind = 'ballbar'")
        if self.kind != "surface" and self.probe is not None:
            raise ValueError(f"[probe] with kind = {self.kind!r}: it is of a surface that was touched; take it out")
        if self.kind == "ballbar" and "registered" in self.model_fields_set:
            raise ValueError("registered is not of a ball-bar, whose centre is estimated; take it out")
        if any(sign not in (-1, 0, 1) for sign in self.approach or ()):
            raise ValueError(f"approach = {list(self.approach or ())}: expected -1, 0 (unknown) or 1 per joint")
        return self


def read_trace_file(path: str | Path) -> TraceFile:
    """The table of a trace.

    Raises:
        TraceError: names the file, the key, the value and what was expected, all findings in one message.
    """
    label = str(path)
    table = toml_table(label, Path(path), TraceError, schema=SCHEMA)
    for reserved in ("source", "folder", "schema_"):
        if reserved in table:
            raise TraceError(f"{label}: unknown key {reserved}")
    try:
        return TraceFile.model_validate({"schema": None, **table, "source": label, "folder": Path(path).parent})
    except ValidationError as e:
        words = []
        for f in findings(e):
            near = meant(f.key.rpartition(".")[2], _KEYS, 0.7) if f.kind == "unknown" else ""
            why = f"{f.key or 'the file as a whole'}: {f.why}" if isinstance(f.given, dict) else str(f)
            words.append(f"{why if f.kind == 'wrong' else f}{near}")
        raise TraceError(f"{label}: {'; '.join(words)}; docs/traces.md lists the keys") from e


_KEYS = {
    name if field.alias is None else field.alias
    for table in (TraceFile, InstrumentTable, BallbarTable, ProbeTable)
    for name, field in table.model_fields.items()
}
