"""State columns: where the states of every effect with memory stand in the state of a whole arm."""

from __future__ import annotations

from collections.abc import Sequence

from stiffness.effects.effect import Effect


def state_columns(effects: Sequence[Effect], joints: int) -> dict[str, slice]:
    """Name of the effect -> its columns (joints * states), in the order of the effects."""
    out, at = {}, 0
    for e in effects:
        if e.memory:
            out[e.name] = slice(at, at + joints * e.memory.states)
            at += joints * e.memory.states
    return out
