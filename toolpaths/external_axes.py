"""External axes of robot programs: a rail under the robot, a table under the part, something else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from toolpaths.toolpath import CUT, Floats, Toolpath

Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]
Lines = npt.NDArray[np.int32]

SAME = 1e-6  # mm or deg


def axis_number(name: str) -> int | None:
    """From 0, of eax_a ... eax_f and E1 ... E6, which are the same axes in two languages; None: of another group."""
    if name.startswith("eax_"):
        return ord(name[-1]) - ord("a")
    return int(name[1:]) - 1 if name[:1] == "E" and name[1:].isdigit() else None


def places(values: Floats, row: Floats) -> Floats:
    """(N,) where an axis stands at rows of a toolpath: within a move evenly on the way between its ends.

    Args:
        values: (moves,) mm or deg at the moves' ends, NaN where it is not given: then it does not move, or stands at 0.
        row: (N,) as in Toolpath.
    """
    end = np.maximum(np.ceil(row - 1e-9), 0).astype(np.intp)
    begin = np.maximum(end - 1, 0)
    share = np.clip(row - begin, 0.0, 1.0)
    after = values[end]
    before = np.where(np.isfinite(values[begin]), values[begin], after)
    return np.nan_to_num(np.where(share == 1.0, after, before + share * (after - before)))


def whole_moves(toolpath: Toolpath) -> tuple[Lines, Bools]:
    """Line of each move of the source, and whether it cuts; without the points of arcs."""
    whole = np.flatnonzero(np.abs(toolpath.row - np.rint(toolpath.row)) < 1e-9)
    return toolpath.line[whole], toolpath.kind[whole] == CUT


def unmodelled(external: Mapping[str, Floats], cut: Bools) -> Iterator[tuple[str, str]]:
    """Name of each axis that is not at 0 in all cuts, and where it stands."""
    for name, (_, start, end) in cut_places(external, cut).items():
        low, high = min(start.min(), end.min()), max(start.max(), end.max())
        if high - low > SAME:
            yield name, f"moves between {low:g} and {high:g} in or between the cuts"
        elif abs(high) > SAME:
            yield name, f"stands at {high:g} in the cuts"


def cut_places(external: Mapping[str, Floats], cut: Bools) -> dict[str, tuple[Rows, Floats, Floats]]:
    """Per axis: rows of the cuts that give its place, and its place at their start and end.

    Args:
        external: as in Setting.
        cut: (rows,) whether the move cuts.
    """
    rows, out = np.flatnonzero(cut), {}
    for name, values in external.items():
        said = rows[np.isfinite(values[rows])]
        if len(said):
            end, start = values[said], values[np.maximum(said - 1, 0)]
            out[name] = said, np.where(np.isfinite(start), start, end), end
    return out
