"""Circular test: what ISO 230-4 makes of the readings of a ball-bar, and how far each joint's turning steps the radius.

Deviations are counted from the nominal radius, about the centre that fits the readings of a plane best (least squares):

    d = r - R = e + a cos(t) + b sin(t) + rest        centre (a, b) taken off, e kept

Circular error G: largest less smallest deviation of one direction, bidirectional G(b): of both; mean bidirectional
radial error M: mean of all; radial error F: the largest and the smallest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.session.path_trace import PathTrace
from stiffness.session.turning import turning_rows

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

PLANES = ("YZ", "ZX", "XY")  # by the axis of the base that is nearest to their normal
FEWEST = 12  # readings of a circle
BESIDE = 4  # readings on each side of a turning point


@dataclass(frozen=True)
class TurningPoint:
    """Where a joint turns: ``joint`` from 1, its ``angle`` in rad, the ``place`` on the circle in rad, ``step`` of the
    radius across it, m."""

    joint: int
    angle: float
    place: float
    step: float


@dataclass(frozen=True, repr=False)
class CircularTest:
    """Circles of one plane and one feed; m.

    Attributes:
        plane: XY, YZ or ZX of the base. feed: m/s, NaN where not known.
        centre: (3,) in the base, fitted. rows: (K,) readings. place: (K,) rad on the circle. deviation: (K,).
        clockwise: (K,) seen against the axis that the plane is named by.
    """

    plane: str
    feed: float
    centre: Floats
    rows: Index
    place: Floats
    deviation: Floats
    clockwise: npt.NDArray[np.bool_]
    turning: tuple[TurningPoint, ...]

    def circular_error(self, clockwise: bool) -> float | None:
        """G of one direction; None where it was not run."""
        mine = self.deviation[self.clockwise == clockwise]
        return float(np.ptp(mine)) if len(mine) >= FEWEST else None

    @property
    def bidirectional_circular_error(self) -> float | None:
        """G(b); None where one direction is missing."""
        both = [self.circular_error(True), self.circular_error(False)]
        return None if None in both else float(np.ptp(self.deviation))

    @property
    def mean_bidirectional_radial_error(self) -> float:
        """M."""
        return float(self.deviation.mean())

    @property
    def radial_error(self) -> tuple[float, float]:
        """F: the largest and the smallest deviation."""
        return float(self.deviation.max()), float(self.deviation.min())


def circular_tests(path: PathTrace, radius: Floats) -> list[CircularTest]:
    """Of the readings (N,) m of a ball-bar, measured or predicted, plane by plane and feed by feed."""
    rows = path.rows
    at = rows.at(rows.position, path.index) - path.centre
    high = np.minimum(np.floor(path.index).astype(np.int64) + 1, len(rows) - 1)
    along = rows.position[high] - rows.position[np.maximum(high - 1, 0)]
    normal = np.cross(at, along)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    plane = np.abs(normal).argmax(axis=1)
    feed = np.nan_to_num(rows.feed[np.minimum(np.ceil(path.index).astype(np.int64), len(rows) - 1)])
    out = []
    for p in np.unique(plane):
        for f in np.unique(feed[plane == p]):
            mine = np.flatnonzero((plane == p) & (feed == f))
            if len(mine) >= FEWEST:
                out.append(_test(path, radius, mine=mine, plane=int(p), at=at, normal=normal, feed=float(f)))
    return out


def _test(
    path: PathTrace, radius: Floats, *, mine: Index, plane: int, at: Floats, normal: Floats, feed: float
) -> CircularTest:
    u, v = (plane + 1) % 3, (plane + 2) % 3
    place = np.arctan2(at[mine, v], at[mine, u])
    raw = radius[mine] - path.radius
    design = np.stack([np.ones(len(mine)), np.cos(place), np.sin(place)], axis=1)
    (_, a, b), *_ = np.linalg.lstsq(design, raw, rcond=None)
    centre = path.centre.copy()
    centre[[u, v]] -= [a, b]
    deviation = raw - a * np.cos(place) - b * np.sin(place)
    return CircularTest(
        plane=PLANES[plane],
        feed=feed or float("nan"),
        centre=centre,
        rows=mine,
        place=place,
        deviation=deviation,
        clockwise=normal[mine, plane] < 0,
        turning=tuple(_turning(path, mine=mine, place=place, deviation=deviation, clockwise=normal[mine, plane] < 0)),
    )


def _turning(
    path: PathTrace, *, mine: Index, place: Floats, deviation: Floats, clockwise: npt.NDArray[np.bool_]
) -> list[TurningPoint]:
    """Steps of the deviation where a joint turns, once per joint and turn, in the order of the path; not where the path
    itself turns back, with all joints at once."""
    rows, order = path.rows, np.lexsort((path.index[mine], path.run[mine]))
    index, out = path.index[mine][order], []
    first = path.run[mine][order] == path.run[mine].min()
    index, level, at = index[first], deviation[order][first], place[order][first]
    way = clockwise[order][first]
    for j, turns in enumerate(turning_rows(rows.q)):
        for row in turns:
            k = int(np.searchsorted(index, row, side="right"))
            near = np.arange(k - BESIDE, k + BESIDE)
            if near[0] < 0 or near[-1] >= len(index) or index[near[-1]] - index[near[0]] > 4 * BESIDE:
                continue
            if len(np.unique(way[near])) > 1:
                continue
            side = np.repeat([0.0, 1.0], BESIDE)
            design = np.stack([np.ones(len(near)), index[near] - row, side], axis=1)
            step = float(np.linalg.lstsq(design, level[near], rcond=None)[0][2])
            out.append(TurningPoint(j + 1, float(rows.q[row, j]), place=float(at[k]), step=step))
    return out
