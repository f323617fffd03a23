"""Preload and backlash: the state that every joint carries along a path, pose by pose.

Effects declare their memory as a clamp (effects/effect.py). Clamps are closed under composition,

    (c2, l2, h2) after (c1, l1, h1) = (c1 + c2, clip(l1 + c2, l2, h2), clip(h1 + c2, l2, h2)),

so a path is walked in blocks side by side: O(poses), and from chunk to chunk. Two walks, from the
lowest and the highest state possible, bracket every other; where they meet the state is known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers
from stiffness.effects.memory import Memory, TargetClamp
from stiffness.memory.clamp_scan import scan
from stiffness.memory.state_columns import state_columns

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, repr=False)
class PreloadState:
    """State of every joint, in the columns of ``state_columns``. ``low`` and ``high`` bracket the truth.

    Shape (m,) at one pose, (N, m) along a path. ``likely`` begins in the middle of an unknown start: like ``low`` and
    ``high``, and unlike their mean, it is a history that a joint can have.
    """

    lowest: Floats
    highest: Floats
    likely: Floats | None = None

    def __repr__(self) -> str:
        return f"PreloadState(shape {self.middle.shape}, {'known' if self.known.all() else 'partly unknown'})"

    @staticmethod
    def chained(parts: Sequence[PreloadState]) -> PathState:
        """Of a path, from those of its pieces."""
        kept = [p.kept() for p in parts]
        first = np.cumsum([0, *(p.count for p in kept)])
        return PathState(
            np.concatenate([p.lowest for p in kept]), np.concatenate([p.highest for p in kept]),
            np.concatenate([p.values for p in kept]), bounded=np.concatenate([p.bounded for p in kept]),
            begin=np.concatenate([f + p.begin for f, p in zip(first, kept, strict=False)]),
            rows=np.concatenate([f + p.rows for f, p in zip(first, kept, strict=False)]), count=int(first[-1]),
        )  # fmt: skip

    def kept(self) -> PathState:
        """The same of a path, in less room."""
        middle, low, high = self.middle, self.low, self.high
        begin = np.concatenate([np.arange(min(len(middle), 1)), self.changed])
        if low is high is middle:  # one walk
            none, rows = np.zeros((len(begin[:1]), middle.shape[1])), begin[:1]
            bounded = np.zeros(none.shape, dtype=np.bool_)
            return PathState(
                none, none, middle[begin], bounded=bounded, begin=begin, rows=rows, count=len(middle)
            )
        bounded = _other(low, middle) | _other(high, middle)
        low, high = np.where(bounded, low, 0.0), np.where(bounded, high, 0.0)
        new = _other(low[1:], low[:-1]) | _other(high[1:], high[:-1]) | (bounded[1:] != bounded[:-1])
        rows = np.concatenate([begin[:1], np.flatnonzero(new.any(axis=1)) + 1])
        return PathState(
            low[rows], high[rows], middle[begin], bounded=bounded[rows], begin=begin, rows=rows, count=len(middle)
        )

    @property
    def low(self) -> Floats:
        """(..., m) the lowest that it can be."""
        return self.lowest

    @property
    def high(self) -> Floats:
        """(..., m) the highest that it can be."""
        return self.highest

    @property
    def middle(self) -> Floats:
        """Best estimate."""
        return np.asarray(0.5 * (self.low + self.high)) if self.likely is None else self.likely

    @property
    def known(self) -> Bools:
        """Where the two walks have met."""
        return np.asarray(self.high - self.low <= 1e-12)

    @property
    def is_open(self) -> Bools:
        """(N,) poses where lowest, highest and likely state are not one and the same."""
        if self.lowest is self.highest is self.likely:
            return np.zeros(len(self.lowest), dtype=np.bool_)
        low, high, middle = self.low, self.high, self.middle
        return np.asarray(((low != middle) | (high != middle)).any(axis=-1))

    @property
    def unknown_rows(self) -> Rows:
        """(K,) poses of a path with a state that is not ``known``."""
        return np.flatnonzero(~self.known.all(axis=1))

    @property
    def changed(self) -> Rows:
        """(K,) poses of a path with another state than the pose before."""
        middle = self.middle
        return np.flatnonzero((middle[1:] != middle[:-1]).any(axis=1)) + 1

    def take(self, rows: Rows) -> PreloadState:
        """The state at some poses of a path."""
        return PreloadState(self.low[rows], self.high[rows], None if self.likely is None else self.likely[rows])

    @property
    def last(self) -> PreloadState:
        """The state after the last pose of a path: where the next chunk starts."""
        end = self.take(np.array([-1]))
        return PreloadState(end.low[0], end.high[0], None if end.likely is None else end.likely[0])


@dataclass(frozen=True, repr=False)
class PathState(PreloadState):
    """The state along a path of N poses, kept where it changes; bounds on their own, as a joint that never moves stays
    unknown while others change at every pose.

    Attributes:
        likely: (C, m) that holds from ``begin`` (C,), the poses that change it and the first, up to the next.
        lowest, highest: (K, m) that hold from ``rows`` (K,) on where ``bounded`` (K, m); elsewhere they are the likely.
        count: N.
    """

    bounded: Bools = field(kw_only=True)
    begin: Rows = field(kw_only=True)
    rows: Rows = field(kw_only=True)
    count: int = field(kw_only=True)

    @property
    def values(self) -> Floats:
        """(C, m), ``likely``."""
        return np.empty((0, self.lowest.shape[-1])) if self.likely is None else self.likely

    @property
    def low(self) -> Floats:
        return self.take(np.arange(self.count)).low

    @property
    def high(self) -> Floats:
        return self.take(np.arange(self.count)).high

    @property
    def middle(self) -> Floats:
        return self._at(np.arange(self.count))

    @property
    def is_open(self) -> Bools:
        return self._along(self.bounded)

    @property
    def unknown_rows(self) -> Rows:
        return np.flatnonzero(self._along(self.bounded & ~(self.highest - self.lowest <= 1e-12)))

    @property
    def changed(self) -> Rows:
        middle = self._at(self.begin)  # a piece may begin as the one before ended
        return np.asarray(self.begin[1:][(middle[1:] != middle[:-1]).any(axis=1)])

    def kept(self) -> PathState:
        return self

    def take(self, rows: Rows) -> PreloadState:
        rows = np.where(rows < 0, rows + self.count, rows)
        middle, at = self._at(rows), np.searchsorted(self.rows, rows, side="right") - 1
        bounded = self.bounded[at]
        if not bounded.any():
            return PreloadState(middle, middle, middle)
        low, high = (np.where(bounded, bounds[at], middle) for bounds in (self.lowest, self.highest))
        return PreloadState(low, high, middle)

    def _at(self, rows: Rows) -> Floats:
        return np.asarray(self.values[np.searchsorted(self.begin, rows, side="right") - 1])

    def _along(self, states: Bools) -> Bools:
        """(N,) poses with one of these ``states`` (K, m), which hold from ``rows`` on."""
        return np.repeat(np.asarray(states.any(axis=1)), np.diff(self.rows, append=self.count))


def _other(one: Floats, two: Floats) -> Bools:
    """Where the numbers are not the same, bit by bit: 0 is not -0."""
    return np.asarray(one.view(np.int64) != two.view(np.int64))


def unknown(effects: Sequence[Effect], values: Mapping[str, Numbers]) -> PreloadState:
    """The state of a robot whose earlier moves are not known: between the bounds of every joint."""
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
        move: (N, n) rad commanded from the pose before to this one (row 0: from where ``start`` holds), or
            (N, M, n) for M paths of one length side by side.
            With ``corrected`` the moves are those of the command as it would be with all deflection
            states taken as zero; the state and the correction it asks for are solved together.
        torque: N*m of gravity and environment at the pose, shaped as ``move``.
        start: the state before row 0, (m,) or (M, m).
    """
    columns = state_columns(effects, move.shape[-1])
    begin = np.stack([start.low, start.high, start.middle])
    if np.all(begin == begin[0]):  # one walk serves for all
        begin = begin[:1]
    walked = np.empty((len(begin), *move.shape[:-1], begin.shape[-1]))
    for name, memory in _deflections_first(effects) if len(move) else ():
        own, span = values[name], columns[name]
        stiffness = base_stiffness(effects, values, move.shape[-1])
        starts, shape = begin[..., span], walked[0, ..., span].shape
        if corrected and memory.by_target:
            target = memory.by_target(move, torque, own, stiffness)
            states = _by_target(target, starts, memory.bounds(own), shape)
        else:
            clamp = memory.rule(move, torque, own, stiffness)
            states = scan(clamp, starts.reshape(len(starts), -1)).reshape(len(starts), *shape)
        walked[..., span] = states
        if corrected and memory.deflection:  # what the command really moves, for the states that only look on
            before, likely = start.middle[None, ..., span], states[-1]
            change = np.diff(memory.deflection(np.concatenate([before, likely]), stiffness), axis=0)
            if start.likely is None:  # no command corrected for a state that was not known
                known = start.known[..., span].reshape(*start.low.shape[:-1], memory.states, -1)
                change[0] *= known.all(axis=-2)
            move = move - change
    low, high, likely = walked if len(walked) == 3 else (walked[0],) * 3
    return PreloadState(low, high, likely)


def base_stiffness(effects: Sequence[Effect], values: Mapping[str, Numbers], joints: int) -> Floats:
    """(n,) N*m/rad of the base model; infinite without one."""
    for e in effects:
        if e.stiffness:
            return e.stiffness(values[e.name])
    return np.full(joints, np.inf)


def _deflections_first(effects: Sequence[Effect]) -> list[tuple[str, Memory]]:
    """(name, memory): first the states that are themselves a deflection."""
    found = [(e.name, e.memory) for e in effects if e.memory]
    return sorted(found, key=lambda entry: entry[1].deflection is None)


def _by_target(target: TargetClamp, starts: Floats, half: Floats, shape: tuple[int, ...]) -> Floats:
    """(S, ...) states of S walks by the moves of a target, from starts (S, ..., n * states)."""
    size = np.maximum(half, 1e-300)
    first = _mixed(np.asarray(np.linalg.inv(target.mix)), starts / size)
    coordinates = scan(target.clamp, np.clip(first, -1, 1).reshape(len(starts), -1)).reshape(len(starts), *shape)
    return _mixed(target.mix, coordinates) * half


def _mixed(mix: Floats, shares: Floats) -> Floats:
    """Products of ``mix`` (n, states, states) with the states of every joint, (..., n * states)."""
    if mix.shape[1] == 1:
        return shares * mix[:, 0, 0]
    n, states = mix.shape[:2]
    each = shares.reshape(*shares.shape[:-1], states, n)
    return np.asarray(np.einsum("nks,...sn->...kn", mix, each).reshape(shares.shape))
