"""Rows of moves from the poses of a path: straight runs as one row, turns of the axis in small steps."""

from __future__ import annotations

from math import asin, ceil, sin, sqrt

import numpy as np

from compensator.process.milling.kernels.compiled import compiled, compiled_with_memory
from compensator.process.milling.kernels.lattice import (
    Floats,
    Ints,
)
from compensator.process.milling.kernels.sweep import (
    ACROSS,
    AXIS,
    BEGIN,
    CUTTER,
    END,
    LAST,
    MOVE_COLUMNS,
    REACH,
    RISE,
    RUN,
    START,
    TURN,
    WAY,
)

Bytes = np.ndarray[tuple[int], np.dtype[np.uint8]]

STEP = 0.035  # rad: a row turns by no more
FIXED = 1e-9  # rad: an axis that turns by less stands still
STRAIGHT = 1e-9  # m: poses this near to a straight line are on it
SHARP = 0.9  # cosine of the bend that ends a smooth pass
GENTLE = 0.98  # cosine of the bends that the look-back goes round


@compiled
def turn_between(a: Floats, b: Floats) -> float:
    """Angle between two unit vectors, rad; from the chord, exact for small ones."""
    c = sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)
    return 2.0 * asin(min(0.5 * c, 1.0))


@compiled
def product(row: Floats, i: int, a: int, b: int) -> float:
    """Scalar product of three numbers of a row from column ``a`` on with three from ``b`` on."""
    return row[i, a] * row[i, b] + row[i, a + 1] * row[i, b + 1] + row[i, a + 2] * row[i, b + 2]


@compiled
def _step(end: Floats, start: Floats) -> tuple[float, float, float]:
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


@compiled
def _dot(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _off_line(start: Floats, end: Floats, point: Floats) -> float:
    """Distance of a point from the line between two others, m."""
    w, q = _step(end, start), _step(point, start)
    share = _dot(q, w) / _dot(w, w)
    rest = (q[0] - share * w[0], q[1] - share * w[1], q[2] - share * w[2])
    return sqrt(_dot(rest, rest))


@compiled_with_memory
def runs_of_path(position: Floats, axis: Floats, cutting: Bytes, cutter: Ints) -> tuple[Floats, Ints, Ints, Floats]:
    """Rows of all cutting moves.

    Args:
        position, axis: (N, 3); cutting: (N,) 1 where the move that ends at the pose cuts; cutter: (N,).

    Returns:
        rows (M, 29) with start, way, axes, turn and cutter filled in; last pose of each row (M,); row (N,) that ends at
        a pose or is under way there, -1: none; share (N,) of it that is done there.
    """
    of, share = np.full(len(position), -1, dtype=np.int32), np.zeros(len(position))
    row, last = np.zeros((1, MOVE_COLUMNS)), np.zeros(1, dtype=np.int32)
    count = _runs(row, last, of, position=position, axis=axis, cutting=cutting, cutter=cutter)
    row, last = np.zeros((count, MOVE_COLUMNS)), np.zeros(count, dtype=np.int32)
    _runs(row, last, of, position=position, axis=axis, cutting=cutting, cutter=cutter)
    _shares(row, position, of, share)
    return row, last, of, share


@compiled
def _runs(row: Floats, last: Ints, of: Ints, position: Floats, axis: Floats, cutting: Bytes, cutter: Ints) -> int:
    """Fill in rows and count them; where room ends, from the first one again: only the last is looked at."""
    room = len(row)
    used, first = 0, 0  # first: pose after the start of the run
    for k in range(1, len(position)):
        if not cutting[k]:
            continue
        turn, way = turn_between(axis[k - 1], axis[k]), _step(position[k], position[k - 1])
        if turn <= FIXED and _dot(way, way) == 0.0:
            continue
        before = (used - 1) % room if used > 0 else 0
        if turn <= FIXED and used > 0 and last[before] == k - 1 and cutter[k] == cutter[k - 1]:
            m = row[before]
            if _goes_on(m, position, axis[k], way, ends=(first, k)):
                for a in range(3):
                    m[WAY + a] = position[k, a] - m[START + a]
                last[before], of[k] = k, used - 1
                continue
        first, begin = k, used
        used = _turned_rows(row, last, used, k, position=position, axis=axis, turn=turn)
        of[k] = used - 1
        for i in range(begin, used):
            row[i % room, CUTTER] = cutter[k]
    return used


@compiled
def _goes_on(
    m: Floats, position: Floats, axis: Floats, way: tuple[float, float, float], ends: tuple[int, int]
) -> bool:
    """Whether a move goes straight on from the row before it; ``ends``: first pose of that row, last of the move."""
    first, k = ends
    ahead = way[0] * m[WAY] + way[1] * m[WAY + 1] + way[2] * m[WAY + 2] > 0.0
    start = m[START : START + 3]
    return (
        m[TURN] == 0.0
        and ahead
        and turn_between(m[AXIS : AXIS + 3], axis) <= FIXED
        and _off_line(start, position[k], position[first]) < STRAIGHT
        and _off_line(start, position[k], position[k - 1]) < STRAIGHT
    )


@compiled
def _turned_rows(
    row: Floats, last: Ints, used: int, k: int, position: Floats, axis: Floats, turn: float
) -> int:
    """One move as rows that turn a little each; the number of rows then."""
    parts = max(1, ceil(turn / STEP)) if turn > FIXED else 1
    for i in range(parts):
        m, a, b = row[used % len(row)], i / parts, (i + 1) / parts
        p0, p1, q0, q1 = 0.0, 1.0, 0.0, 1.0  # shares of both axes at the start and at the end
        m[TURN] = 0.0
        if turn > FIXED:
            s = sin(turn)
            p0, p1, q0, q1 = sin((1 - a) * turn) / s, sin(a * turn) / s, sin((1 - b) * turn) / s, sin(b * turn) / s
            m[TURN] = turn / parts
        for c in range(3):
            way = position[k, c] - position[k - 1, c]
            m[START + c], m[WAY + c] = position[k - 1, c] + a * way, way / parts
            m[AXIS + c] = p0 * axis[k - 1, c] + p1 * axis[k, c]
            m[LAST + c] = q0 * axis[k - 1, c] + q1 * axis[k, c]
        last[used % len(row)] = k
        used += 1
    return used


@compiled
def _shares(row: Floats, position: Floats, of: Ints, share: Floats) -> None:
    """How much of its row is done at a pose."""
    for k in range(len(of)):
        if of[k] >= 0:
            i, done = of[k], 0.0
            square = product(row, i, WAY, WAY)
            for c in range(3):
                done += (position[k, c] - row[i, START + c]) * row[i, WAY + c]
            done = done / square if square > 0.0 else 1.0
            share[k] = 1.0 if row[i, TURN] > 0.0 or done > 1.0 - 1e-9 else done


@compiled
def complete_rows(row: Floats) -> None:
    """What the distances and the passes need beside profile, reach, start, way and axes."""
    at, number = 0.0, 0
    for i in range(len(row)):
        row[i, RISE] = product(row, i, WAY, AXIS)
        square = product(row, i, WAY, WAY)
        row[i, ACROSS] = max(square - row[i, RISE] * row[i, RISE], 0.0)
        if row[i, ACROSS] < 1e-18 * square:
            row[i, ACROSS] = 0.0
        if abs(row[i, RISE]) < 1e-9 * sqrt(square):
            row[i, RISE] = 0.0
        if i > 0 and not _smooth(row, i):
            number += 1
        row[i, RUN], row[i, BEGIN] = number, at
        at += sqrt(square) + row[i, TURN] * row[i, REACH] * 0.5
        row[i, END] = at


@compiled
def _smooth(row: Floats, i: int) -> bool:
    """Whether a row goes on from the one before it without a sharp bend, with the same cutter."""
    size = sqrt(product(row, i, WAY, WAY) * product(row, i - 1, WAY, WAY))
    along, gap = 0.0, 0.0
    for c in range(3):
        along += row[i, WAY + c] * row[i - 1, WAY + c]
        gap = max(gap, abs(row[i - 1, START + c] + row[i - 1, WAY + c] - row[i, START + c]))
    return along >= SHARP * size and gap < 1e-9 and row[i, CUTTER] == row[i - 1, CUTTER]


@compiled_with_memory
def look_back(position: Floats, cutting: Bytes, cutter: Ints, reach: Floats) -> tuple[Ints, Floats]:
    """Which moves do not count as made yet at each pose, so that what is engaged does not depend on their length.

    Args:
        reach: (C,) m of path that has to count as not yet made.

    Returns:
        first pose (N,) whose move does not count; m (N,) that is missing at corners, where the look-back ends.
    """
    begun, ahead = np.zeros(len(position), dtype=np.int32), np.zeros(len(position))
    for k in range(1, len(position)):
        begun[k] = k
        if cutting[k]:
            begun[k], done = _way_back(position, cutting, cutter, k, reach=reach[cutter[k]])
            ahead[k] = max(reach[cutter[k]] - done, 0.0)
        begun[k] = max(begun[k], begun[k - 1])
    return begun, ahead


@compiled
def _way_back(position: Floats, cutting: Bytes, cutter: Ints, k: int, reach: float) -> tuple[int, float]:
    first = _step(position[k], position[k - 1])
    done, j = sqrt(_dot(first, first)), k
    size = done
    while done < reach and j > 1 and cutting[j - 1] and cutter[j - 1] == cutter[k]:
        way = _step(position[j - 1], position[j - 2])
        length = sqrt(_dot(way, way))
        if _dot(way, first) < GENTLE * length * size:
            break
        done, j = done + length, j - 1
    return j, done
