"""A process from a csv table: a wrench per pose or per line of the toolpath."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.process.given_wrench import GivenWrench
from compensator.process.process import NamedCutterTable, ProcessContext, ProcessTable, ToolMotion, WrenchAxes
from stiffness.text_file import decoded, file_bytes
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

    material: str | None = None
    cutter: NamedCutterTable | None = None

    def process(self, context: ProcessContext) -> WrenchFileProcess:
        source = context.folder / self.file
        if not source.exists():
            raise CellError(f"{context.source}: process.file = {self.file!r}: {source}: there is no such file")
        return WrenchFileProcess(context, self.frame, read_table(source))


@dataclass(frozen=True, eq=False, repr=False)
class WrenchRows:
    """The rows of a table: ``index`` (M,) ascending, ``wrench`` (M, 6) N and N*m, of the file ``source``."""

    source: Path
    index: Numbers
    wrench: Floats

    def __repr__(self) -> str:
        return f"WrenchRows({str(self.source)!r}, {len(self.index)} rows)"

    def along(self, path: Toolpath) -> Floats:
        """(N, 6) as the table gives them; 0 at rapids. Rows of a toolpath that is a table, else lines of its source.

        Raises:
            CellError: a cutting pose has no wrench; names the table and the pose.
        """
        cutting = path.kind == CUT
        if LANGUAGES[path.language].table:
            return self._interpolated(path)
        if path.file is not None and path.file.any():
            problem = f"its index counts lines, and {path.source} is a program of {len(path.sources)} files"
            raise CellError(f"{self.source}: {problem}. Write the poses as csv, and a row of the table for each")
        at, has = self._find(path.line)
        missing = cutting & ~has
        if missing.any():
            line = int(path.line[np.argmax(missing)])
            what = f"line {line} of {path.source} cuts and needs a wrench"
            raise CellError(f"{self.source}: no row with index {line}: {what}")
        return np.where(cutting[:, None], self.wrench[at], 0.0)

    def _interpolated(self, path: Toolpath) -> Floats:
        cutting = path.kind == CUT
        before, after = np.floor(path.row).astype(np.int64), np.ceil(path.row).astype(np.int64)
        fraction = (path.row - before)[:, None]
        (first_at, has_first), (last_at, has_last) = self._find(before), self._find(after)
        missing = cutting & ~has_last
        if missing.any():
            row = int(after[np.argmax(missing)])
            what = f"pose {row} of {path.source} cuts and needs a wrench"
            raise CellError(f"{self.source}: no row with index {row}: {what}")
        last = self.wrench[last_at]
        # the pose before a cut may be a rapid without a row: then the cut's own wrench holds from its beginning
        first = np.where(has_first[:, None], self.wrench[first_at], last)
        return np.where(cutting[:, None], (1 - fraction) * first + fraction * last, 0.0)

    def _find(self, wanted: npt.NDArray[np.integer]) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.bool_]]:
        """(N,) the row of each index, and whether there is one."""
        at = np.minimum(np.searchsorted(self.index, wanted), len(self.index) - 1)
        return at, self.index[at] == wanted


@dataclass(frozen=True)
class WrenchFileProcess(GivenWrench):
    """The wrenches of ``rows`` in ``axes``."""

    context: ProcessContext
    axes: WrenchAxes
    rows: WrenchRows

    def given(self, motion: ToolMotion) -> Floats:
        return self.rows.along(motion.toolpath)

    def description(self) -> str:
        return f"table {self.rows.source.name}, in the {self.axes} frame"


def _numbers(place: str, line: str, header: list[str]) -> list[float]:
    cells = line.split(",")
    if len(cells) != len(header):
        commas = "; the decimal sign is a point" if len(cells) > len(header) else ""
        raise CellError(f"{place}: {line!r}; expected {len(header)} finite numbers{commas}")
    values = []
    for name, cell in zip(header, cells, strict=True):
        try:
            values.append(float(cell))
        except ValueError as e:
            raise CellError(f"{place}: column {name}: {cell.strip()!r} is not a number") from e
        if not np.isfinite(values[-1]):
            raise CellError(f"{place}: column {name}: {cell.strip()!r} is not a finite number")
    return values


def read_table(source: Path) -> WrenchRows:
    """A wrench table.

    Raises:
        CellError: names the file, the line and the column.
    """
    lines = decoded(str(source), file_bytes(str(source), source, CellError), CellError).splitlines()
    header = [c.strip() for c in lines[0].split(",")] if lines else []
    if sorted(header) != sorted(COLUMNS):
        commas = "; cells are separated by commas, the decimal sign is a point" if ";" in "".join(header) else ""
        what = f"columns are {', '.join(header) or 'missing'}; expected {', '.join(COLUMNS)}{commas}"
        raise CellError(f"{source}:1: {what}")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        rows.append(_numbers(f"{source}:{number}", line, header))
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
    return WrenchRows(source, index, table[:, 1:])
