"""Fit of a stock and a path: the grid that both allow, and whether the cutter meets the stock at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.process.milling.cutter import Cutter
from compensator.process.milling.kernels.field import SIDE
from compensator.process.milling.mesh_reader import UNITS
from compensator.process.milling.path import MillingPath
from compensator.process.milling.stock import Stock

Floats = npt.NDArray[np.float64]

CELLS_PER_RADIUS = 10  # of the smallest cutter
MOST_BRICKS = 12_000_000  # of 8 x 8 x 8 cells: 100 MB to tell which of them hold nodes
TOLERANCE = 1e-6  # m


def cell_for(cutters: Sequence[Cutter], stock: Stock, given: float | None, source: str) -> float:
    """Spacing of the grid, m: as given, else a tenth of the smallest radius, or more where the stock is large.

    Raises:
        CellError: the given one is too fine for the stock, or as coarse as a cutter.
    """
    size = np.maximum(np.ptp(stock.box, axis=0), 1e-9)
    finest = float((np.prod(size) / MOST_BRICKS) ** (1 / 3) / SIDE)
    smallest = min(c.radius for c in cutters)
    if given is None:
        return max(smallest / CELLS_PER_RADIUS, finest)
    if given < finest * 0.999:
        raise CellError(
            f"{source}: process.stock.grid = {given * 1e3:g} mm: the stock has {stock.source}; at least "
            f"{finest * 1e3:.3g} mm is needed"
        )
    if given > smallest / 2:
        raise CellError(
            f"{source}: process.stock.grid = {given * 1e3:g} mm: at most a quarter of the diameter of the smallest "
            f"cutter is expected, {smallest * 5e2:.3g} mm"
        )
    return given


def meets(path: MillingPath, box: Floats) -> bool:
    """Whether the box around what the cutters pass while cutting meets a box (2, 3), m."""
    low, high = reach_of(path)
    return bool(np.all(low <= box[1] + TOLERANCE) and np.all(high >= box[0] - TOLERANCE))


def reach_of(path: MillingPath) -> tuple[Floats, Floats]:
    """Least and largest corner (3,) of a box around the cutting edges along the cutting moves, m; empty: inf, -inf."""
    cut = ~path.rapid
    cut[:1] = False
    cut[:-1] |= cut[1:]  # a move begins at the pose before
    if not cut.any():
        return np.full(3, np.inf), np.full(3, -np.inf)
    length = np.array([c.length for c in path.cutters])[path.cutter[cut], None]
    wide = np.array([c.largest_radius for c in path.cutters])[path.cutter[cut], None]
    tip, top = path.position[cut], path.position[cut] + length * path.axis[cut]
    return (np.minimum(tip, top) - wide).min(axis=0), (np.maximum(tip, top) + wide).max(axis=0)


def refuse_apart(path: MillingPath, stock: Stock, file: str, units: str) -> None:
    """Refuse a mesh that the cutter never meets.

    Raises:
        CellError: names the file, where both are, and the unit that would fit.
    """
    low, high = reach_of(path)
    if meets(path, stock.box) or not np.all(np.isfinite(low)):
        return
    fits = [u for u, scale in UNITS.items() if u != units and meets(path, stock.box * scale / UNITS[units])]
    remedy = f"units = {fits[0]!r} would make them meet" if fits else "check the work object and the origin of the mesh"
    raise CellError(
        f"{file}: the path never meets the stock, which lies between {_mm(stock.box[0])} and {_mm(stock.box[1])} mm "
        f"of the work object; the cutter goes from {_mm(low)} to {_mm(high)}: {remedy}"
    )


def _mm(point: Floats) -> str:
    return "(" + ", ".join(f"{v * 1e3:.4g}" for v in point) + ")"
