"""Columns of text: a heading line, then a row per reading; between them commas, semicolons, tabs or wide spaces."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.devices.numbers import MM_IN, is_number, number
from compensator.devices.readings import BALLBAR, POSITIONS, SURFACE, DeviceFile, DeviceReadings, readings
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, Finding

Floats = npt.NDArray[np.float64]

NAME = "csv"
XYZ, NORMAL, MEASURED = ("x", "y", "z"), ("i", "j", "k"), ("mx", "my", "mz")
LENGTHS = (*XYZ, *MEASURED, "deviation", "radius", "sd")
KNOWN = (*LENGTHS, *NORMAL, "index", "run", "time", "temperature", "name")
OWN = ("deviation", "radius", "sd", "time", "index", "run")
SECONDS = {"s": 1.0, "ms": 1e-3, "min": 60.0}
PREAMBLE = 60  # lines that a heading is looked for in
_UNIT = re.compile(r"(.*?)[\s_]*[\[(]?([A-Za-zµμ\"]+)[\])]?$")


class _Table(NamedTuple):
    """Cells of a file below its heading."""

    heading: list[str]
    at: int
    lines: list[int]
    rows: list[list[str]]


class _Column(NamedTuple):
    """Where a column of the trace comes from: heading or constant, and the unit that the heading has."""

    heading: str
    cells: list[str]
    unit: str


def recognised(file: DeviceFile) -> bool:
    """By a heading that has the columns of a trace, or those that the command line maps."""
    try:
        return bool(file.columns) or _found(file) is not None
    except DeviceError:
        return False


def read(file: DeviceFile) -> DeviceReadings:
    """The rows of a table; its kind by its columns: a radius (or a deviation alone), a normal, else positions.

    Raises:
        DeviceError: no heading, a column that is not there, a cell that is no number, units that differ.
    """
    table = _found(file)
    if table is None:
        wanted = ", ".join(file.columns.values()) or "x, y, z; radius; or x ... k, deviation"
        raise DeviceError(
            f"{file.label}: no heading line with {wanted} in its first {PREAMBLE} lines; name the columns: "
            '--column x="Heading of x" --column y=... (--column z=0 gives a constant)'
        )
    columns = _columns(file, table)
    numbers = {name: _numbers(file, name, c, table.lines) for name, c in columns.items() if name != "name"}
    kind = _kind(file, columns)
    to_mm = _unit(file, columns)
    if to_mm is not None:  # converted below: nothing is left to ask for
        for name in LENGTHS:
            if name in numbers:
                numbers[name] = numbers[name] * MM_IN[columns[name].unit or "mm"] / to_mm
    if "time" in numbers:
        numbers["time"] = numbers["time"] * SECONDS.get(columns["time"].unit, 1.0)
    points = np.column_stack([numbers[k] for k in XYZ]) if kind != BALLBAR else None
    place = {} if points is None else {"measured" if kind == POSITIONS else "nominal": points}
    if kind == SURFACE:
        place["normal"] = np.column_stack([numbers[k] for k in NORMAL])
        if "mx" in numbers:
            place["measured"] = np.column_stack([numbers[k] for k in MEASURED])
    own: dict[str, Floats] = {k: numbers[k] for k in OWN if k in numbers}
    return readings(
        file,
        NAME,
        kind=kind,
        line=table.lines,
        to_mm=to_mm,
        name=list(columns["name"].cells) if "name" in columns else None,
        columns={k: v for k, v in numbers.items() if k not in KNOWN or k == "temperature"},
        findings=tuple(_left_out(file, table, columns)),
        numbers={**place, **own},
    )


def _found(file: DeviceFile) -> _Table | None:
    """The table below the first line that has the headings."""
    lines = file.lines
    for at, text in enumerate(lines[:PREAMBLE]):
        for mark in (";", "\t", ",", None):
            heading = _cells(text, mark)
            if len(heading) > 1 and _is_heading(file.columns, heading):
                return _body(file, lines, at, heading, mark=mark)
    return None


def _cells(text: str, mark: str | None) -> list[str]:
    if mark is None:
        return re.split(r"\s{2,}|\t", text.strip())
    return [cell.strip() for cell in next(csv.reader([text], delimiter=mark), [])]


def _is_heading(wanted: Mapping[str, str], heading: Sequence[str]) -> bool:
    headings = [h for h in wanted.values() if not is_number(h)]
    if headings:
        return all(h in heading for h in headings)
    names = {_split(h)[0] for h in heading}
    return "radius" in names or {"index", "deviation"} <= names or set(XYZ) <= names


def _split(heading: str) -> tuple[str, str]:
    """Name and unit of ``x_mm``, ``X [mm]``, ``Radius (inch)``; the unit is empty where there is none."""
    found = _UNIT.match(heading.strip())
    if found and found[1] and (found[2].lower() in MM_IN or found[2].lower() in SECONDS or found[2] == "C"):
        return found[1].strip(" _").lower(), found[2].lower()
    return heading.strip().lower(), ""


def _body(file: DeviceFile, lines: list[str], at: int, heading: list[str], *, mark: str | None) -> _Table:
    rows, numbers = list[list[str]](), list[int]()
    for n, text in enumerate(lines[at + 1 :], at + 2):
        if not text.strip():
            continue
        cells = text.split() if mark is None else _cells(text, mark)
        if len(cells) != len(heading):
            hint = "; decimals are written with a point" if mark == "," and len(cells) > len(heading) else ""
            why = f"{len(cells)} values, the heading at line {at + 1} has {len(heading)}{hint}: correct the row"
            raise DeviceError(f"{file.label}: line {n}: {why}")
        rows.append([re.sub(r"^([-+]?\d+),(\d+)$", r"\1.\2", c) for c in cells] if mark in (";", "\t") else cells)
        numbers.append(n)
    if not rows:
        raise DeviceError(f"{file.label}: no row below the heading at line {at + 1}")
    return _Table(heading, at + 1, numbers, rows)


def _columns(file: DeviceFile, table: _Table) -> dict[str, _Column]:
    """By name in the trace."""
    chosen = dict(file.columns) or {n: h for h in table.heading if (n := _split(h)[0]) in KNOWN}
    doubled = next((h for h in chosen.values() if table.heading.count(h) > 1), None)
    if doubled is not None:
        raise DeviceError(f"{file.label}: line {table.at}: column {doubled!r} stands twice; keep one of them")
    out = {}
    for name, heading in chosen.items():
        if heading in table.heading:
            k = table.heading.index(heading)
            out[name] = _Column(heading, [row[k] for row in table.rows], _split(heading)[1])
        else:  # a number: _is_heading found all the others
            out[name] = _Column(heading, [heading] * len(table.rows), "")
    return out


def _numbers(file: DeviceFile, name: str, column: _Column, lines: list[int]) -> Floats:
    what = f"column {column.heading!r} ({name})"
    return np.array([number(c, file.label, n, what) for c, n in zip(column.cells, lines, strict=True)])


def _kind(file: DeviceFile, columns: Mapping[str, _Column]) -> str:
    if "radius" in columns or ("deviation" in columns and not {*XYZ, *NORMAL} & set(columns)):
        return BALLBAR
    surface = [k for k in (*NORMAL, *MEASURED, "deviation") if k in columns]
    wanted = [*XYZ, *(NORMAL if surface else ())]
    missing = [k for k in wanted if k not in columns]
    if surface and "deviation" not in columns:
        missing += [k for k in MEASURED if k not in columns] and ["deviation (or mx, my, mz)"]
    if missing:
        kind = "surface points" if surface else "positions"
        why = f"{kind} lack {', '.join(missing)}: give --column NAME=HEADING for each, or NAME=NUMBER for a constant"
        raise DeviceError(f"{file.label}: {why}")
    return SURFACE if surface else POSITIONS


def _unit(file: DeviceFile, columns: Mapping[str, _Column]) -> float | None:
    """1 where the headings have units of length, None where they have none."""
    units = {c.heading: c.unit for name, c in columns.items() if name in LENGTHS and not is_number(c.heading)}
    strange = next((h for h, unit in units.items() if unit and unit not in MM_IN), None)
    bare = [h for h, unit in units.items() if not unit]
    if strange is not None or (bare and len(bare) < len(units)):
        which = strange or ", ".join(bare)
        why = f"unit of column {which}: expected one of mm, inch, um, m, as the other columns of length have it"
        raise DeviceError(f"{file.label}: {why}; write it into the heading, such as x_mm")
    return None if bare else 1.0


def _left_out(file: DeviceFile, table: _Table, columns: Mapping[str, _Column]) -> Iterator[Finding]:
    used = {c.heading for c in columns.values()}
    left = [h for h in table.heading if h not in used]
    if left:
        what = f"columns that no trace has are left out: {', '.join(left)}"
        yield Finding(NOTE, f"{file.label}:{table.at}", what, "--column NAME=HEADING keeps one as a regressor")
