"""Memory: what a joint law remembers of the way it came, as clamps, which are closed under composition."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Numbers = Mapping[str, Floats]


@dataclass(frozen=True)
class Clamp:
    """state' = min(max(state + shift, low), high); arrays (..., n * states), low <= high."""

    shift: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class TargetClamp:
    """States along a path whose command is corrected for the deflection that they are.

    Attributes:
        clamp: of coordinates in [-1, 1], arrays (..., n * states), by the moves of the target.
        mix: (n, states, states): the states of a joint over their half ranges are ``mix`` times its coordinates.
    """

    clamp: Clamp
    mix: Floats


@dataclass(frozen=True)
class Memory:
    """What a joint remembers of the way it came: one or several numbers.

    State k (from 0) of joint j stands in column k n + j: all joints of the first state, then all of the second.

    Attributes:
        unit: unit of the states.
        rule: (commanded move (N, n) rad, torque (N, n) N*m, parameters, stiffness (n,) N*m/rad of the base model,
            infinite where there is none) -> Clamp.
        bounds: parameters, numbers or symbols -> half range (n * states,): a state lies in [-half, half].
        meaning: what the state is, for whoever looks at its curve in a report.
        states: how many numbers every joint has.
        deflection: (states (..., n * states), stiffness) -> (..., n) rad, of states that are themselves a deflection.
            A correction then acts back on them: the command moves by the target's move less the change of it.
        by_target: as ``rule``, by the moves of such a target.
    """

    unit: str
    rule: Callable[[Floats, Floats, Numbers, Floats], Clamp]
    bounds: Callable[[Numbers], Floats]
    meaning: str = ""
    states: int = 1
    deflection: Callable[[Floats, Floats], Floats] | None = None
    by_target: Callable[[Floats, Floats, Numbers, Floats], TargetClamp] | None = None
