"""Contact: which part of a cutter's envelope is inside the material, at one pose.

The envelope is looked at on a lattice: rows along its outline, columns over the angles where the feed pushes it into
the work (n . f > 0), each row over its own range of angles. Between a point inside and one outside the edge of the
engaged region is found on the field itself, so that the region is known to a small part of a cell.
"""

from __future__ import annotations

from math import acos, cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.field import CELL, Field, exact_depth, near_depth
from compensator.process.milling.kernels.profile import RC, E
from compensator.process.milling.kernels.stock_distance import AROUND
from compensator.process.milling.kernels.sweep import Point, sweep_distance

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]

NONE = 2e-6  # m: an engaged depth below is none (a wall that the same cutter left on the same line)
COLUMNS = 96  # most columns; half of them where the envelope goes forward over half of its turn
_CROSSING = 8  # steps between a point inside and one outside
_SHARP = 0.005  # share of a cell: the edge of the region is known to this
_FINE = 1e-7  # m: or to this depth


class Envelope(NamedTuple):
    """Rows along the outlines of all cutters, from the tip upwards.

    Attributes:
        rho, s: (R,) m; kappa: (R,) rad between normal and TCP z; along: (R,) m, length of the outline up to there.
        open: (R,) 1 where the outline goes on to the next row, 0 where a part of it ends.
        first: (C + 1,) first row of each cutter. profile: (C, 8), see profile.py.
    """

    rho: Floats
    s: Floats
    kappa: Floats
    along: Floats
    open: Ints
    first: Ints
    profile: Floats


class Stand(NamedTuple):
    """A cutter at a pose.

    Attributes:
        tip: m; x, y, z: unit vectors of the angle 0, of 90 deg in the sense of the spindle, of the tool into the work.
        fx, fz: m per tooth, the feed along x and z.
        cutter: row of profiles.
        part, share: move that is under way, and the share of it that is done; -1: none.
    """

    tip: Point
    x: Point
    y: Point
    z: Point
    fx: float
    fz: float
    cutter: int
    part: int
    share: float


class Lattice(NamedTuple):
    """Room for the answers at one pose: rows R, columns COLUMNS.

    Attributes:
        limit: (R,) rad, angles of a row lie within plus and minus this.
        turn: (5, COLUMNS + 1) of the columns: their share of the limit with half and with all columns; cosine and sine
            of their angles in the last row; [4, 0] the limit that these are for.
        found: (R,) points of a row that are inside.
        depth: (R, COLUMNS + 1) m, negative inside by more than NONE.
        across: (R, COLUMNS) where the edge crosses from a column to the next; up: (R, COLUMNS + 1) from row to row.
        bend: (R, COLUMNS) how far the edge goes out in a cell with one odd corner.
        edges: (K, 5) pieces of cutting edge for the peak; corner: (8, 2) corners of the part of a cell;
            room: (42,) for an answer that is only looked at.
    """

    limit: Floats
    turn: Floats
    found: Ints
    depth: Floats
    across: Floats
    up: Floats
    bend: Floats
    edges: Floats
    corner: Floats
    room: Floats


@compiled
def angle_limit(stand: Stand, kappa: float) -> float:
    """Largest angle from the feed at which the envelope goes forward: n . f > 0. rad."""
    side, down = stand.fx * sin(kappa), stand.fz * cos(kappa)
    if side <= abs(down) * 1e-12:
        return pi if down > 1e-9 * stand.fx else 0.0
    c = -down / side
    if c >= 1.0:
        return 0.0
    return pi if c <= -1.0 else acos(c)


@compiled
def column_angle(limit: float, column: float, columns: int) -> float:
    """Angle of a column, or of a place between two, rad: closer to each other towards the flanks of the cutter."""
    return limit * sin(0.5 * pi * (2.0 * column / columns - 1.0))


@compiled
def outline_at(e: Envelope, cutter: int, row: int, share: float) -> tuple[float, float, float]:
    """rho, s (m) and kappa (rad) between a row and the next."""
    if share == 0.0:
        return e.rho[row], e.s[row], e.kappa[row]
    kappa = e.kappa[row] + share * (e.kappa[row + 1] - e.kappa[row])
    if e.kappa[row + 1] != e.kappa[row]:
        arc = e.profile[cutter, RC]
        return e.profile[cutter, E] + arc * sin(kappa), arc * (1.0 - cos(kappa)), kappa
    rho = e.rho[row] + share * (e.rho[row + 1] - e.rho[row])
    return rho, e.s[row] + share * (e.s[row + 1] - e.s[row]), kappa


@compiled
def _turn_to(turn: Floats, limit: float, columns: int) -> None:
    """Cosine and sine of the columns of a row."""
    if turn[4, 0] != limit or turn[4, 1] != columns:
        share = 0 if columns < COLUMNS else 1
        for c in range(columns + 1):
            angle = limit * turn[share, c]
            turn[2, c], turn[3, c] = cos(angle), sin(angle)
        turn[4, 0], turn[4, 1] = limit, columns


@compiled
def place_at(stand: Stand, rho: float, s: float, angle: float) -> Point:
    """A place of the envelope in the work object, m."""
    return place_of(stand, rho * cos(angle), rho * sin(angle), s)


@compiled
def place_of(stand: Stand, a: float, b: float, s: float) -> Point:
    """A place ``a`` along x, ``b`` along y and ``s`` up the tool from the tip, in the work object, m."""
    return (
        stand.tip[0] + a * stand.x[0] + b * stand.y[0] - s * stand.z[0],
        stand.tip[1] + a * stand.x[1] + b * stand.y[1] - s * stand.z[1],
        stand.tip[2] + a * stand.x[2] + b * stand.y[2] - s * stand.z[2],
    )


@compiled
def depth_at(f: Field, stand: Stand, point: Point, exact: bool) -> float:
    """The field less NONE, the move under way included; away from a surface only its sign, unless ``exact``. m."""
    d = 0.0 if exact else near_depth(f, point)
    if -4.0 * NONE < d <= 0.0:  # a bound this small does not tell whether the depth counts
        d = exact_depth(f, point)
    if d < -NONE and stand.part >= 0:
        d = max(d, -sweep_distance(f.moves, stand.part, point, stand.share)[0])
    return d + NONE


@compiled
def fill(f: Field, e: Envelope, stand: Stand, grid: Lattice) -> tuple[int, int]:
    """Depths on the lattice; number of columns and of points inside."""
    first, last, widest, inside = e.first[stand.cutter], e.first[stand.cutter + 1], 0.0, 0
    for r in range(first, last):
        grid.limit[r] = angle_limit(stand, e.kappa[r])
        widest = max(widest, grid.limit[r])
    columns = COLUMNS if widest > 0.6 * pi else COLUMNS // 2
    for r in range(first, last):
        grid.found[r] = 0
        if grid.limit[r] == 0.0 or _out_of_reach(f.solid.number, e, stand, r):
            for c in range(columns + 1):
                grid.depth[r, c] = f.frame[CELL]
            continue
        _turn_to(grid.turn, grid.limit[r], columns)
        for c in range(columns + 1):
            point = place_of(stand, e.rho[r] * grid.turn[2, c], e.rho[r] * grid.turn[3, c], e.s[r])
            d = depth_at(f, stand, point, False)
            grid.depth[r, c] = d
            grid.found[r] += d < 0.0
        inside += grid.found[r]
    return columns, inside


@compiled
def _out_of_reach(solid: Floats, e: Envelope, stand: Stand, r: int) -> bool:
    """Whether the ring of a row is outside of the box around the stock."""
    for a in range(3):
        middle = stand.tip[a] - e.s[r] * stand.z[a]
        wide = e.rho[r] * sqrt(max(1.0 - stand.z[a] * stand.z[a], 0.0)) + NONE
        if middle + wide < solid[AROUND + a] or middle - wide > solid[AROUND + a + 3]:
            return True
    return False


@compiled
def cross(f: Field, e: Envelope, stand: Stand, grid: Lattice, columns: int) -> None:
    """Where the edge of the engaged region crosses the lines of the lattice, and its corners inside of cells."""
    for r in range(e.first[stand.cutter], e.first[stand.cutter + 1]):
        if grid.found[r] and grid.found[r] <= columns:
            for c in range(columns):
                if (grid.depth[r, c] < 0.0) != (grid.depth[r, c + 1] < 0.0):
                    ends = (grid.depth[r, c], grid.depth[r, c + 1])
                    way = (0.0, 0.0, 0.0, 1.0)
                    grid.across[r, c] = _crossing(f, e, stand, grid, cell=(r, c, columns), way=way, ends=ends)
        if not mixed(e, grid, r, columns):
            continue
        for c in range(columns + 1):
            if (grid.depth[r, c] < 0.0) != (grid.depth[r + 1, c] < 0.0):
                ends = (grid.depth[r, c], grid.depth[r + 1, c])
                way = (0.0, 0.0, 1.0, 0.0)
                grid.up[r, c] = _crossing(f, e, stand, grid, cell=(r, c, columns), way=way, ends=ends)
    for r in range(e.first[stand.cutter], e.first[stand.cutter + 1]):
        if mixed(e, grid, r, columns):
            for c in range(columns):
                _bend(f, e, stand, grid, cell=(r, c, columns))


@compiled
def mixed(e: Envelope, grid: Lattice, r: int, columns: int) -> bool:
    """Whether the strip from a row to the next is partly inside."""
    if not e.open[r]:
        return False
    found = grid.found[r] + grid.found[r + 1]
    return 0 < found < 2 * (columns + 1)


@compiled
def cell_depth(
    f: Field, e: Envelope, stand: Stand, grid: Lattice, cell: tuple[int, int, int], at_row: float, at_column: float
) -> float:
    """Exact depth inside a cell of the lattice, at shares of the way to the next row and column. m."""
    r, c, columns = cell
    rho, s, _ = outline_at(e, stand.cutter, r, at_row)
    limit = grid.limit[r]
    if at_row > 0.0:
        limit += at_row * (grid.limit[r + 1] - limit)
    angle = column_angle(limit, c + at_column, columns)
    return depth_at(f, stand, place_at(stand, rho, s, angle), True)


@compiled
def _crossing(
    f: Field, e: Envelope, stand: Stand, grid: Lattice, cell: tuple[int, int, int],
    way: tuple[float, float, float, float], ends: tuple[float, float],
) -> float:  # fmt: skip
    """Share of a way across a cell where the material ends; by false position, halved where that crawls.

    A place deeper than zero by less than NONE is outside, and so is all behind it.

    Args:
        cell: row, column, columns. way: shares of row and column at its beginning, and what is added to them.
        ends: depths at both ends, m.
    """
    if 0.75 * NONE <= max(ends[0], ends[1]) <= NONE:
        return 1.0 if ends[1] > ends[0] else 0.0
    level = NONE if max(ends[0], ends[1]) > NONE else 0.0
    low, high, share = 0.0, 1.0, 0.5
    d_low, d_high = ends[0] - level, ends[1] - level
    near = max(_SHARP * (abs(d_low) + abs(d_high)), _FINE)
    for step in range(_CROSSING):
        share = 0.5 * (low + high) if step % 3 == 2 else low + (high - low) * d_low / (d_low - d_high)
        at_row, at_column = way[0] + share * way[2], way[1] + share * way[3]
        d = cell_depth(f, e, stand, grid, cell=cell, at_row=at_row, at_column=at_column) - level
        if abs(d) < near:
            break
        if (d < 0.0) == (d_low < 0.0):
            low, d_low = share, d
        else:
            high, d_high = share, d
    return share


@compiled
def _bend(f: Field, e: Envelope, stand: Stand, grid: Lattice, cell: tuple[int, int, int]) -> None:
    """Where one corner of a cell differs from the others: how far the edge goes out between its two crossings.

    From that corner over the middle between the crossings (0.5: a straight edge) to where lines through both meet (1).
    """
    r, c, _ = cell
    a, b = grid.depth[r, c] < 0.0, grid.depth[r, c + 1] < 0.0
    d, g = grid.depth[r + 1, c] < 0.0, grid.depth[r + 1, c + 1] < 0.0
    count = a + b + d + g
    if count != 1 and count != 3:
        return
    top, right = a == b, a == d
    across, up = grid.across[r + top, c], grid.up[r, c + right]
    way = (1.0 * top, 1.0 * right, up - 1.0 * top, across - 1.0 * right)
    start = grid.depth[r + top, c + right]
    end = cell_depth(f, e, stand, grid, cell=cell, at_row=up, at_column=across)
    if (end < 0.0) == (start < 0.0) or abs(end) < 2.0 * NONE:
        grid.bend[r, c] = 1.0
    else:
        grid.bend[r, c] = _crossing(f, e, stand, grid, cell=cell, way=way, ends=(start, end))
