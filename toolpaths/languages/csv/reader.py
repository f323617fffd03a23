"""CSV poses: a header line, then a row per pose in the work-object frame, mm and mm/min."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.languages.csv.header import AXIS, POSITION, QUATERNION, UNIT_TOLERANCE, refuse_headerless
from toolpaths.reading.source_text import load_lines
from toolpaths.reading.track import LIMIT
from toolpaths.toolpath import (
    CLOCKWISE,
    COUNTERCLOCKWISE,
    CUT,
    RAPID,
    SENSE_OPEN,
    Floats,
    Ints,
    Senses,
    Toolpath,
    tool_axis,
)

OPTIONAL = ("feed_mm_min", "kind", "spindle_rpm", "spindle")
TEXT = ("kind", "spindle")
MAY_BE_EMPTY = ("feed_mm_min", "spindle_rpm")  # as at rapids: 0
KINDS = ("rapid", "cut")
SENSES = {"m3": CLOCKWISE, "m4": COUNTERCLOCKWISE, "m5": SENSE_OPEN}


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a CSV file; ``chord`` is not needed, there are no arcs."""
    lines = load_lines(path, source)
    columns = _columns(lines[0], source)
    rows = [n for n in range(1, len(lines)) if lines[n].strip()]
    if not rows:
        raise ReadError(source, None, "there is no pose, only the header line", "Add a row per pose.")
    table = _parse(lines, rows, columns, source)
    line = np.array(rows, dtype=np.int32) + 1
    _check_numbers(table, columns, line, source)
    kind = _kinds(table, line=line, lines=lines, columns=columns, source=source)
    spindle, sense = _spindle(table, line, source)
    quaternion = None
    if "qw" in columns:
        quaternion = _unit(table, QUATERNION, line, source)
        axis = tool_axis(quaternion)
    else:
        axis = _unit(table, AXIS, line, source)
    return Toolpath(
        source=source,
        language="csv",
        position=np.column_stack([table[name] for name in POSITION]) * 1e-3,
        axis=axis,
        quaternion=quaternion,
        feed=_feeds(table, kind, line, source),
        kind=kind,
        tool=np.zeros(len(line), dtype=np.int32),
        spindle=spindle,
        sense=sense,
        line=line,
        row=np.arange(len(line), dtype=np.float64),
    )


def _columns(header: str, source: str) -> list[str]:
    names = [name.strip().strip('"').strip() for name in header.split(",")]
    if len(names) == 1 and any(name.strip(' "') in POSITION for name in re.split(r"[;\t]", header)):
        problem = "the columns are not separated by commas"
        raise ReadError(source, 1, problem, "Export with ',' between columns and '.' in numbers.")
    refuse_headerless(header, source)
    known = (*POSITION, *AXIS, *QUATERNION, *OPTIONAL)
    for name in names:
        if name not in known:
            raise ReadError(source, 1, f"unknown column {name!r}", f"Known: {', '.join(known)}.")
        if names.count(name) > 1:
            raise ReadError(source, 1, f"column {name!r} stands twice", "Keep one of them.")
    given = [group for group in (AXIS, QUATERNION) if any(name in names for name in group)]
    if len(given) > 1:
        raise ReadError(source, 1, "both i,j,k and qw,qx,qy,qz are given", "Keep one of the two.")
    if missing := [name for name in (*POSITION, *(given[0] if given else AXIS)) if name not in names]:
        either = "" if given else " (or qw, qx, qy, qz instead of i, j, k)"
        problem = f"missing column {', '.join(missing)}{either}"
        raise ReadError(source, 1, problem, "Name it in the header line.")
    return names


def _parse(lines: list[str], rows: list[int], columns: list[str], source: str) -> npt.NDArray[Any]:
    """The body as a structured array; numpy's C parser reads it, a slow look finds the cell it stops at."""
    dtype = [(name, "U12" if name in TEXT else "f8") for name in columns]
    body = lines[rows[0] : rows[-1] + 1] if len(rows) == rows[-1] - rows[0] + 1 else [lines[n] for n in rows]
    try:
        return np.atleast_1d(np.loadtxt(body, dtype=dtype, delimiter=",", comments=None, quotechar='"'))
    except (ValueError, OverflowError) as problem:
        optional = [columns.index(name) for name in MAY_BE_EMPTY if name in columns]
        if optional and (filled := _filled(body, optional)) != body:
            return _parse([*lines[: rows[0]], *filled], list(range(rows[0], rows[0] + len(filled))), columns, source)
        _blame(lines, rows=rows, columns=columns, source=source, problem=str(problem))


def _filled(body: list[str], optional: list[int]) -> list[str]:
    """Rows with 0 where a cell of these columns is left empty."""
    rows = [line.split(",") for line in body]
    for cells in rows:
        for k in optional:
            if k < len(cells) and not cells[k].strip():
                cells[k] = "0"
    return [",".join(cells) for cells in rows]


def _blame(lines: list[str], rows: list[int], columns: list[str], source: str, problem: str) -> NoReturn:
    for n in rows:
        cells = [cell.strip().strip('"').strip() for cell in lines[n].split(",")]
        if cells == columns:
            raise ReadError(source, n + 1, "the header line again: two files in one", "Give one file each.")
        if len(cells) != len(columns):
            remedy = "Numbers need '.' as decimal sign; the last row may be cut off."
            raise ReadError(source, n + 1, f"{len(cells)} values, the header has {len(columns)}", remedy)
        for name, cell in zip(columns, cells, strict=True):
            if name in TEXT:
                continue
            try:
                float(cell)
            except ValueError:
                shown = repr(cell[:40]) if cell else "an empty cell"
                raise ReadError(source, n + 1, f"column {name}: {shown} is not a number") from None
    raise ReadError(source, None, f"cannot be read as numbers: {problem[:200]}")


def _check_numbers(table: npt.NDArray[Any], columns: list[str], line: Ints, source: str) -> None:
    for name in columns:
        if name in TEXT:
            continue
        value = table[name]
        if (bad := np.flatnonzero(~np.isfinite(value))).size:
            problem = f"column {name}: {value[bad[0]]} is not a finite number"
            raise ReadError(source, int(line[bad[0]]), problem)
        bound = LIMIT * 1e3 if name in POSITION else 1e9
        if (bad := np.flatnonzero(np.abs(value) > bound)).size:
            problem = f"column {name}: {value[bad[0]]:g} is beyond {bound:g}"
            raise ReadError(source, int(line[bad[0]]), problem, "Check the number and the units.")


def _kinds(
    table: npt.NDArray[Any], line: Ints, lines: list[str], columns: list[str], source: str
) -> npt.NDArray[np.uint8]:
    if "kind" not in columns:
        return np.full(len(line), CUT)
    word = np.char.strip(table["kind"])
    if (bad := np.flatnonzero(~np.isin(word, KINDS))).size:
        at = int(line[bad[0]])
        shown = lines[at - 1].split(",")[columns.index("kind")].strip()
        raise ReadError(source, at, f"column kind: {shown!r}", "Write rapid or cut.")
    return np.where(word == "cut", CUT, RAPID).astype(np.uint8)


def _unit(table: npt.NDArray[Any], names: tuple[str, ...], line: Ints, source: str) -> Floats:
    vector = np.column_stack([table[name] for name in names])
    norm = np.linalg.norm(vector, axis=1)
    if (bad := np.flatnonzero(np.abs(norm - 1.0) > UNIT_TOLERANCE)).size:
        at, what = bad[0], ", ".join(names)
        problem = f"columns {what}: length {norm[at]:.6g}, 1 expected"
        raise ReadError(source, int(line[at]), problem, f"Give a unit vector (within {UNIT_TOLERANCE:g}).")
    unit: Floats = vector / norm[:, None]
    return unit


def _feeds(table: npt.NDArray[Any], kind: npt.NDArray[np.uint8], line: Ints, source: str) -> Floats:
    """m/s; a rapid's 0 means none."""
    if "feed_mm_min" not in (table.dtype.names or ()):
        return np.full(len(line), np.nan)
    feed = table["feed_mm_min"]
    if (bad := np.flatnonzero((feed < 0) | ((feed == 0) & (kind == CUT)))).size:
        problem = f"column feed_mm_min: {feed[bad[0]]:g}, above 0 expected"
        raise ReadError(source, int(line[bad[0]]), problem)
    return np.where(feed > 0, feed, np.nan) / 60e3


def _spindle(table: npt.NDArray[Any], line: Ints, source: str) -> tuple[Floats, Senses]:
    """rad/s and sense; an empty cell gives none, m5 is a spindle that stands."""
    given = table.dtype.names or ()
    word = np.char.lower(np.char.strip(table["spindle"])) if "spindle" in given else np.full(len(table), "")
    if (bad := np.flatnonzero(~np.isin(word, ["", *SENSES]))).size:
        problem = f"column spindle: {str(word[bad[0]])!r}"
        raise ReadError(source, int(line[bad[0]]), problem, "Write m3, m4 or m5, or leave it empty.")
    rpm = table["spindle_rpm"] if "spindle_rpm" in given else np.zeros(len(table))
    if (bad := np.flatnonzero(rpm < 0)).size:
        problem = f"column spindle_rpm: {rpm[bad[0]]:g}, a speed from 0 on is expected"
        raise ReadError(source, int(line[bad[0]]), problem, "The sense is m3 or m4 in the column spindle.")
    speed = np.where(rpm > 0, rpm, np.nan) * (2.0 * np.pi / 60.0)
    sense = np.select([word == name for name in SENSES], list(SENSES.values()), SENSE_OPEN)
    return np.where(word == "m5", 0.0, speed), sense.astype(np.int8)
