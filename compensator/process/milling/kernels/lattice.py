"""Lattice: the places of a cutter's envelope at one pose: rows along its outline, columns over the angles."""

from __future__ import annotations

from math import acos, cos, pi, sin
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.profile import RC, E
from compensator.process.milling.kernels.sweep import Point

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]

COLUMNS = 96  # most columns; half of them where the envelope goes forward over half of its turn


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
        return pi if down > 1e-9 * (stand.fx + abs(stand.fz)) else 0.0
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
