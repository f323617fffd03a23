"""Preload and backlash: the state that every joint carries along a path, pose by pose.

Effects declare their memory as a clamp (effects/effect.py). Clamps are closed under composition,

    (c2, l2, h2) after (c1, l1, h1) = (c1 + c2, clip(l1 + c2, l2, h2), clip(h1 + c2, l2, h2)),

so a path is walked in blocks side by side: O(poses), and from chunk to chunk. Two walks, from the
lowest and the highest state possible, bracket every other; where they meet the state is known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import REVERSAL, Clamp, Effect, Numbers

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class PreloadState:
    """State of every joint: n columns per remembering effect. ``low`` and ``high`` bracket the truth.

    Shape (m,) at one pose, (N, m) along a path.
    """

    low: Floats
    high: Floats

    def __repr__(self) -> str:
        return f"PreloadState(shape {self.low.shape}, {'known' if self.known.all() else 'partly unknown'})"

    @property
    def middle(self) -> Floats:
        """Best estimate: the mean of the bracket."""
        return np.asarray(0.5 * (self.low + self.high))

    @property
    def known(self) -> npt.NDArray[np.bool_]:
        """Where the two walks have met."""
        return np.asarray(self.high - self.low <= 1e-12)

    @property
    def last(self) -> PreloadState:
        """The state after the last pose of a path: where the next chunk starts."""
        return PreloadState(self.low[-1], self.high[-1])


def unknown(effects: Sequence[Effect], values: Mapping[str, Numbers]) -> PreloadState:
    """Before anything is known of how the robot came to where it is."""
    half = [e.memory.bounds(values[e.name]) for e in effects if e.memory]
    both = np.concatenate(half) if half else np.empty(0)
    return PreloadState(-both, both)


def walk(
    effects: Sequence[Effect],
    values: Mapping[str, Numbers],
    move: Floats,
    torque: Floats,
    start: PreloadState,
    *,
    corrected: bool = False,
) -> PreloadState:
    """The state at every pose of a path.

    Args:
        move: (N, n) rad commanded from the pose before to this one (row 0: from where ``start`` holds).
            With ``corrected`` the moves are those of the command as it would be with all deflection
            states taken as zero; the state and the correction it asks for are solved together.
        torque: (N, n) N*m of gravity and environment at the pose.
        start: the state before row 0.
    """
    n = move.shape[1]
    low, high = np.empty((len(move), 0)), np.empty((len(move), 0))
    remembering = [e for e in effects if e.memory]
    for k, effect in enumerate(remembering):
        if effect.memory is None:
            continue
        own = values[effect.name]
        clamp = effect.memory.rule(move, torque, own)
        if corrected:
            clamp = _implicit(clamp, effect.memory.gain(own), effect.memory.bounds(own))
        span = slice(k * n, (k + 1) * n)
        a, b = _scan(clamp, start.low[span], start.high[span])
        low, high = np.hstack([low, a]), np.hstack([high, b])
    return PreloadState(low, high)


def _implicit(clamp: Clamp, gain: Floats, half: Floats) -> Clamp:
    """The clamp in terms of the target's move: the correction of the state is itself a move.

    move = target move - (state' - state), hence shift / (1 + gain). A link that lags (gain -1) crosses its
    gap at once; "at once" is a travel of REVERSAL, so that rounding in a target is no reversal.
    """
    at_once = 2 * half / REVERSAL
    factor = 1 / np.maximum(1 + gain, 1 / np.maximum(at_once, 1.0))
    return Clamp(clamp.shift * factor, clamp.low, clamp.high)


def _scan(clamp: Clamp, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Apply the clamps one after the other to two start states, blocks side by side."""
    rows, n = clamp.shift.shape
    length = max(1, int(np.sqrt(rows)))
    blocks = -(-rows // length)
    span = np.finfo(float).max / 8
    shift = np.zeros((blocks * length, n))
    lo, hi = np.full_like(shift, -span), np.full_like(shift, span)
    shift[:rows] = np.clip(clamp.shift, -span, span)
    lo[:rows], hi[:rows] = clamp.low, clamp.high
    shift, lo, hi = (a.reshape(blocks, length, n) for a in (shift, lo, hi))
    # 1. the composed clamp of every block
    c, a, b = np.zeros((blocks, n)), np.full((blocks, n), -span), np.full((blocks, n), span)
    for i in range(length):
        s, x, y = shift[:, i], lo[:, i], hi[:, i]
        c, a, b = np.clip(c + s, -span, span), np.clip(a + s, x, y), np.clip(b + s, x, y)
    # 2. the state before every block, block after block
    first_low, first_high = np.empty((blocks, n)), np.empty((blocks, n))
    for k in range(blocks):
        first_low[k], first_high[k] = low, high
        low, high = np.clip(low + c[k], a[k], b[k]), np.clip(high + c[k], a[k], b[k])
    # 3. every state
    out_low, out_high = np.empty_like(shift), np.empty_like(shift)
    for i in range(length):
        s, x, y = shift[:, i], lo[:, i], hi[:, i]
        first_low, first_high = np.clip(first_low + s, x, y), np.clip(first_high + s, x, y)
        out_low[:, i], out_high[:, i] = first_low, first_high
    return out_low.reshape(-1, n)[:rows], out_high.reshape(-1, n)[:rows]
