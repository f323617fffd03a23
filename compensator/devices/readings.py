"""What a device wrote, as it stands in its file: points and numbers in the file's own unit and frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpaths.finding import Finding

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Rows = npt.NDArray[np.intp]

#: Kinds of a trace.
POSITIONS, BALLBAR, SURFACE = KINDS = ("positions", "ballbar", "surface")


@dataclass(frozen=True)
class DeviceFile:
    """A file of a device.

    Attributes:
        label: what messages call it. text: its content. columns: name in the trace -> heading of the column or a
            number, as the command line maps a csv.
    """

    label: str
    text: str
    columns: Mapping[str, str] = field(default_factory=dict)

    @property
    def lines(self) -> list[str]:
        """Its lines, without their ends; the first is line 1."""
        return self.text.splitlines()

    @property
    def suffix(self) -> str:
        """Of its name, in small letters."""
        return Path(self.label).suffix.lower()


@dataclass(frozen=True, repr=False)
class DeviceReadings:
    """The readings of a file, N of them; NaN: the file has no such number.

    Attributes:
        source: the file. device: name of the entry in the table. kind: one of KINDS.
        to_mm: mm in a unit of its lengths; None: the file does not tell.
        frame: what the file calls the frame of its points; empty: it has no name.
        name, group: (N,) of a point, and of what it belongs to.
        line: (N,) in the file, counted from 1.
        nominal, measured: (N, 3) lengths. normal: (N, 3) outward, unit.
        deviation: (N,) length along the normal, positive where material was left.
        radius: (N,) length, of a ball-bar. sd: (N,) length. time: (N,) s. index, run: (N,).
        low, high: (N,) limits of the deviation.
        columns: further columns by name, (N,) each.
        needs_free_frame: why its points cannot stand in the frame that the cell knows; empty: they can.
        findings: what was left out and what was taken for granted.
    """

    source: str
    device: str
    kind: str
    to_mm: float | None
    frame: str
    name: tuple[str, ...]
    group: tuple[str, ...]
    line: Ints
    nominal: Floats
    measured: Floats
    normal: Floats
    deviation: Floats
    radius: Floats
    sd: Floats
    time: Floats
    index: Floats
    run: Floats
    low: Floats
    high: Floats
    columns: Mapping[str, Floats] = field(default_factory=dict)
    needs_free_frame: str = ""
    findings: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        return f"DeviceReadings({self.source!r}, {self.device}, {len(self)} {self.kind})"

    def __len__(self) -> int:
        return len(self.line)

    def take(self, rows: Rows, *more: Finding) -> DeviceReadings:
        """Some of the readings, with further findings."""
        arrays = {f.name: getattr(self, f.name) for f in fields(self)}
        taken: dict[str, Any] = {name: a[rows] for name, a in arrays.items() if isinstance(a, np.ndarray)}
        return replace(
            self,
            name=tuple(self.name[k] for k in rows),
            group=tuple(self.group[k] for k in rows),
            columns={name: values[rows] for name, values in self.columns.items()},
            findings=(*self.findings, *more),
            **taken,
        )

    def at(self, row: int) -> str:
        """Where a reading stands, for messages."""
        return f"{self.source}: line {self.line[row]}"

    def place(self, row: int) -> str:
        """The same, for findings."""
        return f"{self.source}:{self.line[row]}"


def readings(
    file: DeviceFile,
    device: str,
    *,
    kind: str,
    line: list[int],
    to_mm: float | None,
    frame: str = "",
    name: list[str] | None = None,
    group: list[str] | None = None,
    columns: Mapping[str, Floats] | None = None,
    needs_free_frame: str = "",
    findings: tuple[Finding, ...] = (),
    numbers: Mapping[str, npt.ArrayLike],
) -> DeviceReadings:
    """Readings of N lines; ``numbers``: those of DeviceReadings by name, NaN for every one that is not given."""
    count = len(line)
    empty = {
        key: np.full((count, 3) if key in ("nominal", "measured", "normal") else count, np.nan)
        for key in _NUMBERS
    }
    given = {
        key: np.asarray(value, dtype=float).reshape(empty[key].shape) for key, value in numbers.items()
    }
    return DeviceReadings(
        source=file.label,
        device=device,
        kind=kind,
        to_mm=to_mm,
        frame=frame,
        name=tuple(name or [""] * count),
        group=tuple(group or [""] * count),
        line=np.array(line, dtype=np.int64),
        columns=columns or {},
        needs_free_frame=needs_free_frame,
        findings=findings,
        **{**empty, **given},
    )


_NUMBERS = (
    "nominal", "measured", "normal", "deviation", "radius", "sd", "time", "index", "run", "low", "high"
)  # fmt: skip
