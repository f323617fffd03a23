"""Speeds and terminations (FINE, CNT) of a TP program.

A TP program has linear speeds in whole mm/sec (1 to 2000), whole cm/min or tenths of inch/min; finer ones cannot be
written. CNT is not a distance: with CNT100 the next move starts when this one begins to slow down, so the corner is
left about half of speed times deceleration time before the pose (never more than half the segment, since a segment is
accelerated in its first and slowed down in its last half); with CNTn in proportion. FINE stands still at the pose.
"""

from __future__ import annotations

import numpy as np

from toolpaths.writing.blending import blending, steps_within
from toolpaths.writing.program import Floats, Program

#: m/s: 2000 mm/sec.
FASTEST = 2.0

#: Relative error of a speed above which a warning is due.
SPEED_ERROR = 0.01

#: s, from full speed to standstill: an assumption, long for every arm, so that corners are missed by less.
DECELERATION = 0.4

_STEPS = (5.0, 10.0, 25.0, 50.0, 75.0, 100.0)
_TERMS = ("FINE", *(f"CNT{n:g}" for n in _STEPS))
#: Turns on the spot that may be rounded, deg.
_TURN = 0.1


def speed_texts(speed: Floats) -> tuple[list[str], Floats]:
    """How each speed (N,) m/s is written, and what that is in m/s; '' and NaN for NaN."""
    values, index = np.unique(speed, return_inverse=True)
    said = [_said(float(v)) for v in values]
    texts = [t for t, _ in said]
    return [texts[i] for i in index.tolist()], np.array([v for _, v in said])[index]


def _said(speed: float) -> tuple[str, float]:
    """The nearest of the three units; the first that is exact enough to print."""
    if not np.isfinite(speed):
        return "", float("nan")
    mm, cm, inch = max(round(speed * 1e3), 1), max(round(speed * 6e3), 1), max(round(speed * 6e5 / 25.4), 1)
    ways = [(f"{mm}mm/sec", mm * 1e-3), (f"{cm}cm/min", cm / 6e3), (f"{inch / 10:.1f}inch/min", inch * 25.4 / 6e5)]
    return min(ways, key=lambda way: round(abs(way[1] / speed - 1.0), 4))


def terminations(program: Program, speed: Floats) -> list[str]:
    """FINE or CNT of each pose, so that its corner is missed by no more than blending.py allows.

    Args:
        program: of N poses.
        speed: (N,) m/s of the move to each pose.
    """
    n = len(program)
    bound = blending(program)
    value = np.zeros(n)
    if n > 2:
        length = np.linalg.norm(np.diff(program.position, axis=0), axis=1)
        half = 0.5 * np.minimum(length[:-1], length[1:])
        reach = 0.5 * DECELERATION * np.maximum(speed[1:-1], speed[2:])
        radius = bound.radius[1:-1]
        free = (radius > 0.0) & (radius >= half * (1.0 - 1e-9))
        value[1:-1] = np.where(free, 100.0, 100.0 * np.minimum(radius / reach, 1.0))
    turn = np.degrees(bound.turn)
    value[(turn > 0.0) & (turn <= _TURN)] = 100.0
    return [_TERMS[i] for i in steps_within(value, _STEPS).tolist()]
