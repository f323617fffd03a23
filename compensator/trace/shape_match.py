"""Shape match: where along a path points were read that have an order and no place: dynamic time warping.

The places nearest to the points, all together, that never go back along the path (Sakoe & Chiba 1978);
then every point is put at the foot of its perpendicular. The frame of points that are not in the base is first that of
equal shares of arc length, then that of the places (iterative closest point, Besl & McKay 1992).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.station import rigid_fit

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

MOST = 1200  # points that are matched; those between follow them
PLACES = 4000  # along the path
FASTER = 2.0  # times as far along the path as between two points: a corner that was cut, and noise
PLACINGS = 12  # of a frame, at most
SETTLED = 1e-3  # of the distance: a placing that brings less is the last
FEET = 4  # steps to the foot of a perpendicular


@dataclass(frozen=True, repr=False)
class PointsOnPath:
    """Points on a path.

    Attributes:
        arc: (N,) m along the path. tangent: (N, 3) of the path there, in the axes of the points.
        distance: m RMS from the path, where they were placed. shift: m RMS by which that moved points in its frame.
    """

    arc: Floats
    tangent: Floats
    distance: float
    shift: float


def arc_length(position: Floats) -> Floats:
    """(R,) m along a path (R, 3)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1))])


def placed_by_shape(point: Floats, run: Ints, path: Floats, *, registered: bool) -> PointsOnPath:
    """Where on a path (R, 3) m points (N, 3) m were read, in their order, run by run.

    Args:
        run: (N,) each from the start of the path. registered: points are in the frame of the path.
    """
    length = arc_length(path)
    runs = [np.flatnonzero(run == one) for one in np.unique(run)]
    some = [_spaced(point[mine], length[-1] / MOST) for mine in runs]
    if registered:
        told = np.concatenate([_monotone(point[mine[at]], path, length) for mine, at in zip(runs, some, strict=True)])
    else:
        shares = [arc_length(point[mine[at]]) for mine, at in zip(runs, some, strict=True)]
        told = np.concatenate([share / max(float(share[-1]), 1e-9) * length[-1] for share in shares])
    rotation, origin = _framed(point, path, length, runs=runs, some=some, told=told)
    base = point @ rotation.T + origin
    arc = np.empty(len(point))
    for mine, at in zip(runs, some, strict=True):
        told = _monotone(base[mine[at]], path, length)
        arc[mine] = _feet(base[mine], np.interp(np.arange(len(mine)), at, told), path, length)
    foot, tangent = _at(arc, path, length)
    distance = float(np.sqrt(np.mean(np.sum((base - foot) ** 2, axis=1))))
    shift = float(np.sqrt(np.mean(np.sum((base - point) ** 2, axis=1)))) if registered else 0.0
    return PointsOnPath(arc=arc, tangent=tangent @ rotation, distance=distance, shift=shift)


def _spaced(point: Floats, apart: float) -> Ints:
    """Points that lie ``apart`` m from the one before, the first and the last among them."""
    kept, last = [0], point[0]
    for k in range(1, len(point)):
        if float(np.linalg.norm(point[k] - last)) >= apart:
            kept.append(k)
            last = point[k]
    return np.unique([*kept, len(point) - 1])


def _framed(
    point: Floats, path: Floats, length: Floats, *, runs: list[Ints], some: list[Ints], told: Floats
) -> tuple[Floats, Floats]:
    """Rotation (3, 3) and origin (3,) of the frame of points, in that of the path, from first places ``told`` (K,) m.

    Points in the base are placed as well: a sag would draw them along the path where it runs upright.
    """
    few = np.concatenate([mine[at] for mine, at in zip(runs, some, strict=True)])
    ends = np.cumsum([len(at) for at in some])[:-1]
    before = np.inf
    for _ in range(PLACINGS):
        foot, _ = _at(told, path, length)
        rotation, origin = rigid_fit(point[few], foot)
        base = point[few] @ rotation.T + origin
        told = np.concatenate([_monotone(part, path, length) for part in np.split(base, ends)])
        told = _feet(base, told, path, length)
        off = float(np.sqrt(np.mean(np.sum((base - _at(told, path, length)[0]) ** 2, axis=1))))
        if off > before * (1 - SETTLED):
            break
        before = off
    return rotation, origin


def _monotone(point: Floats, path: Floats, length: Floats) -> Floats:
    """(K,) m along the path, never back, that leave the least squares of distances, and of steps as long as those of
    the points: where a path turns back on itself both ways lie equally near."""
    place = np.linspace(0.0, length[-1], PLACES)
    spot, _ = _at(place, path, length)
    way = np.linalg.norm(np.diff(point, axis=0), axis=1)
    most = np.ceil(FASTER * way / place[1]).astype(np.int64) + 2
    cost = np.sum((point[0] - spot) ** 2, axis=1)
    back = np.zeros((len(point), PLACES), dtype=np.int32)
    for k in range(1, len(point)):
        best, came = cost + way[k - 1] ** 2, np.zeros(PLACES, dtype=np.int32)
        for step in range(1, int(most[k - 1]) + 1):
            by_step = cost[:-step] + (step * place[1] - way[k - 1]) ** 2
            nearer = by_step < best[step:]
            best[step:][nearer] = by_step[nearer]
            came[step:][nearer] = step
        cost = best + np.sum((point[k] - spot) ** 2, axis=1)
        back[k] = came
    at = int(np.argmin(cost))
    out = np.empty(len(point))
    for k in range(len(point) - 1, -1, -1):
        out[k] = place[at]
        at -= int(back[k, at])
    return out


def _feet(point: Floats, arc: Floats, path: Floats, length: Floats) -> Floats:
    """(N,) m along the path to the feet of perpendiculars near ``arc`` (N,)."""
    near = 2 * length[-1] / MOST
    out = arc.copy()
    for _ in range(FEET):
        foot, tangent = _at(out, path, length)
        out = np.clip(out + np.sum((point - foot) * tangent, axis=1), arc - near, arc + near)
    return np.clip(out, 0.0, length[-1])


def _at(arc: Floats, path: Floats, length: Floats) -> tuple[Floats, Floats]:
    """Points (N, 3) and tangents (N, 3) of a path at lengths (N,)."""
    moved = np.flatnonzero(np.diff(length) > 0)
    begin = length[moved]
    k = moved[np.clip(np.searchsorted(begin, arc, side="right") - 1, 0, len(moved) - 1)]
    tangent = (path[k + 1] - path[k]) / (length[k + 1] - length[k])[:, None]
    return path[k] + (arc - length[k])[:, None] * tangent, tangent
