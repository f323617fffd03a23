"""Outline: rows along the profile of every cutter, where its engagement is looked at."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, pi

import numpy as np
import numpy.typing as npt

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.kernels.chip import OUT_COLUMNS
from compensator.process.milling.kernels.lattice import (
    COLUMNS,
    Envelope,
    Lattice,
)
from compensator.process.milling.kernels.peak import EDGE_COLUMNS

Floats = npt.NDArray[np.float64]

LINE_ROWS = 10  # per radius of the cutter, along straight parts
ARC_ROWS = 20  # per radius of the cutter, along arcs
FEWEST = 6
NEAR_TIP = (0.005, 0.01, 0.02, 0.035)  # rad: there the chip is so thin that edge terms rise
MOST_EDGES = 4000


def envelope_of(cutters: Sequence[Cutter], cell: float) -> Envelope:
    """The rows of all cutters; on straight parts not further apart than a cell (m) of the grid."""
    parts = [outline_rows(c, cell) for c in cutters]
    rows = np.concatenate(parts)
    first = np.cumsum([0, *(len(p) for p in parts)]).astype(np.int32)
    profile = np.array([c.profile for c in cutters])
    rho, s, kappa, along = np.ascontiguousarray(rows.T[:4])
    return Envelope(rho, s, kappa, along, open=rows[:, 4].astype(np.int32), first=first, profile=profile)


def outline_rows(cutter: Cutter, cell: float) -> Floats:
    """(R, 5) rho, s, kappa, length of the outline up to there, 1 where it goes on."""
    r, arc, half = cutter.radius, cutter.arc, cutter.half_angle
    flat, out = r - arc, list[Floats]()
    side = 0.5 * pi - half
    step = min(r / LINE_ROWS, cell)
    if cutter.shape == "drill":
        out.append(_line((0.0, 0.0), (r, cutter.arc_height), side, r / ARC_ROWS))
        out.append(_line((r, cutter.arc_height), (r, cutter.length), 0.5 * pi, step))
    else:
        if flat > 0:
            out.append(_line((0.0, 0.0), (flat, 0.0), 0.0, r / LINE_ROWS))
        if arc > 0:
            kappa = np.linspace(1e-9, side, max(ceil(arc * side / (r / ARC_ROWS)), FEWEST) + 1)
            kappa = np.insert(kappa, 1, [k for k in NEAR_TIP if k < 0.8 * kappa[1]])
            out.append(np.column_stack([flat + arc * np.sin(kappa), arc * (1 - np.cos(kappa)), kappa, arc * kappa]))
        start = (flat + arc * np.sin(side), cutter.arc_height)
        out.append(_line(start, (cutter.largest_radius, cutter.length), side, step))
    long = [p for p in out if p[-1, 3] > 0]
    return np.concatenate([np.column_stack([p, np.arange(len(p)) < len(p) - 1]) for p in long])


def _line(start: tuple[float, float], end: tuple[float, float], kappa: float, step: float) -> Floats:
    """(R, 4) rows of a straight part."""
    length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
    share = np.linspace(0.0, 1.0, max(ceil(length / step - 1e-9), 1) + 1)
    points = np.outer(1 - share, start) + np.outer(share, end)
    return np.column_stack([points, np.full(len(share), kappa), share * length])


def lattice_for(envelope: Envelope) -> Lattice:
    """Room for the answers at one pose."""
    rows = len(envelope.rho)
    return Lattice(
        np.zeros(rows),
        _turn(),
        found=np.zeros(rows, dtype=np.int32),
        depth=np.zeros((rows, COLUMNS + 1)),
        across=np.zeros((rows, COLUMNS)),
        up=np.zeros((rows, COLUMNS + 1)),
        bend=np.zeros((rows, COLUMNS)),
        edges=np.zeros((MOST_EDGES, EDGE_COLUMNS)),
        corner=np.zeros((8, 2)),
        room=np.zeros(OUT_COLUMNS),
    )


def _turn() -> Floats:
    """(5, COLUMNS + 1), see Lattice."""
    turn = np.zeros((5, COLUMNS + 1))
    for k, columns in enumerate((COLUMNS // 2, COLUMNS)):
        turn[k, : columns + 1] = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, columns + 1))
    return turn
