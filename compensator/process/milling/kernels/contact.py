"""Contact: which part of a cutter's envelope is inside the material, at one pose.

The envelope is looked at on a lattice: rows along its outline, columns over the angles where the feed pushes it into
the work (n . f > 0), each row over its own range of angles. Between a point inside and one outside the edge of the
engaged region is found on the field itself, so that the region is known to a small part of a cell.
"""

from __future__ import annotations

from math import cos, pi, sin, sqrt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.field import CELL, Field, exact_depth, near_depth
from compensator.process.milling.kernels.lattice import (
    COLUMNS,
    Envelope,
    Floats,
    Lattice,
    Stand,
    angle_limit,
    column_angle,
    outline_at,
    place_at,
    place_of,
)
from compensator.process.milling.kernels.stock_distance import AROUND
from compensator.process.milling.kernels.sweep import Point, sweep_distance

NONE = 2e-6  # m: an engaged depth below is none (a wall that the same cutter left on the same line)
_CROSSING = 8  # steps between a point inside and one outside
_SHARP = 0.005  # share of a cell: the edge of the region is known to this
_FINE = 1e-7  # m: or to this depth
_NEXT = 1.0 / 128.0  # share of a way: inside so near to a surface, it ends there


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
def depth_at(f: Field, stand: Stand, point: Point, exact: bool) -> float:
    """The field less NONE, the move under way included; away from a surface only its sign, unless ``exact``. m."""
    d = 0.0 if exact else near_depth(f, point)
    if -4.0 * NONE < d <= NONE:  # a bound this small does not tell whether the depth counts
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
    bounds = False  # whether the depths of the row below are true
    columns = COLUMNS if widest > 0.6 * pi else COLUMNS // 2
    for r in range(first, last):
        grid.found[r] = 0
        if grid.limit[r] == 0.0 or _out_of_reach(f.solid.number, e, stand, r):
            for c in range(columns + 1):
                grid.depth[r, c] = f.frame[CELL]
            bounds = False
            continue
        _turn_to(grid.turn, grid.limit[r], columns)
        for c in range(columns + 1):
            d = _by_neighbours(e, grid, r, c, below=bounds and e.open[r - 1] == 1, most=2.0 * f.frame[CELL])
            if d == 0.0:
                point = place_of(stand, e.rho[r] * grid.turn[2, c], e.rho[r] * grid.turn[3, c], e.s[r])
                d = depth_at(f, stand, point, False)
            grid.depth[r, c] = d
            grid.found[r] += d < 0.0
        inside += grid.found[r]
        bounds = True
    return columns, inside


@compiled
def _by_neighbours(e: Envelope, grid: Lattice, r: int, c: int, below: bool, most: float) -> float:
    """A bound of the depth from the places beside and below: it changes no faster than the place. 0: none. m.

    ``most``: of a depth in the material that the grid tells of; a cut further away is not written there.
    """
    best = 0.0
    if c > 0:
        x, y = grid.turn[2, c] - grid.turn[2, c - 1], grid.turn[3, c] - grid.turn[3, c - 1]
        best = _sure(max(grid.depth[r, c - 1], -most), e.rho[r] * sqrt(x * x + y * y))
    if below and grid.limit[r] == grid.limit[r - 1]:
        away = e.along[r] - e.along[r - 1]
        bound = _sure(max(grid.depth[r - 1, c], -most), away)
        if abs(bound) > abs(best):
            best = bound
    return best


@compiled
def _sure(d: float, away: float) -> float:
    """What a depth leaves so far away; 0: its sign may differ."""
    if d > away + 4.0 * NONE:
        return d - away
    return d + away if d < -away - 4.0 * NONE else 0.0


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

    A place deeper than zero by less than NONE is outside. Where the way ends on a floor or wall, the field stays at
    zero from a kink on: there it is halved only.

    Args:
        cell: row, column, columns. way: shares of row and column at its beginning, and what is added; ends: depths, m.
    """
    on_surface = 0.5 * NONE <= max(ends[0], ends[1]) <= 1.5 * NONE
    level = NONE if max(ends[0], ends[1]) > 1.5 * NONE else 0.0
    if on_surface:
        off = min(max(_NEXT, 2.0 * NONE / -min(ends[0], ends[1])), 0.5)
        share = 1.0 - off if ends[1] > ends[0] else off
        at_row, at_column = way[0] + share * way[2], way[1] + share * way[3]
        if cell_depth(f, e, stand, grid, cell=cell, at_row=at_row, at_column=at_column) < 0.0:
            return 1.0 if ends[1] > ends[0] else 0.0
    low, high, d_low, d_high, share = 0.0, 1.0, ends[0] - level, ends[1] - level, 0.5
    near = max(_SHARP * (abs(d_low) + abs(d_high)), _FINE)
    for step in range(_CROSSING):
        share = 0.5 * (low + high) if on_surface or step % 3 == 2 else low + (high - low) * d_low / (d_low - d_high)
        at_row, at_column = way[0] + share * way[2], way[1] + share * way[3]
        d = cell_depth(f, e, stand, grid, cell=cell, at_row=at_row, at_column=at_column) - level
        if abs(d) < near and not on_surface:
            break
        if (d < 0.0) == (d_low < 0.0):
            low, d_low = share, d
        else:
            high, d_high = share, d
    return share


@compiled
def _bend(f: Field, e: Envelope, stand: Stand, grid: Lattice, cell: tuple[int, int, int]) -> None:
    """Where one corner of a cell differs from the others: how far the edge goes out between its two crossings.
    0.5: a straight edge, 1: to where lines through both would meet."""
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
