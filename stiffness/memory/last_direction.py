"""The direction of the last real travel of every joint: a command that only rounds does not reverse a joint."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import REVERSAL
from stiffness.effects.memory import Clamp
from stiffness.memory.clamp_scan import scan
from stiffness.memory.preload import PreloadState

Floats = npt.NDArray[np.float64]


def last_direction(move: Floats) -> Floats:
    """(N, n): the sign of the last travel of more than REVERSAL, up to every pose; 0 before the first.

    Args:
        move: (N, n) rad, from the pose before to this one.
    """
    if not len(move):
        return np.zeros_like(move)
    one = np.ones_like(move)
    starts = np.outer([-1.0, 1.0, 0.0], np.ones(move.shape[1]))
    low, high, likely = scan(Clamp(move / (0.5 * REVERSAL), -one, one), starts)
    known = PreloadState(low, high).known & (np.abs(likely) == 1.0)
    return np.where(known, likely, 0.0)
