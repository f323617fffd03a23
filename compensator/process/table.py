"""A process from a csv table: a wrench per pose or per line of the toolpath."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.process.given_wrench import GivenWrench
from compensator.process.process import ProcessContext, ProcessTable, ToolMotion, WrenchAxes
from toolpaths.languages.table import LANGUAGES
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
COLUMNS = ("index", "fx", "fy", "fz", "mx", "my", "mz")


class WrenchFileTable(ProcessTable):
    """A wrench per pose or per source line, from a csv file relative to the cell."""

    kind: Literal["table"]
    frame: WrenchAxes
    file: str

    def process(self, context: ProcessContext) -> WrenchFileProcess:
        return WrenchFileProcess(context, self.frame, self.file)


@dataclass(frozen=True)
class WrenchFileProcess(GivenWrench):
    """The wrenches of ``file`` in ``axes``."""

    context: ProcessContext
    axes: WrenchAxes
    file: str

    def given(self, motion: ToolMotion) -> Floats:
        return wrenches_along(self.context.folder / self.file, motion.toolpath)

    def description(self) -> str:
        return f"table {self.file}, in the {self.axes} frame"


def wrenches_along(source: Path, path: Toolpath) -> Floats:
    """(N, 6) of a table, as it gives them; 0 at rapids. Rows of a toolpath that is a table, else lines of its source.

    Raises:
        CellError: a cutting pose has no wrench; names the table and the pose.
    """
    index, wrench = read_table(source)
    cutting = path.kind == CUT
    if LANGUAGES[path.language].table:
        return _interpolated(source, path, index, wrench)
    if path.file is not None and path.file.any():
        problem = f"its index counts lines, and {path.source} is a program of {len(path.sources)} files"
        raise CellError(f"{source}: {problem}. Write the poses as csv, and a row of the table for each")
    at = np.searchsorted(index, path.line)
    at = np.minimum(at, len(index) - 1)
    missing = cutting & (index[at] != path.line)
    if missing.any():
        line = int(path.line[np.argmax(missing)])
        raise CellError(f"{source}: no row with index {line}: line {line} of {path.source} cuts and needs a wrench")
    return np.where(cutting[:, None], wrench[at], 0.0)


def _interpolated(source: Path, path: Toolpath, index: Numbers, wrench: Floats) -> Floats:
    cutting = path.kind == CUT
    before, after = np.floor(path.row).astype(np.int64), np.ceil(path.row).astype(np.int64)
    fraction = (path.row - before)[:, None]
    at = [np.minimum(np.searchsorted(index, side), len(index) - 1) for side in (before, after)]
    has = [index[a] == side for a, side in zip(at, (before, after), strict=True)]
    missing = cutting & ~has[1]
    if missing.any():
        row = int(after[np.argmax(missing)])
        raise CellError(f"{source}: no row with index {row}: pose {row} of {path.source} cuts and needs a wrench")
    # the pose before a cut may be a rapid without a row: then the cut's own wrench holds from its beginning
    first = np.where(has[0][:, None], wrench[at[0]], wrench[at[1]])
    return np.where(cutting[:, None], (1 - fraction) * first + fraction * wrench[at[1]], 0.0)


def read_table(source: Path) -> tuple[Numbers, Floats]:
    """A wrench table: index (M,) ascending, wrench (M, 6) in N and N*m.

    Raises:
        CellError: names the file, the line and the column.
    """
    try:
        lines = source.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as e:
        raise CellError(f"{source}: cannot read the wrench table: {e}") from e
    header = [c.strip() for c in lines[0].split(",")] if lines else []
    if sorted(header) != sorted(COLUMNS):
        raise CellError(f"{source}:1: columns are {', '.join(header) or 'missing'}; expected {', '.join(COLUMNS)}")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        cells = line.split(",")
        try:
            values = [float(c) for c in cells]
        except ValueError as e:
            raise CellError(f"{source}:{number}: {e}; expected {len(COLUMNS)} numbers") from e
        if len(values) != len(COLUMNS) or not np.all(np.isfinite(values)):
            raise CellError(f"{source}:{number}: {line!r}; expected {len(COLUMNS)} finite numbers")
        rows.append(values)
    if not rows:
        raise CellError(f"{source}: the table has no rows")
    table = np.array(rows)[:, [header.index(c) for c in COLUMNS]]
    index = table[:, 0].astype(np.int64)
    if np.any(index != table[:, 0]) or np.any(index < 0):
        raise CellError(f"{source}: index must be a whole number, counted from 0 (csv) or a source line (other files)")
    order = np.argsort(index, kind="stable")
    index, table = index[order], table[order]
    twice = np.flatnonzero(np.diff(index) == 0)
    if len(twice):
        raise CellError(f"{source}: index {index[twice[0]]} stands there twice")
    return index, table[:, 1:]
