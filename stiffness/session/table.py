"""A table of readings as text: header, cells, and messages that name the file, the row and the column."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from stiffness.errors import StiffnessError
from stiffness.text_file import decoded

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


class SessionError(StiffnessError):
    """A measurement session is refused. The message names file, row, column, value and remedy."""


@dataclass(frozen=True, repr=False, eq=False)
class CsvTable:
    """Cells of a csv file, column by column.

    Attributes:
        label: what messages call the file.
        cells: column -> N cells, stripped.
        line: (N,) line of each row in the file; the header is line 1.
    """

    label: str
    cells: dict[str, tuple[str, ...]]
    line: Ints

    def __repr__(self) -> str:
        return f"CsvTable({self.label!r}, {len(self.line)} rows, {len(self.cells)} columns)"

    def has(self, names: Sequence[str]) -> bool:
        """Whether all columns of a family are there; refused when only some of them are."""
        missing = [name for name in names if name not in self.cells]
        if missing and len(missing) < len(names):
            there = [name for name in names if name in self.cells]
            raise SessionError(
                f"{self.label}: column {', '.join(missing)} missing beside {', '.join(there)}: they belong "
                "together; give all of them or none"
            )
        return not missing

    def numbers(self, names: Sequence[str]) -> Floats:
        """(N, len(names)) finite numbers."""
        return np.column_stack([self._floats(name) for name in names])

    def integers(self, names: Sequence[str]) -> Ints:
        """(N, len(names)) integers."""
        values = self.numbers(names)
        whole = np.rint(values)
        self.refuse((values != whole) | (np.abs(values) > 2**53), names, "expected an integer")
        return whole.astype(np.int64)

    def numeric(self, name: str) -> Floats | None:
        """(N,) finite numbers, or None where a cell is none."""
        try:
            values = np.array([float(cell) for cell in self.cells[name]])
        except ValueError:
            return None
        return values if np.isfinite(values).all() else None

    def refuse(self, bad: Bools, names: Sequence[str], why: str) -> None:
        """Refuse the first bad cell of bad (N, len(names)) or (N,); ``why``: what to do."""
        rows, columns = np.nonzero(bad.reshape(len(self.line), -1))
        if len(rows):
            more = len(np.unique(rows)) - 1
            tail = f" (and {more} more row{'s' if more > 1 else ''})" if more else ""
            self.fail(int(rows[0]), names[int(columns[0])], why + tail)

    def fail(self, row: int, name: str, why: str) -> NoReturn:
        """Raise with file, line, column and cell."""
        cell = self.cells[name][row]
        raise SessionError(f"{self.label}: row {self.line[row]}, column {name} = {cell!r}: {why}")

    def _floats(self, name: str) -> Floats:
        values = np.empty(len(self.line))
        for row, cell in enumerate(self.cells[name]):
            try:
                values[row] = float(cell)
            except ValueError:
                self.fail(row, name, "not a number; " + _remedy(cell))
            if "_" in cell:
                self.fail(row, name, "not a number; write it without '_'")
        self.refuse(~np.isfinite(values), [name], "not a finite number; take the row out or correct it")
        return values


def _remedy(cell: str) -> str:
    if not cell:
        return "the cell is empty: fill it or take the row out"
    if "," in cell:
        return "write decimals with a point"
    return "correct it or take the row out"


def read_table(label: str, raw: bytes) -> CsvTable:
    """Read comma-separated text with a header line; BOM and every kind of line end are fine.

    Raises:
        SessionError: not UTF-8, not comma-separated, no rows, rows of another length than the header.
    """
    reader = csv.reader(io.StringIO(decoded(label, raw, SessionError), newline=None), strict=True)
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        header = [name.strip() for name in next(reader, [])]
        for row in reader:
            if any(cell.strip() for cell in row):
                rows.append(row)
                lines.append(reader.line_num)
    except csv.Error as error:
        raise SessionError(f"{label}: row {reader.line_num}: not csv: {error}") from error
    _check_header(label, header)
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(header):
            comma = "; are decimals written with a comma?" if len(row) > len(header) else ""
            raise SessionError(f"{label}: row {line}: {len(row)} cells, expected {len(header)} as in the header{comma}")
    if not rows:
        raise SessionError(f"{label}: no row below the header: a session needs readings")
    columns = [tuple(cell.strip() for cell in column) for column in zip(*rows, strict=True)]
    return CsvTable(label, dict(zip(header, columns, strict=True)), np.array(lines))


def _check_header(label: str, header: list[str]) -> None:
    if not any(header):
        raise SessionError(f"{label}: the first line is empty: expected a header line with column names")
    if len(header) == 1:
        for mark, word in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars"), (" ", "blanks")):
            if mark in header[0]:
                raise SessionError(f"{label}: row 1: cells are separated by {word}; separate them by commas")
    if "" in header:
        raise SessionError(f"{label}: row 1: column {header.index('') + 1} has no name; give it one or take it out")
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise SessionError(f"{label}: row 1: column {', '.join(twice)} stands there twice; take one out")
