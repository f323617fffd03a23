"""Candidates: where the work object may stand; a box with counts, or a list."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.cell.placement_tables import WorkObjectTable
from compensator.errors import CompensatorError
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_rpy

Floats = npt.NDArray[np.float64]

AXES = ("x", "y", "z", "roll", "pitch", "yaw")
COLUMNS = ("x_mm", "y_mm", "z_mm", "roll_deg", "pitch_deg", "yaw_deg")
MOST = 10_000_000
NEAR = 10.0  # mm: what stands no farther from the base in x, y and z was meant in m


@dataclass(frozen=True, eq=False, repr=False)
class Candidates:
    """Places of the work object: ``poses`` (K, 6), x y z in mm, roll pitch yaw in deg, in the base."""

    poses: Floats

    def __repr__(self) -> str:
        return f"Candidates({len(self.poses):,})"

    def frame(self, k: int) -> Frame:
        """One of them, SI."""
        return Frame(matrix_from_rpy(np.radians(self.poses[k, 3:])), self.poses[k, :3] * 1e-3)


def box(words: str, home: WorkObjectTable) -> Candidates:
    """From words such as ``x=1200:1800:13,y=-400:400:9,yaw=0:90:3``; what is not named stays as in the cell.

    Raises:
        CompensatorError: names the part that is wrong.
    """
    values = {axis: np.array([v]) for axis, v in zip(AXES, (*(home.xyz or (0.0, 0.0, 0.0)), *home.rpy), strict=True)}
    given = set[str]()
    for part in filter(None, (p.strip() for p in words.split(","))):
        name, _, span = part.partition("=")
        axis = name.strip()
        if axis not in AXES:
            raise CompensatorError(f"--box: {part!r}: expected one of {', '.join(AXES)}, such as x=1200:1800:13")
        if axis in given:
            raise CompensatorError(f"--box: {part!r}: {axis} is given twice, expected once: one of them would be lost")
        values[axis] = _span(part, span)
        given.add(axis)
    _refuse_metres(words, [values[axis] for axis in AXES[:3] if axis in given])
    count = int(np.prod([len(v) for v in values.values()], dtype=float))
    if count > MOST:
        raise CompensatorError(f"--box: {count:,} placements; at most {MOST:,}: take coarser counts")
    grid = np.meshgrid(*values.values(), indexing="ij")
    return Candidates(np.stack([g.ravel() for g in grid], axis=1))


def _refuse_metres(words: str, lengths: list[Floats]) -> None:
    """Refuse a box whose lengths are all a few mm: no arm has its part that near to its base."""
    largest = max((float(np.abs(v).max()) for v in lengths), default=0.0)
    if 0.0 < largest < NEAR:
        raise CompensatorError(
            f"--box: {words!r}: no x, y or z is {NEAR:g} mm or more: is this in m? mm are expected, such as "
            "x=1200:1800:13; where mm are meant, name the placements with --list"
        )


def _span(part: str, span: str) -> Floats:
    try:
        numbers = [float(v) for v in span.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) == 1 and np.isfinite(numbers[0]):
        return np.array(numbers)
    whole = len(numbers) == 3 and np.isfinite(numbers).all() and numbers[2] >= 1 and numbers[2] == int(numbers[2])
    if not whole:
        raise CompensatorError(f"--box: {part!r}: expected a number, or least:largest:count, mm or deg")
    return np.linspace(numbers[0], numbers[1], int(numbers[2]))


def listed(path: Path) -> Candidates:
    """From a csv with the columns x_mm, y_mm, z_mm and, if they are turned, roll_deg, pitch_deg, yaw_deg.

    Raises:
        CompensatorError: names file, line and column.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as e:
        raise CompensatorError(f"{path}: cannot be read: {e}") from e
    rows = csv.DictReader(io.StringIO(text))
    known = [c.strip() for c in rows.fieldnames or ()]
    if not set(COLUMNS[:3]) <= set(known) or (strange := set(known) - set(COLUMNS)):
        strange = set(known) - set(COLUMNS)
        what = f"unknown column {sorted(strange)[0]!r}" if strange else f"the header is {', '.join(known) or 'empty'}"
        raise CompensatorError(f"{path}:1: {what}; expected {', '.join(COLUMNS)} (the last three may be left out)")
    out = [_row(path, rows.line_num, row) for row in rows]
    if not out:
        raise CompensatorError(f"{path}: no placements in it")
    return Candidates(np.array(out))


def _row(path: Path, line: int, row: dict[str | None, str | None]) -> list[float]:
    values = {str(k).strip(): v for k, v in row.items()}
    out = []
    for name in COLUMNS:
        text = values.get(name, "0")
        try:
            number = float(text or "")
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            raise CompensatorError(f"{path}:{line}: {name} = {text!r}: expected a number, mm or deg")
        out.append(number)
    return out
