"""Chip: mean force over a turn and engaged area, summed over the cells of the lattice that are inside the material.

Of N teeth the mean over a turn is N / 2 pi times the sum over angles and along the edge of the force of one element.
There are six sums of force and moment, one for each coefficient: a wrench is their product with the coefficients.
"""

from __future__ import annotations

from math import acos, cos, pi, sin, sqrt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.contact import mixed
from compensator.process.milling.kernels.lattice import (
    Envelope,
    Floats,
    Lattice,
    Stand,
    column_angle,
    outline_at,
)

EDGE_RISE = 1e-6  # m of chip thickness over which the edge terms rise
LEAST_CHIP = 1e-7  # m: thinner does not count for entry, exit and depth

AP, ENTRY, EXIT, AREA, VOLUME, PEAK, SUMS = 0, 1, 2, 3, 4, 5, 6
OUT_COLUMNS = SUMS + 36
"""Columns of an answer: m, rad, rad (NaN: no engagement), m2, m3 of the move, N, then 6 x 6 for one tooth: rows force
and moment in axes of the stand, columns ktc, krc, kac (m2, m3), kte, kre, kae (m, m2)."""


@compiled
def chip_thickness(stand: Stand, kappa: float, angle: float) -> float:
    """f_t . n, m."""
    return stand.fx * sin(kappa) * cos(angle) + stand.fz * cos(kappa)


@compiled
def cell_share(grid: Lattice, r: int, c: int) -> tuple[float, float, float]:
    """Share of a cell that is inside, and its centre (share along the row, share to the next row)."""
    a, b = grid.depth[r, c] < 0.0, grid.depth[r, c + 1] < 0.0
    d, e = grid.depth[r + 1, c] < 0.0, grid.depth[r + 1, c + 1] < 0.0
    count = a + b + d + e
    if count == 4 or count == 0:
        return 0.25 * count, 0.5, 0.5
    if count != 2:
        return _odd_corner(grid, (r, c), top=(a == b), right=(a == d), inside=count == 1)
    corner, n = grid.corner, 0
    if a:
        corner[n, 0], corner[n, 1], n = 0.0, 0.0, n + 1
    if a != b:
        corner[n, 0], corner[n, 1], n = grid.across[r, c], 0.0, n + 1
    if b:
        corner[n, 0], corner[n, 1], n = 1.0, 0.0, n + 1
    if b != e:
        corner[n, 0], corner[n, 1], n = 1.0, grid.up[r, c + 1], n + 1
    if e:
        corner[n, 0], corner[n, 1], n = 1.0, 1.0, n + 1
    if d != e:
        corner[n, 0], corner[n, 1], n = grid.across[r + 1, c], 1.0, n + 1
    if d:
        corner[n, 0], corner[n, 1], n = 0.0, 1.0, n + 1
    if a != d:
        corner[n, 0], corner[n, 1], n = 0.0, grid.up[r, c], n + 1
    return _polygon(corner, n)


@compiled
def _odd_corner(
    grid: Lattice, cell: tuple[int, int], top: bool, right: bool, inside: bool
) -> tuple[float, float, float]:
    """A cell with one corner unlike the other three: the part at that corner has four sides, or is what is missing."""
    r, c = cell
    x, y = 1.0 * right, 1.0 * top
    across, up = grid.across[r + top, c], grid.up[r, c + right]
    out = grid.bend[r, c]
    bent_x, bent_y = x + out * (across - x), y + out * (up - y)
    k = grid.corner
    k[0, 0], k[0, 1], k[1, 0], k[1, 1] = x, y, across, y
    k[2, 0], k[2, 1], k[3, 0], k[3, 1] = bent_x, bent_y, x, up
    area, at_x, at_y = _polygon(k, 4)
    if inside:
        return area, at_x, at_y
    return 1.0 - area, (0.5 - area * at_x) / (1.0 - area), (0.5 - area * at_y) / (1.0 - area)


@compiled
def _polygon(corner: Floats, n: int) -> tuple[float, float, float]:
    """Area and centre of a polygon with n corners."""
    area, x, y = 0.0, 0.0, 0.0
    for i in range(n):
        j = (i + 1) % n
        w = corner[i, 0] * corner[j, 1] - corner[j, 0] * corner[i, 1]
        area += w
        x += w * (corner[i, 0] + corner[j, 0])
        y += w * (corner[i, 1] + corner[j, 1])
    if abs(area) < 1e-12:
        return 0.0, 0.5, 0.5
    return 0.5 * abs(area), x / (3.0 * area), y / (3.0 * area)


@compiled
def add_cells(
    e: Envelope, stand: Stand, grid: Lattice, columns: int, motion: Floats, out: Floats
) -> None:
    """Add up all engaged cells: area, volume, and the sums of force and moment of one tooth.

    Args:
        motion: (6,) way of the tip (m) and turn (rad) during the move, in axes of the stand.
    """
    for r in range(e.first[stand.cutter], e.first[stand.cutter + 1] - 1):
        if not e.open[r] or grid.found[r] + grid.found[r + 1] == 0:
            continue
        length = e.along[r + 1] - e.along[r]
        for c in range(columns):
            share, at_column, at_row = cell_share(grid, r, c)
            if share > 0.0:
                limit = grid.limit[r] + at_row * (grid.limit[r + 1] - grid.limit[r])
                angle = column_angle(limit, c + at_column, columns)
                wide = pi / columns * sqrt(max(limit * limit - angle * angle, 0.0))  # of the angle by the column
                place, piece = outline_at(e, stand.cutter, r, at_row), share * length * wide
                _add(stand, place, angle, piece, motion=motion, out=out)


@compiled
def _add(
    stand: Stand, place: tuple[float, float, float], angle: float, piece: float, motion: Floats, out: Floats
) -> None:
    """One piece of the envelope (m rad): ``place`` rho, s and kappa."""
    rho, s, kappa = place
    c, d, sk, ck = cos(angle), sin(angle), sin(kappa), cos(kappa)
    h = stand.fx * sk * c + stand.fz * ck
    if h <= 0.0:
        return
    edge = min(h / EDGE_RISE, 1.0)
    x, y, z = rho * c, rho * d, -s
    out[AREA] += piece * rho
    n = (sk * c, sk * d, ck)
    vx = motion[0] + motion[4] * z - motion[5] * y
    vy = motion[1] + motion[5] * x - motion[3] * z
    vz = motion[2] + motion[3] * y - motion[4] * x
    out[VOLUME] += piece * rho * max(n[0] * vx + n[1] * vy + n[2] * vz, 0.0)
    ways = ((d, -c, 0.0), (-n[0], -n[1], -n[2]), (-ck * c, -ck * d, sk))
    for k in range(3):
        u = ways[k]
        turn = (y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0])
        for a in range(3):
            out[SUMS + 6 * a + k] += piece * h * u[a]
            out[SUMS + 6 * a + k + 3] += piece * edge * u[a]
            out[SUMS + 6 * (a + 3) + k] += piece * h * turn[a]
            out[SUMS + 6 * (a + 3) + k + 3] += piece * edge * turn[a]


@compiled
def extent(e: Envelope, stand: Stand, grid: Lattice, columns: int, out: Floats) -> None:
    """Highest engaged point, smallest and largest engaged angle, of points with a chip."""
    for r in range(e.first[stand.cutter], e.first[stand.cutter + 1]):
        thick = _angle_of_chip(stand, e.kappa[r])
        if thick > 0.0 and grid.found[r] > 0:
            for c in range(columns + 1):
                _row_extent(e, grid, (r, c, columns), thick, out=out)
        if mixed(e, grid, r, columns):
            for c in range(columns + 1):
                if (grid.depth[r, c] < 0.0) != (grid.depth[r + 1, c] < 0.0):
                    _, s, kappa = outline_at(e, stand.cutter, r, grid.up[r, c])
                    limit = grid.limit[r] + grid.up[r, c] * (grid.limit[r + 1] - grid.limit[r])
                    if chip_thickness(stand, kappa, column_angle(limit, c, columns)) > LEAST_CHIP:
                        out[AP] = max(out[AP], s)


@compiled
def _angle_of_chip(stand: Stand, kappa: float) -> float:
    """Largest angle where the chip is thicker than LEAST_CHIP, rad."""
    side, down = stand.fx * sin(kappa), stand.fz * cos(kappa) - LEAST_CHIP
    if side <= abs(down) * 1e-12:
        return pi if down > 0.0 else 0.0
    return acos(min(max(-down / side, -1.0), 1.0))


@compiled
def _row_extent(e: Envelope, grid: Lattice, at: tuple[int, int, int], thick: float, out: Floats) -> None:
    """What a lattice point, and the edge of the region behind it, tell of the extent."""
    r, c, columns = at
    angle = column_angle(grid.limit[r], c, columns)
    inside = grid.depth[r, c] < 0.0
    if inside:
        if abs(angle) <= thick:
            out[AP] = max(out[AP], e.s[r])
        out[ENTRY] = min(out[ENTRY], max(angle, -thick))
        out[EXIT] = max(out[EXIT], min(angle, thick))
    if c < columns and inside != (grid.depth[r, c + 1] < 0.0):
        angle = min(max(column_angle(grid.limit[r], c + grid.across[r, c], columns), -thick), thick)
        out[ENTRY], out[EXIT] = min(out[ENTRY], angle), max(out[EXIT], angle)
