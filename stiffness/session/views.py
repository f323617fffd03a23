"""Views of the readings: load states, and the pairs of readings that make a displacement."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from stiffness.session.samples import Samples

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@dataclass(frozen=True, repr=False, eq=False)
class LoadStates:
    """The S load states of a session, in the order of their first reading. A state is a (set-up, state):
    its reflectors, repeats and blocks are readings of the same arm at rest.

    Attributes:
        setup, state: (S,).
        first: (S,) index of the first reading.
        of: (N,) state of every reading.
        before: (S,) the state that the set-up was in before, in the order of the numbers; -1 for the first.
    """

    setup: Ints
    state: Ints
    first: Ints
    of: Ints
    before: Ints

    def __post_init__(self) -> None:
        for f in fields(self):
            getattr(self, f.name).setflags(write=False)

    def __len__(self) -> int:
        return len(self.first)

    def __repr__(self) -> str:
        return f"LoadStates({len(self)} states of {len(np.unique(self.setup))} set-ups)"


@dataclass(frozen=True, repr=False, eq=False)
class Pairs:
    """Displacements: every reading of a loaded state with one reading of state 0.

    Both are of the same set-up, reflector and block. Repeats are matched, not averaged, so that a wrong row
    is one wrong pair: repeat r goes with repeat r of state 0; where state 0 has no such repeat, its repeats
    take turns. Pairs that share a reference share its noise.

    Attributes:
        row, reference: (P,) indices of the two readings.
        displacement: (P, 3) m, position minus reference, in the axes of the positions.
        sd: (P, 3) m.
        alone: indices of loaded readings without a reference (a beam was broken): absolute positions only.
    """

    row: Ints
    reference: Ints
    displacement: Floats
    sd: Floats
    alone: Ints

    def __post_init__(self) -> None:
        for f in fields(self):
            getattr(self, f.name).setflags(write=False)

    def __len__(self) -> int:
        return len(self.row)

    def __repr__(self) -> str:
        return f"Pairs({len(self)} displacements, {len(self.alone)} readings without a reference)"


def load_states(s: Samples) -> LoadStates:
    """The load states of readings."""
    keys = np.column_stack([s.setup, s.state])
    unique, first, of = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    before = np.arange(-1, len(unique) - 1)  # unique is sorted by set-up, then state
    before[np.diff(unique[:, 0], prepend=unique[0, 0] - 1) != 0] = -1
    order = np.argsort(first)
    rank = np.argsort(order)
    return LoadStates(
        setup=unique[order, 0],
        state=unique[order, 1],
        first=first[order],
        of=rank[of.reshape(-1)],
        before=np.where(before >= 0, rank[before], -1)[order],
    )


def pairs_of(s: Samples) -> Pairs:
    """The displacements that readings make."""
    keys = list(zip(s.setup.tolist(), s.reflector.tolist(), s.block.tolist(), strict=True))
    state, repeat = s.state.tolist(), s.repeat.tolist()
    references: dict[tuple[int, int, int], dict[int, int]] = {}
    for k in np.flatnonzero(s.state == 0).tolist():
        references.setdefault(keys[k], {})[repeat[k]] = k
    found: list[tuple[int, int]] = []
    alone: list[int] = []
    turn: dict[tuple[tuple[int, int, int], int], int] = {}
    for k in np.flatnonzero(s.state).tolist():
        there = references.get(keys[k])
        if there is None:
            alone.append(k)
            continue
        count = turn[keys[k], state[k]] = turn.get((keys[k], state[k]), -1) + 1
        found.append((k, there.get(repeat[k], list(there.values())[count % len(there)])))
    indices = np.array(found, dtype=np.int64).reshape(-1, 2)
    row, reference = indices[:, 0].copy(), indices[:, 1].copy()
    return Pairs(
        row=row,
        reference=reference,
        displacement=s.position[row] - s.position[reference],
        sd=np.hypot(s.sd[row], s.sd[reference]),
        alone=np.array(alone, dtype=np.int64),
    )
