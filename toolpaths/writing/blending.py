"""How far a controller may round each pose without leaving the path or eating a neighbouring segment.

Controllers replace the corner at a fly-by pose by a parabola that leaves the path at distance r before the
pose and is back at distance r behind it (ABB 3HAC16580 RAPID overview, "Positioning during program
execution: zones"; KUKA KSS 8.3, "Approximate positioning"). As a quadratic Bezier curve it misses the pose by
r/2 sin(theta/2), theta being the angle by which the direction turns there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.columns import blocks
from toolpaths.rotation import turn_between
from toolpaths.toolpath import CUT
from toolpaths.writing.lines import interrupted
from toolpaths.writing.program import Floats, Program

#: How far a rounded corner may miss its pose, m: in a cut, and where it begins or ends, as much as sampling.
CUT_TOLERANCE = 1e-5
RAPID_TOLERANCE = 5e-4

#: Moves shorter than this, m, are turns on the spot.
STILL = 1e-5


@dataclass(frozen=True)
class Blending:
    """Upper bounds of the rounding at each pose; 0 in both: stop there.

    Attributes:
        radius: (N,) m along the path.
        turn: (N,) rad, where the TCP stands still before and after the pose and only the tool turns.
    """

    radius: Floats
    turn: Floats


def blending(program: Program) -> Blending:
    """The bounds: half the shorter neighbouring segment, and the tolerance in the corner."""
    n = len(program)
    radius, turn = np.zeros(n), np.zeros(n)
    if n < 3:
        return Blending(radius, turn)
    standing = np.zeros(n, dtype=np.bool_)
    for inner in blocks(n - 2):
        b = slice(inner.start + 1, inner.stop + 1)  # not the ends
        radius[b], standing[b] = _radii(program, b)
    still = np.flatnonzero(standing)
    turn[still] = _half_turns(np.asarray(program.rotation), still)
    stop = stops(program)
    radius[stop], turn[stop] = 0.0, 0.0
    return Blending(radius, turn)


def _radii(program: Program, block: slice) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """(K,) radius at poses between two others, and whether the TCP stands still there."""
    step = np.diff(program.position[block.start - 1 : block.stop + 1], axis=0)
    length = np.linalg.norm(step, axis=1)
    shorter = np.minimum(length[:-1], length[1:])
    half_sine = _half_sine(step, length)
    cut = program.kind[block.start : block.stop + 1] == CUT
    tolerance = np.where(cut[:-1] | cut[1:], CUT_TOLERANCE, RAPID_TOLERANCE)
    with np.errstate(divide="ignore"):
        radius = np.minimum(0.5 * shorter, 2.0 * tolerance / half_sine)
    radius[shorter < STILL] = 0.0
    return radius, (length[:-1] < STILL) & (length[1:] < STILL)


def stops(program: Program) -> npt.NDArray[np.bool_]:
    """(N,) poses where the robot has to stand: first, last, exact ones, around a tool change, before what is done."""
    stop = np.zeros(len(program), dtype=bool) if program.exact is None else program.exact.copy()
    stop[[0, -1]] = True
    stop[program.tool_changes] = True
    stop[[pose - 1 for pose in interrupted(program) if pose > 0]] = True
    return stop


def steps_within(bound: Floats, ladder: tuple[float, ...]) -> npt.NDArray[np.intp]:
    """(N,) how many steps of the rising ladder are within each bound; 0: none."""
    return np.searchsorted(np.asarray(ladder), bound * (1.0 + 1e-9), side="right")


def _half_sine(step: Floats, length: Floats) -> Floats:
    """(N-2,) sine of half the angle by which the direction turns; half the chord between unit directions."""
    unit = step / np.maximum(length, 1e-300)[:, None]
    return np.asarray(0.5 * np.linalg.norm(np.diff(unit, axis=0), axis=1), dtype=np.float64)


def _half_turns(rotation: Floats, at: npt.NDArray[np.intp]) -> Floats:
    """(K,) rad, half the smaller of the turns before and after the poses ``at``."""
    if len(at) == 0:
        return np.zeros(0)
    triples = rotation[at[:, None] + np.array([-1, 0, 1])]
    before = np.array([turn_between(t) for t in triples])
    return np.asarray(0.5 * before.min(axis=1))
