"""External axes of robot programs: a rail under the robot, a table under the part, something else."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, Floats, Toolpath

Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]
Lines = npt.NDArray[np.int32]

SAME = 1e-6  # mm or deg


def refuse_moving(toolpath: Toolpath, names: Collection[str]) -> None:
    """Refuse axes that move in a cut: robot and part have to stay where they are.

    Raises:
        ReadError: names the axis, the line and both places.
    """
    external = {} if toolpath.setting is None else toolpath.setting.external
    line, cut = whole_moves(toolpath)
    for name, (rows, start, end) in cut_places(external, cut).items():
        moving = np.abs(end - start) > SAME
        if name in names and moving.any():
            at = int(np.argmax(moving))
            problem = f"external axis {name} moves from {start[at]:g} to {end[at]:g} in this cut"
            remedy = "What carries robot or part has to stand still while the robot cuts"
            raise ReadError(toolpath.source, int(line[rows[at]]), problem, remedy)


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
