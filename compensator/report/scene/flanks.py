"""Flanks: on which side of its gap every joint rests, and which joint reversed last, pose by pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from compensator.solve.turnarounds import Turnaround
from stiffness.memory.preload import PreloadState
from stiffness.memory.state_columns import state_columns

Floats = npt.NDArray[np.float64]
Bytes = npt.NDArray[np.int8]

UNKNOWN, WITHOUT = 127, -128  # of the lamp of a joint
FULL = 100


def lamps(arm: EquippedArm, state: PreloadState) -> Bytes:
    """(N, n): -100 to 100 from one flank to the other, UNKNOWN, or WITHOUT for a joint that remembers nothing.

    Of several effects of a joint the one that is worth most.
    """
    n = arm.robot.n
    out, worth = np.full((len(state.low), n), WITHOUT, dtype=np.int8), np.zeros(n)
    columns = state_columns(arm.effects, n)
    for effect in arm.effects:
        if effect.memory is None:
            continue
        half = effect.memory.bounds(arm.values[effect.name]).reshape(-1, n).sum(axis=0)
        own = columns[effect.name]
        low, high, middle = (
            s[:, own].reshape(len(s), -1, n).sum(axis=1) for s in (state.low, state.high, state.middle)
        )
        for j in np.flatnonzero(half > worth).tolist():
            share = np.clip(np.round(FULL * middle[:, j] / half[j]), -FULL, FULL)
            out[:, j] = np.where(high[:, j] - low[:, j] <= 1e-12, share, UNKNOWN)
            worth[j] = half[j]
    return out


def last_reversed(count: int, found: Sequence[Turnaround]) -> Floats:
    """(count,) number of the joint that turned around last up to each pose, 0 before any did."""
    joint = np.array([0, *(t.joint for t in found)], dtype=float)
    return joint[np.searchsorted([t.pose for t in found], np.arange(count), side="right")]
