"""Paths, cutters and stocks that the milling tests cut with; mm at the door, SI behind."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.path import MillingPath
from compensator.process.milling.stock import Stock, box_stock

Floats = npt.NDArray[np.float64]

K7075 = np.array([796e6, 168e6, 222e6, 27.7e3, 30.8e3, 1.4e3])  # N/m2, N/m: the set of the contract's closed forms
FLAT20 = Cutter("flat", 0.020, 4, 0.025)


def path(
    points: npt.ArrayLike,
    cutter: Cutter = FLAT20,
    *,
    axis: npt.ArrayLike = (0.0, 0.0, 1.0),
    feed_per_tooth: float = 1e-4,
    rapid: npt.ArrayLike = False,
    sense: int = 1,
) -> MillingPath:
    """A path through points (N, 3) in mm; axis one or (N, 3), any length."""
    position = np.array(points, dtype=float) * 1e-3
    n = len(position)
    tool = np.broadcast_to(np.array(axis, dtype=float), (n, 3))
    return MillingPath(
        position,
        tool / np.linalg.norm(tool, axis=1, keepdims=True),
        feed=np.full(n, feed_per_tooth * cutter.flutes * 100.0),
        spindle=np.full(n, 100.0),
        sense=np.full(n, sense, dtype=np.int8),
        rapid=np.broadcast_to(np.array(rapid, dtype=bool), (n,)).copy(),
        cutter=np.zeros(n, dtype=np.int32),
        cutters=(cutter,),
    )


def along_x(start: float, end: float, step: float, *, y: float = 0.0, z: float = 0.0) -> Floats:
    """Points (N, 3) of a straight line, mm."""
    x = np.linspace(start, end, round(abs(end - start) / step) + 1)
    return np.column_stack([x, np.full(len(x), y), np.full(len(x), z)])


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Stock:
    """A box, mm."""
    return box_stock(np.array(low) * 1e-3, np.array(high) * 1e-3)


def arc_force(
    entry: float, exit: float, *, ap: float, feed: float, teeth: int, coefficients: Floats = K7075
) -> Floats:
    """Mean force (3,) N of a flat end mill in path axes: the closed form of the arc from entry to exit (rad).

    From dF = -(ktc h + kte) t db - (krc h + kre) n db + (kac h + kae) z db with h = f cos(theta), integrated by hand;
    of the edge terms is taken off what they lack while h is below a micrometre.
    """
    ktc, krc, kac, kte, kre, kae = coefficients
    a, b = entry, exit
    cc = (b - a) / 2 + (np.sin(2 * b) - np.sin(2 * a)) / 4  # integral of cos^2
    sc = (np.sin(b) ** 2 - np.sin(a) ** 2) / 2  # of sin cos
    s, c = np.cos(a) - np.cos(b), np.sin(b) - np.sin(a)  # of sin, of cos
    thin = np.linspace(a, b, 400001)
    lack = 1 - np.minimum(feed * np.cos(thin) / 1e-6, 1)
    less = [float(np.trapezoid(lack * v, thin)) for v in (np.sin(thin), np.cos(thin), np.ones(len(thin)))]
    x = feed * (ktc * sc - krc * cc) + kte * (s - less[0]) - kre * (c - less[1])
    y = -feed * (ktc * cc + krc * sc) - kte * (c - less[1]) - kre * (s - less[0])
    z = feed * kac * c + kae * (b - a - less[2])
    return np.asarray(teeth * ap / (2 * np.pi) * np.array([x, y, z]))
