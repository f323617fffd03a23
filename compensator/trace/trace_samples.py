"""samples.csv of a trace: index, what was read, and whatever else was taken down with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.errors import TraceError
from stiffness.schema import meant
from stiffness.session.path_trace import CommandedRows, TraceKind
from stiffness.session.table import CsvTable

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

READ: dict[TraceKind, tuple[str, ...]] = {
    "positions": ("x", "y", "z"),
    "ballbar": ("radius",),
    "surface": ("x", "y", "z", "i", "j", "k", "deviation"),
}
OPTIONAL = ("run", "time", "temperature", "sd")
FAR = 50e3  # mm: nothing that a robot does is farther away
DEVIATES = 20.0  # mm: no part is cut so far from where it was to be


@dataclass(frozen=True, repr=False, eq=False)
class TraceSamples:
    """N readings, in SI; see ``PathTrace`` and ``Samples``. NaN where a column is not there.

    Attributes:
        read: (N, c) m, what the kind of trace has: x y z; radius; x y z and deviation. normal: (N, 3) of a surface.
        index: (N,) None: points of a surface, or of a stream, whose poses are not told.
        along: (N, 3) m, what is not known of a stream along its path; zero elsewhere.
    """

    line: Ints
    index: Floats | None
    run: Ints
    read: Floats
    normal: Floats
    time: Floats
    temperature: Floats
    sd: Floats
    extra: Mapping[str, Floats]
    not_numeric: tuple[str, ...]
    along: Floats

    def __len__(self) -> int:
        return len(self.line)

    def __repr__(self) -> str:
        return f"TraceSamples({len(self)} readings)"

    def take(self, rows: Ints) -> TraceSamples:
        """Some of the readings."""
        mine: dict[str, Any] = {
            name: getattr(self, name)[rows]
            for name in ("line", "run", "read", "normal", "time", "temperature", "sd", "along")
        }
        extra = {name: column[rows] for name, column in self.extra.items()}
        index = None if self.index is None else self.index[rows]
        return TraceSamples(**mine, index=index, extra=extra, not_numeric=self.not_numeric)


def read_trace_samples(table: CsvTable, kind: TraceKind, rows: CommandedRows, noise: float) -> TraceSamples:
    """The readings of a trace.

    Args:
        noise: m, of a single reading, where the file has no ``sd``.

    Raises:
        TraceError, SessionError: names file, row, column, value and what to do.
    """
    known = _check_columns(table, kind)
    given = table.numbers(READ[kind])
    if kind == "surface":
        length = np.linalg.norm(given[:, 3:6], axis=1)
        table.refuse(np.abs(length - 1) > 1e-2, ["i"], "i, j, k is a normal of length 1, out of the part")
        table.refuse(np.abs(given[:, 6]) > DEVIATES, ["deviation"], f"farther than {DEVIATES:g} mm: mm are expected")
        given[:, 3:6] /= length[:, None]
    if kind == "ballbar":
        table.refuse(given[:, 0] <= 0, ["radius"], "expected a length, mm, and no deviation from one")
    table.refuse(np.abs(given) > FAR, READ[kind], f"beyond {FAR:g} mm: mm are expected")
    extra = {name: table.numeric(name) for name in table.cells if name not in known}
    sd = _optional(table, "sd") / 1e3
    table.refuse(sd <= 0, ["sd"], "a standard deviation is above zero, mm")
    temperature = _optional(table, "temperature")
    table.refuse((temperature < -60) | (temperature > 150), ["temperature"], "not deg C of a robot; kelvin?")
    run = table.integers(["run"])[:, 0] if "run" in table.cells else np.zeros(len(table.line), dtype=np.int64)
    lengths = given[:, [0, 1, 2, 6]] if kind == "surface" else given
    return TraceSamples(
        line=table.line,
        index=_index(table, rows),
        run=run,
        read=lengths / 1e3,
        normal=given[:, 3:6] if kind == "surface" else np.zeros((len(given), 3)),
        time=_optional(table, "time"),
        temperature=temperature,
        sd=np.where(np.isfinite(sd), sd, noise),
        extra={name: values for name, values in extra.items() if values is not None},
        not_numeric=tuple(name for name, values in extra.items() if values is None),
        along=np.zeros((len(given), 3)),
    )


def _check_columns(table: CsvTable, kind: TraceKind) -> set[str]:
    known = {"index", *READ[kind], *OPTIONAL}
    for name in table.cells:
        if name not in known and name.lower() in known:
            raise TraceError(f"{table.label}: column {name}: write {name.lower()}")
    needed = ("index", *READ[kind]) if kind == "ballbar" else READ[kind]
    missing = [name for name in needed if name not in table.cells]
    if missing:
        hint = meant(missing[0], [name for name in table.cells if name not in known])
        rows = "; the row of the program, from 0, of every reading: a length alone has no shape to be matched by"
        remedy = hint or (rows if missing == ["index"] else "; add it")
        raise TraceError(f"{table.label}: column {', '.join(missing)} missing, of kind = {kind!r}{remedy}")
    return known


def _index(table: CsvTable, rows: CommandedRows) -> Floats | None:
    if "index" not in table.cells:
        return None
    index = table.numbers(["index"])[:, 0]
    last = len(rows) - 1
    table.refuse((index < 0) | (index > last), ["index"], f"the program has the rows 0 ... {last}, counted from 0")
    low = np.floor(index).astype(np.int64)
    between = low != index
    mixed = between & (rows.cut[low] != rows.cut[np.minimum(low + 1, last)])
    why = "lies between a rapid and a cut, where the wrench is not known; give the row, or a fraction within a cut"
    table.refuse(mixed, ["index"], why)
    return index


def _optional(table: CsvTable, name: str) -> Floats:
    return table.numbers([name])[:, 0] if name in table.cells else np.full(len(table.line), np.nan)
