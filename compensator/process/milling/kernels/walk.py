"""Walk: pose by pose along a path, what is engaged there and what is hit, and the moves taken away from the stock."""

from __future__ import annotations

from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.chip import (
    AP,
    AREA,
    ENTRY,
    EXIT,
    PEAK,
    VOLUME,
    add_cells,
    extent,
)
from compensator.process.milling.kernels.compiled import compiled
from compensator.process.milling.kernels.contact import cross, fill
from compensator.process.milling.kernels.field import CELL, DONE, Field
from compensator.process.milling.kernels.hits import above_edge, rapid_hits, stack_hits
from compensator.process.milling.kernels.lattice import (
    Envelope,
    Floats,
    Ints,
    Lattice,
    Stand,
)
from compensator.process.milling.kernels.peak import edges_of, peak_force
from compensator.process.milling.kernels.sweep import Point
from compensator.process.milling.kernels.writing import room_for, write_move

IDLE, CUTTING, RAPID_MOVE = 0, 1, 2
LIKE = 0.2  # share by which the removal at both ends of a move may differ for their mean to be that in between
PARTS, MOST_PARTS = 6, 24  # of a move whose removal changes; half a radius each in between


class PathPoses(NamedTuple):
    """A stretch of N poses of a path, m and rad; ``begun`` and the last three count from its beginning.

    Attributes:
        kind: (N,) IDLE, CUTTING or RAPID_MOVE, of the move that ends there.
        cutter: (N,) row of profiles.
        tip: (N, 3); axes: (N, 3, 3) rows x, y, z of the stand.
        feed: (N, 2) m per tooth along x and z.
        motion: (N, 6) way and turn of the move, in axes of the stand.
        ahead: (N,) m that the cutter is moved on along its feed: what is left of the look-back at a corner.
        begun: (N,) first pose of the path whose move counts as not yet made.
        move, share: of all poses of the path, the row of moves that ends there or is under way, and how much of it is
            done; -1: none.
        last: (M,) the pose at which a row of moves is done.
    """

    kind: npt.NDArray[np.uint8]
    cutter: Ints
    tip: Floats
    axes: Floats
    feed: Floats
    motion: Floats
    ahead: Floats
    begun: npt.NDArray[np.int64]
    move: Ints
    share: Floats
    last: npt.NDArray[np.int64]


class Tools(NamedTuple):
    """What the force and the hits need of each cutter.

    Attributes:
        teeth: (C,); lag: (C,) rad per m; step: (C, most teeth) m of run-out; coefficients: (6,) N/m2, N/m.
        stack: (C, K, 4) cylinders above the edge: lower and upper end (m above the tip), radius, 1 shank or 2 holder.
    """

    teeth: Ints
    lag: Floats
    step: Floats
    coefficients: Floats
    stack: Floats


@compiled
def walk(
    f: Field, e: Envelope, grid: Lattice, poses: PathPoses, tools: Tools, begin: int, end: int, out: Floats, hits: Ints
) -> int:
    """PathPoses ``begin``, of which 1 pose is before, to ``end``; the first that is not done: the field has no room for
    its move.

    Args:
        out: (N, 42) see chip.py; hits: (N,) bits of hits.py.
    """
    for k in range(begin, end):
        while f.state[DONE] < len(poses.last) and poses.last[f.state[DONE]] < poses.begun[k]:
            if not room_for(f, f.state[DONE]):
                return k
            write_move(f, f.state[DONE])
        if poses.kind[k] == CUTTING:
            stand = stand_at(f, poses, k, 1.0)
            if poses.feed[k, 0] > 0.0 or poses.feed[k, 1] != 0.0:
                _engage(f, e, grid, poses, tools=tools, k=k, stand=stand, out=out[k])
                hits[k] |= above_edge(f, e, stand, out[k, AP])
            hits[k] |= stack_hits(f, stand, tools.stack[stand.cutter])
            if poses.kind[k - 1] == CUTTING or out[k, AREA] > 0.0:
                _between(f, e, grid, poses, k=k, out=out)
        elif poses.kind[k] == RAPID_MOVE:
            stand = stand_at(f, poses, k, 1.0)
            hits[k] |= rapid_hits(f, e, stand, poses.motion[k], stack=tools.stack[stand.cutter])
    return end


@compiled
def stand_at(f: Field, poses: PathPoses, k: int, share: float) -> Stand:
    """The cutter at a share of the move that ends at pose k."""
    a, way, turn = poses.axes[k], poses.motion[k, :3], poses.motion[k, 3:]
    back = share - 1.0
    x, y, z = (a[0, 0], a[0, 1], a[0, 2]), (a[1, 0], a[1, 1], a[1, 2]), (a[2, 0], a[2, 1], a[2, 2])
    fx, fz = poses.feed[k, 0], poses.feed[k, 1]
    size = sqrt(fx * fx + fz * fz)
    on = poses.ahead[k] / size if size > 0.0 else 0.0
    u, v, w = back * way[0] + on * fx, back * way[1], back * way[2] + on * fz
    tip = (
        poses.tip[k, 0] + u * x[0] + v * y[0] + w * z[0],
        poses.tip[k, 1] + u * x[1] + v * y[1] + w * z[1],
        poses.tip[k, 2] + u * x[2] + v * y[2] + w * z[2],
    )
    if back != 0.0 and (turn[0] != 0.0 or turn[1] != 0.0):
        x, y, z = _turned(x, y, z, along=(back * turn[1], -back * turn[0]))
    before = poses.begun[k] - 1
    part, done = -1, 0.0
    if before >= 0 and poses.move[before] >= f.state[DONE]:
        part, done = poses.move[before], poses.share[before]
    return Stand(tip, x, y, z, fx=fx, fz=fz, cutter=poses.cutter[k], part=part, share=done)


@compiled
def _turned(x: Point, y: Point, z: Point, along: tuple[float, float]) -> tuple[Point, Point, Point]:
    """Axes whose z went a little along x and y."""
    a, b = along
    size = 1.0 / sqrt(1.0 + a * a + b * b)
    w = ((z[0] + a * x[0] + b * y[0]) * size, (z[1] + a * x[1] + b * y[1]) * size, (z[2] + a * x[2] + b * y[2]) * size)
    u = _normal_to(x, w)
    return u, _normal_to(_normal_to(y, w), u), w


@compiled
def _normal_to(v: Point, n: Point) -> Point:
    """The part of v normal to the unit vector n, of length 1."""
    dot = v[0] * n[0] + v[1] * n[1] + v[2] * n[2]
    w = (v[0] - dot * n[0], v[1] - dot * n[1], v[2] - dot * n[2])
    size = 1.0 / sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    return w[0] * size, w[1] * size, w[2] * size


@compiled
def _engage(
    f: Field, e: Envelope, grid: Lattice, poses: PathPoses, tools: Tools, k: int, stand: Stand, out: Floats
) -> None:
    """What is engaged at one pose, and its force: one row of the answers."""
    columns, inside = fill(f, e, stand, grid)
    if inside == 0:
        return
    cross(f, e, stand, grid, columns=columns)
    add_cells(e, stand, grid, columns=columns, motion=poses.motion[k], out=out)
    out[ENTRY], out[EXIT] = np.inf, -np.inf
    extent(e, stand, grid, columns=columns, out=out)
    c = stand.cutter
    count = edges_of(e, stand, grid, columns=columns, lag=tools.lag[c])
    teeth = tools.teeth[c]
    out[PEAK] = peak_force(
        stand, grid.edges, count, teeth=teeth, coefficients=tools.coefficients, step=tools.step[c, :teeth]
    )


@compiled
def _removal(f: Field, e: Envelope, grid: Lattice, stand: Stand, motion: Floats, room: Floats) -> float:
    """Volume that the move would remove if all of it removed as much as it does here, m3."""
    for i in range(len(room)):
        room[i] = 0.0
    columns, inside = fill(f, e, stand, grid)
    if inside > 0:
        cross(f, e, stand, grid, columns=columns)
        add_cells(e, stand, grid, columns=columns, motion=motion, out=room)
    return room[VOLUME]


@compiled
def _between(f: Field, e: Envelope, grid: Lattice, poses: PathPoses, k: int, out: Floats) -> None:
    """Volume that a move removes, from the removal at both ends, and in between where that changes."""
    way, before = _length(poses.motion[k]), _length(poses.motion[k - 1])
    here = out[k, VOLUME]
    there = out[k - 1, VOLUME] / before * way if before > 0.0 else 0.0
    if way < f.frame[CELL]:
        return
    if abs(here - there) <= LIKE * here:
        out[k, VOLUME] = 0.5 * (here + there)
        return
    room = grid.room
    total = 0.0
    parts = min(max(PARTS, ceil(2.0 * way / e.rho[e.first[poses.cutter[k] + 1] - 1])), MOST_PARTS)
    for part in range(parts):
        stand = stand_at(f, poses, k, (part + 0.5) / parts)
        total += _removal(f, e, grid, stand, motion=poses.motion[k], room=room)
    out[k, VOLUME] = total / parts


@compiled
def _length(motion: Floats) -> float:
    return sqrt(motion[0] * motion[0] + motion[1] * motion[1] + motion[2] * motion[2])
