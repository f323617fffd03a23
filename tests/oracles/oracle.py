"""What an oracle of an effect says: the contract of effects_joints, effects_places and effects_instruments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Numbers = Mapping[str, Floats]


@dataclass(frozen=True)
class Joints:
    """What the joints of an arm are in: (n,) each, ``temperature`` K above the reference."""

    torque: Floats
    stiffness: Floats
    angle: Floats
    state: Floats
    temperature: float


@dataclass(frozen=True)
class Place:
    """What a place is in: ``wrench`` (6,), ``temperature`` K above the reference, ends of its link (3,) m."""

    place: int
    wrench: Floats
    temperature: float
    inner: Floats
    outer: Floats


@dataclass(frozen=True)
class Step:
    """One pose of a joint: commanded ``move`` rad, ``torque`` N*m there and at the pose ``before``.

    stiffness: N*m/rad of the base model. number: which of the joint's states is asked for, from 0.
    """

    move: float
    torque: float
    before: float
    stiffness: float = np.inf
    number: int = 0


@dataclass(frozen=True)
class Oracle:
    """One effect.

    Attributes:
        joint: deflection (n,) that the effect adds.
        place: place, values -> (6,).
        angle: commanded angles (n,) -> (n,) rad, whatever the load.
        torque: angles (n,) -> (n,); mass: joints -> [(link, kg, com)].
        process_wrench: said (6,), turn to the path (3, 3), values -> (6,). surface_reading: deviation, values -> m.
        wrench_reading: shown (6,), turn to the tool (3, 3), values -> (6,).
        position_reading: position (3,), time s, values -> (3,).
        step: state, step of one joint and its values -> the next state; ``states``: how many a joint has.
        nothing: values for which there is no effect; None where there are none.
        without_load: there is an effect without load.
        on_base: shares the load with joint-stiffness: passive together with it, and not alone.
        still: components of the displacement of a place that stay zero.
        sample: random values, where bounds and start values do not lead to sensible ones.
    """

    joint: Callable[[Joints, Numbers], Floats] | None = None
    place: Callable[[Place, Numbers], Floats] | None = None
    angle: Callable[[Floats, Numbers], Floats] | None = None
    torque: Callable[[Floats, Numbers], Floats] | None = None
    mass: Callable[[int, Numbers], list[tuple[int, float, Floats]]] | None = None
    wrench_reading: Callable[[Floats, Floats, Numbers], Floats] | None = None
    process_wrench: Callable[[Floats, Floats, Numbers], Floats] | None = None
    surface_reading: Callable[[float, Numbers], float] | None = None
    position_reading: Callable[[Floats, float, Numbers], Floats] | None = None
    step: Callable[[float, Step, Mapping[str, float]], float] | None = None
    states: int = 1
    nothing: Mapping[str, float] | None = None
    without_load: bool = False
    on_base: bool = False
    still: tuple[int, ...] = ()
    sample: Callable[[np.random.Generator], dict[str, Floats]] | None = None
