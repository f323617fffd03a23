"""Load history: the approach to every set-up and the order of its loads, and the joint memory that they leave."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers
from stiffness.memory.preload import PreloadState, unknown, walk
from stiffness.memory.state_columns import state_columns
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/identification/test_load_history.py
FAR = 1.0  # rad: an approach of unknown size is taken to be longer than any gap
SMALLEST = 1e-8  # typical sizes: a gap of zero still has sides
RELATIVE = 1e-4  # step of a difference


class LoadHistory:
    """The set-ups of a session side by side: a move to each, then its states one after the other."""

    def __init__(self, session: Session) -> None:
        self.samples, self._n = session.samples, session.robot.n
        states = session.states
        setups, self._column = np.unique(states.setup, return_inverse=True)
        order = np.lexsort((states.state, states.setup))
        rank = np.empty(len(order), dtype=np.intp)
        rank[order] = np.arange(len(order))
        begin = np.searchsorted(np.sort(states.setup), setups)
        self._row = rank - begin[self._column]
        self._shape = (int(self._row.max()) + 1, len(setups))
        self._first, self._of = states.first, states.of
        self._begin = np.empty(len(setups), dtype=np.intp)
        self._begin[self._column[self._row == 0]] = states.first[self._row == 0]
        filled = np.zeros(self._shape, dtype=bool)
        filled[self._row, self._column] = True
        # after its last state a set-up stands still
        self._last = np.maximum.accumulate(np.where(filled, np.arange(self._shape[0])[:, None], 0), axis=0)

    def state(
        self, effects: Sequence[Effect], values: Mapping[str, Numbers], torque: Floats, resting: Floats
    ) -> Floats:
        """(N, m) memory of every reading as a share of its half range, -1 ... 1.

        Args:
            torque: (N, n) N*m of every reading.
            resting: (N, n) N*m at its posture without load: what the joints carry on the way there.
        """
        values = {e.name: opened(e, values[e.name]) for e in effects}
        begin = unknown(effects, values)
        if not len(begin.low):
            return np.zeros((len(self.samples), 0))
        tau = np.zeros((*self._shape, self._n))
        tau[self._row, self._column] = torque[self._first]
        tau = np.take_along_axis(tau, np.broadcast_to(self._last[:, :, None], tau.shape), axis=0)
        size = np.abs(self.samples.step[self._begin])
        move = self.samples.approach[self._begin] * np.where(np.isfinite(size), size, FAR)
        moves = np.concatenate([move[None], np.zeros_like(tau)])
        torques = np.concatenate([resting[self._begin][None], tau])
        wide = (self._shape[1], len(begin.low))
        start = PreloadState(np.broadcast_to(begin.low, wide), np.broadcast_to(begin.high, wide))
        walked = walk(effects=effects, values=values, move=moves, torque=torques, start=start).middle[1:]
        share = walked / begin.high
        return np.asarray(share[self._row, self._column][self._of])

    def slopes(
        self,
        effects: Sequence[Effect],
        values: Mapping[str, Numbers],
        torque: Floats,
        resting: Floats,
        state: Floats,
        only: Collection[tuple[str, str]] | None = None,
    ) -> dict[tuple[str, str], Floats]:
        """How shares (N, n * states) change with the numbers of what remembers, by effect and parameter; ``only``
        with these.

        A state at its bound stays there; one between its bounds does not grow with them.
        """
        return memory_slopes(
            lambda other: self.state(effects, other, torque, resting),
            effects=effects,
            values=values,
            state=state,
            joints=self._n,
            only=only,
        )


def memory_slopes(
    walked: Callable[[Mapping[str, Numbers]], Floats],
    *,
    effects: Sequence[Effect],
    values: Mapping[str, Numbers],
    state: Floats,
    joints: int,
    only: Collection[tuple[str, str]] | None,
) -> dict[tuple[str, str], Floats]:
    """How shares ``state`` (N, n * states) change with the numbers of what remembers, by effect and parameter.

    Args:
        walked: values of all effects -> shares.
    """
    if not np.any((np.abs(state) < 1 - 1e-9) & (state != 0)):
        return {}
    out, columns = {}, state_columns(effects, joints)
    for effect in (e for e in effects if e.memory):
        for p in effect.parameters:
            if p.fit == "direct" and (only is None or (effect.name, p.name) in only):
                now = opened(effect, values[effect.name])
                step = -RELATIVE * np.maximum(np.abs(now[p.name]), SMALLEST * p.scale)  # inwards of an upper bound
                more = {**values, effect.name: {**now, p.name: now[p.name] + step}}
                own = columns[effect.name]
                moved = walked(more)[:, own] - state[:, own]
                out[effect.name, p.name] = moved / np.tile(step, moved.shape[1] // joints)
    return out


def opened(effect: Effect, values: Numbers) -> dict[str, Floats]:
    """Values with gaps that are not quite zero: the share of a half range of zero is not defined."""
    smallest = {p.name: SMALLEST * p.scale for p in effect.parameters if effect.memory and p.neutral == 0}
    return {k: np.maximum(v, smallest[k]) if k in smallest else v for k, v in values.items()}
