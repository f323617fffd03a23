"""An ailment: one physical cause that wears a cell, its places in words, and a factor that says how badly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .arm import Arm
from .geometry import Array
from .wear import Wear

# (the cell so far, the arm of the file, factor) -> (the worn cell, "what place unit" -> value of what was done)
Apply = Callable[[Wear, Arm, float], tuple[Wear, Mapping[str, float]]]
TYPICAL = 1e-3  # rad: a joint torque of stiffness x this is what gravity and loads bring about


@dataclass(frozen=True)
class Ailment:
    """effect: the catalogue's name, or "unknown".

    where: joint-k, link-k, base, tool, tracker, force-sensor, column:NAME, time.
    """

    effect: str
    where: tuple[str, ...]
    law: str  # one line
    apply: Apply
    start: float = 1.0  # factor of a first guess

    @property
    def known(self) -> bool:
        """Whether the catalogue of effects has it."""
        return self.effect != "unknown"


@dataclass(frozen=True)
class Truth:
    """What is wrong with a cell: told to the judge, never to the one who is judged."""

    effect: str
    where: tuple[str, ...]
    law: str
    factor: float
    values: Mapping[str, float]
    change: float  # m, RMS per axis, of what it does to the readings of session D
    left: float  # m, the same after the best six joint stiffnesses have been taken out of it (linear least squares)


def several(law: str, ailments: Sequence[tuple[Ailment, float]]) -> Ailment:
    """One effect in many places, as real robots have it: each ailment with its own share of the factor."""

    def apply(wear: Wear, arm: Arm, s: float) -> tuple[Wear, Mapping[str, float]]:
        values: dict[str, float] = {}
        for ailment, share in ailments:
            wear, more = ailment.apply(wear, arm, share * s)
            values |= more
        return wear, values

    (effect,) = {a.effect for a, _ in ailments}
    where = tuple(dict.fromkeys(w for a, _ in ailments for w in a.where))
    return Ailment(effect, where, law, apply, 0.3)


def only(n: int, k: int, value: float) -> Array:
    """(n,) zero but for joint k (counted from 1)."""
    out = np.zeros(n)
    out[k - 1] = value
    return out


def torque_scale(wear: Wear, k: int) -> float:
    """N*m: a typical torque of joint k (counted from 1)."""
    return float(wear.stiffness[k - 1]) * TYPICAL
