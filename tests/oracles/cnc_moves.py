"""What a second reader of a CNC program finds, and whether a toolpath is the same."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from toolpaths.toolpath import Toolpath

Array = np.ndarray


@dataclass(frozen=True)
class Curve:
    """An arc or helix in the work object: centre (3,) mm, axis (3,), sweep rad about it."""

    center: Array
    axis: Array
    sweep: float


@dataclass(frozen=True)
class CncMove:
    """One move: its end (3,) mm, the tool axis there (3,), mm/min (NaN: rapid), tool, line, the arc if it is one."""

    end: Array
    axis: Array
    feed: float
    tool: int
    line: int
    curve: Curve | None = None


def assert_same(path: Toolpath, moves: list[CncMove], *, atol: float = 1e-6) -> None:
    """Every move in its place, with its axis, feed, tool and line; every point of an arc on it. ``atol``: mm."""
    whole = np.flatnonzero(path.row % 1 == 0)
    seen = path.take(whole)
    assert seen.line.tolist() == [m.line for m in moves]
    assert seen.tool.tolist() == [m.tool for m in moves]
    assert seen.kind.tolist() == [0 if math.isnan(m.feed) else 1 for m in moves]
    np.testing.assert_allclose(seen.position * 1e3, [m.end for m in moves], rtol=0, atol=atol)
    np.testing.assert_allclose(seen.axis, [m.axis for m in moves], rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen.feed * 6e4, [m.feed for m in moves], rtol=1e-9)
    for k, move in enumerate(moves):
        if move.curve is not None:
            between = slice(whole[k - 1] + 1, whole[k])
            share = path.row[between] - path.row[whole[k - 1]]
            expected = along(moves[k - 1].end, move.end, move.curve, share)
            np.testing.assert_allclose(path.position[between] * 1e3, expected, rtol=0, atol=50 * atol)
            assert len(share) >= abs(move.curve.sweep) / (math.pi / 4) - 1.001


def along(start: Array, end: Array, curve: Curve, share: Array) -> Array:
    """Points of an arc or helix, (N, 3) mm, at shares (N,) of its way."""
    axis = curve.axis / np.linalg.norm(curve.axis)
    rise = (end - start) @ axis
    out = start - curve.center
    flat = out - (out @ axis) * axis
    shares = np.append(share, 1.0)
    turned = Rotation.from_rotvec(np.outer(shares * curve.sweep, axis)).apply(flat)
    points = start - flat + turned + np.outer(shares * rise, axis)
    return points[:-1] + np.outer(share, end - points[-1])  # what printing did to the end


def curves_of(moves: list[CncMove]) -> int:
    """How many arcs there are."""
    return sum(m.curve is not None for m in moves)
