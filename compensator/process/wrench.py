"""Process wrench at every pose: constant, or from a table.

The result is in base axes, about the TCP, on the robot; rapids carry none.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.cell.cell import Cell, Constant
from compensator.cell.cell import Table as TableProcess
from compensator.errors import CellError
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
SMOOTH = np.cos(np.radians(15.0))  # wrenches that differ by less belong to one curve
COLUMNS = ("index", "fx", "fy", "fz", "mx", "my", "mz")


def path_axes(position: Floats, rotation: Floats, kind: npt.NDArray[np.uint8] | None = None) -> Floats:
    """The ``path`` frame at every pose.

    z = TCP z; x = direction of the feed that leaves the pose, normal to z; y = z cross x. Where the feed is
    along z the last x is kept, and the first poses take the next x that exists.

    Args:
        position: (N, 3); rotation: (N, 3, 3) of the TCP, in any one frame.
        kind: (N,) RAPID or CUT of the move that ends at the pose. A rapid is no feed: where one leaves, the last x
            is kept. None: all moves are feeds.

    Returns:
        (N, 3, 3), in the same frame. Poses of a path that never moves across z keep the TCP's own x.
    """
    z = rotation[:, :, 2]
    feed = np.zeros_like(position)
    feed[:-1] = np.diff(position, axis=0)
    # a pose that repeats the one before leaves with the next real move
    moving = np.linalg.norm(feed, axis=1) > 1e-9
    leaving = _next(moving)
    feed = feed[leaving]
    across = feed - z * np.sum(feed * z, axis=1, keepdims=True)
    length = np.linalg.norm(across, axis=1)
    good = length > 1e-6 * np.maximum(np.linalg.norm(feed, axis=1), 1e-12)
    if not good.any():
        return rotation.copy()
    if kind is not None:
        cut = good & (kind[np.minimum(leaving + 1, len(kind) - 1)] == CUT)
        good = cut if cut.any() else good
    x = (across / np.where(good, length, 1.0)[:, None])[_last(good)]
    x = x - z * np.sum(x * z, axis=1, keepdims=True)  # kept from another pose: normal to this one's z
    x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-12)
    return np.stack([x, np.cross(z, x), z], axis=2)


def _last(good: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Index of the last good row up to each row; the first good one for rows before it."""
    index = np.where(good, np.arange(len(good)), -1)
    index = np.maximum.accumulate(index)
    return np.where(index < 0, int(np.argmax(good)), index)


def _next(good: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Index of the next good row from each row on; the last good one for rows after it."""
    index = _last(good[::-1])[::-1]
    return len(good) - 1 - index


def process_wrench(cell: Cell, path: Toolpath, rotation: Floats, position: Floats) -> Floats:
    """Wrench (N, 6) of the process on the robot, base axes, about the TCP.

    Args:
        rotation, position: (N, 3, 3) and (N, 3) of the nominal TCP in the base.

    Raises:
        CellError: a wrench that depends on a turn which is free, or a table that does not fit the path.
    """
    process = cell.process
    if isinstance(process, Constant):
        local = np.broadcast_to(np.array(process.wrench, dtype=float), (len(path), 6))
    else:
        local = _from_table(cell, process, path)
    if process.frame == "tool":
        _refuse_free_turn(cell, path, local[path.kind == CUT])
    axes = _axes(cell, process.frame, position, rotation, path.kind)
    wrench = np.concatenate([_turned(axes, local[:, :3]), _turned(axes, local[:, 3:])], axis=1)
    wrench[path.kind != CUT] = 0.0
    return wrench


def carried_wrench(cell: Cell, wrench: Floats, toolpath: Toolpath, old: Toolpath, old_wrench: Floats) -> Floats:
    """The wrench after poses were put into the segments of ``old``.

    Path axes of a sampled curve turn at its poses; a pose put in between gets what lies between the wrenches of the
    ends, or the whole turn would fall on what is left of the segment. Sharp corners stay corners.
    """
    if cell.process.frame != "path":
        return wrench
    start = np.clip(np.searchsorted(old.row, toolpath.row, side="right") - 1, 0, len(old) - 2)
    a, b = old_wrench[start], old_wrench[start + 1]
    cut = (old.kind[start] == CUT) & (old.kind[start + 1] == CUT)
    size = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    gentle = np.sum(a * b, axis=1) > SMOOTH * size
    share = (toolpath.row - old.row[start]) / (old.row[start + 1] - old.row[start])
    inside = cut & gentle & (share > 0) & (share < 1)
    return np.where(inside[:, None], a + share[:, None] * (b - a), wrench)


def _turned(axes: Floats, vectors: Floats) -> Floats:
    return np.asarray(np.einsum("...ij,...j->...i", axes, vectors))


def _axes(
    cell: Cell, frame: str, position: Floats, rotation: Floats, kind: npt.NDArray[np.uint8]
) -> Floats:
    if frame == "base":
        return np.eye(3)
    if frame == "workobject":
        return cell.workobject.matrix()[:3, :3]
    return rotation if frame == "tool" else path_axes(position, rotation, kind)


def _refuse_free_turn(cell: Cell, path: Toolpath, cutting: Floats) -> None:
    open_turn = cell.solve.free_tool_axis or path.quaternion is None
    if open_turn and np.any(cutting[:, [0, 1, 3, 4]]):
        raise CellError(
            f"{cell.source}: process.frame = 'tool' with a lateral force or moment needs a fixed orientation: the turn "
            "about the tool axis is open here. Set solve.free_tool_axis = false and give orientations (qw, qx, qy, qz) "
            "in the toolpath, or use frame = 'path' or 'workobject'"
        )


def _from_table(cell: Cell, process: TableProcess, path: Toolpath) -> Floats:
    source = cell.folder / process.file
    index, wrench = read_table(source)
    cutting = path.kind == CUT
    if path.language == "csv":
        return _interpolated(source, index, wrench, path, cutting)
    at = np.searchsorted(index, path.line)
    at = np.minimum(at, len(index) - 1)
    missing = cutting & (index[at] != path.line)
    if missing.any():
        line = int(path.line[np.argmax(missing)])
        raise CellError(f"{source}: no row with index {line}: line {line} of {path.source} cuts and needs a wrench")
    return np.where(cutting[:, None], wrench[at], 0.0)


def _interpolated(
    source: Path, index: npt.NDArray[np.int64], wrench: Floats, path: Toolpath, cutting: npt.NDArray[np.bool_]
) -> Floats:
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


def read_table(source: Path) -> tuple[npt.NDArray[np.int64], Floats]:
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
