"""The direction of the last real travel of every joint: a command that only rounds does not reverse a joint."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import REVERSAL
from stiffness.effects.memory import Clamp
from stiffness.memory.clamp_scan import scan
from stiffness.memory.preload import PreloadState

Floats = npt.NDArray[np.float64]

TOGETHER = 65536  # poses at a time: ten numbers of each are looked at


def last_direction(move: Floats) -> Floats:
    """(N, n): the sign of the last travel of more than REVERSAL, up to every pose; 0 before the first.

    Args:
        move: (N, n) rad, from the pose before to this one.
    """
    out = np.zeros_like(move)
    states = np.outer([-1.0, 1.0, 0.0], np.ones(move.shape[1]))[:, None]
    for first in range(0, len(move), TOGETHER):
        b = slice(first, first + TOGETHER)
        one = np.ones_like(move[b])
        states = scan(Clamp(move[b] / (0.5 * REVERSAL), -one, one), states[:, -1])
        known = PreloadState(states[0], states[1]).known & (np.abs(states[2]) == 1.0)
        out[b] = np.where(known, states[2], 0.0)
    return out
