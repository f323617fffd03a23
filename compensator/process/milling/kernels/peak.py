"""Peak: the largest norm of the force over a turn, all teeth, with the lag of the edge up the tool and run-out."""

from __future__ import annotations

from math import ceil, cos, floor, pi, sin, sqrt

from compensator.process.milling.kernels.chip import EDGE_RISE, cell_share, chip_thickness
from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.lattice import (
    COLUMNS,
    Envelope,
    Floats,
    Lattice,
    Stand,
    column_angle,
    outline_at,
)

FROM, TO, LAG, LENGTH, KAPPA = range(5)
EDGE_COLUMNS = 5
"""A piece of edge: engaged from and to (rad), its lag (rad), its length (m) and the angle of its normal."""

_STEP = pi / 60.0  # rad between the angles of the spindle that are tried beside the ends of engagement
_LAG_STEP = pi / 120.0  # rad of lag that one piece of edge may have
_FEW = 24  # ends of engagement that are tried


@compiled
def edges_of(e: Envelope, stand: Stand, grid: Lattice, columns: int, lag: float) -> int:
    """Pieces of edge with their engaged angles into ``grid.edges``, and their number.

    Args:
        lag: rad per m up the tool.
    """
    count = 0
    for r in range(e.first[stand.cutter], e.first[stand.cutter + 1] - 1):
        if not e.open[r] or grid.found[r] + grid.found[r + 1] == 0:
            continue
        _, s, kappa = outline_at(e, stand.cutter, r, 0.5)
        limit = 0.5 * (grid.limit[r] + grid.limit[r + 1])
        pieces = 1 + int(abs(lag * (e.s[r + 1] - e.s[r])) / _LAG_STEP)
        c = 0
        while c < columns:
            begin, c, total = _run(grid, r, c, columns=columns)
            if total <= 0.0:
                continue
            start = column_angle(limit, begin + _begins(grid, r, begin), columns)
            stop = column_angle(limit, c - 1 + _ends(grid, r, c - 1), columns)
            share = min(limit * total / max(stop - start, 1e-6), 1.0)
            length = share * (e.along[r + 1] - e.along[r]) / pieces
            for k in range(pieces):
                if count == len(grid.edges):
                    return count
                at = s + ((k + 0.5) / pieces - 0.5) * (e.s[r + 1] - e.s[r])
                grid.edges[count, FROM], grid.edges[count, TO] = start, stop
                grid.edges[count, LAG], grid.edges[count, LENGTH] = lag * at, length
                grid.edges[count, KAPPA] = kappa
                count += 1
    return count


@compiled
def _run(grid: Lattice, r: int, c: int, columns: int) -> tuple[int, int, float]:
    """The next engaged cells of a strip: the first, the one behind the last, and their angles by the limit."""
    while c < columns and not _any_inside(grid, r, c):
        c += 1
    begin, total, share = c, 0.0, (0 if columns < COLUMNS else 1)
    while c < columns and _any_inside(grid, r, c):
        total += cell_share(grid, r, c)[0] * (grid.turn[share, c + 1] - grid.turn[share, c])
        c += 1
    return begin, c, total


@compiled
def _any_inside(grid: Lattice, r: int, c: int) -> bool:
    lower = grid.depth[r, c] < 0.0 or grid.depth[r, c + 1] < 0.0
    return lower or grid.depth[r + 1, c] < 0.0 or grid.depth[r + 1, c + 1] < 0.0


@compiled
def _begins(grid: Lattice, r: int, c: int) -> float:
    """Where in its first cell a strip begins to be engaged: the mean of its two rows."""
    total, rows = 0.0, 0
    for q in (r, r + 1):
        if grid.depth[q, c] < 0.0:
            rows += 1
        elif grid.depth[q, c + 1] < 0.0:
            total, rows = total + grid.across[q, c], rows + 1
    return total / rows if rows > 0 else 0.0


@compiled
def _ends(grid: Lattice, r: int, c: int) -> float:
    """Where in its last cell a strip ends to be engaged."""
    total, rows = 0.0, 0
    for q in (r, r + 1):
        if grid.depth[q, c + 1] < 0.0:
            total, rows = total + 1.0, rows + 1
        elif grid.depth[q, c] < 0.0:
            total, rows = total + grid.across[q, c], rows + 1
    return total / rows if rows > 0 else 1.0


@compiled
def peak_force(stand: Stand, edges: Floats, count: int, teeth: int, coefficients: Floats, step: Floats) -> float:
    """Largest norm of the force over a turn, N.

    Args:
        edges: as ``edges_of`` leaves them, ``count`` of them.
        coefficients: (6,) ktc, krc, kac (N/m2), kte, kre, kae (N/m).
        step: (teeth,) m that a tooth stands out further than the one before it.
    """
    if count == 0:
        return 0.0
    even = True
    for v in step:
        even = even and v == 0.0
    period = 2.0 * pi / teeth if even else 2.0 * pi
    best, tries = 0.0, ceil(period / _STEP)
    for k in range(tries):
        best = max(best, _norm(stand, edges, count, k * period / tries, coefficients=coefficients, step=step))
    every = max(1, count // _FEW)
    for i in range(0, count, every):
        for end in (FROM, TO):
            inward = 1e-9 if end == FROM else -1e-9
            for tooth in range(1 if even else teeth):
                turned = edges[i, end] + edges[i, LAG] + inward - tooth * 2.0 * pi / teeth
                best = max(best, _norm(stand, edges, count, turned, coefficients=coefficients, step=step))
    return best


@compiled
def _norm(stand: Stand, edges: Floats, count: int, turned: float, coefficients: Floats, step: Floats) -> float:
    """Norm of the force with tooth 0 at the angle ``turned`` at the tip, N."""
    fx, fy, fz = 0.0, 0.0, 0.0
    teeth = len(step)
    for i in range(count):
        for tooth in range(teeth):
            angle = turned + tooth * 2.0 * pi / teeth - edges[i, LAG]
            angle -= 2.0 * pi * floor((angle - edges[i, FROM]) / (2.0 * pi))
            if angle > edges[i, TO]:
                continue
            h = chip_thickness(stand, edges[i, KAPPA], angle) + step[tooth] * sin(edges[i, KAPPA])
            if h <= 0.0:
                continue
            rise = min(h / EDGE_RISE, 1.0)
            ft = (coefficients[0] * h + coefficients[3] * rise) * edges[i, LENGTH]
            fn = (coefficients[1] * h + coefficients[4] * rise) * edges[i, LENGTH]
            fa = (coefficients[2] * h + coefficients[5] * rise) * edges[i, LENGTH]
            c, d, sk, ck = cos(angle), sin(angle), sin(edges[i, KAPPA]), cos(edges[i, KAPPA])
            fx += ft * d - fn * sk * c - fa * ck * c
            fy += -ft * c - fn * sk * d - fa * ck * d
            fz += -fn * ck + fa * sk
    return sqrt(fx * fx + fy * fy + fz * fz)
