"""Effect: the contract for one physical cause of deflection.

    X_link_k = X_base twist_0 (A_1 R(q_1 + dq_1) twist_1) ... (A_k R(q_k + dq_k) twist_k)

An effect fills slots of this equation and nothing else. Every slot is a CasADi expression of its
arguments and of the effect's parameters, so that prediction, compensation and identification read
the same text and take derivatives from it.

    slot     given                                             returns
    joint    JointInput: torque, angle, state, temperature      dq (n,) rad
    torque   angle (n,) rad of the links                        tau (n,) N*m of an internal spring
    mass     number of joints                                  point masses on links
    twist    TwistInput: wrench that crosses the place          [d; phi] (6,) m and rad, in its axes

A twist moves what lies outward of the place by d, then turns it by the rotation vector phi. Its wrench is the
generalised force of these six coordinates, so that a symmetric compliance has a potential.

A joint law with memory declares it as a clamp,

    state' = min(max(state + shift, low), high),

per joint, with shift, low and high functions of the last commanded move and of the torque: clamps are
closed under composition, which is what lets a path of a million poses be walked without a Python loop.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import casadi as ca
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Values = Mapping[str, ca.SX]  # parameter name -> column vector
Numbers = Mapping[str, Floats]
REVERSAL = 1e-6  # rad of travel that counts as a change of direction: 2 um at 2 m
Scope = Literal["robot", "tool", "instruments"]


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect, as it stands in the model file.

    Attributes:
        name: key in the model file; its unit is the suffix.
        unit: unit in words.
        size: ``"joint"`` for one number per joint, else the count of numbers.
        start: value to begin an identification with.
        low, high: bounds, both included; a value outside is refused.
        scale: a typical size, to condition solvers with.
        meaning: one line for docs and reports.
        default: value where the model file has no such key; None when it must be there.
        fit: how identification treats it: ``direct``; ``inverse``, because readings are about linear in its
            inverse; ``given``, because no derivative leads to it.
    """

    name: str
    unit: str
    size: Literal["joint"] | int
    start: float
    low: float
    high: float
    scale: float
    meaning: str
    default: float | None = None
    fit: Literal["direct", "inverse", "given"] = "direct"

    def count(self, joints: int) -> int:
        """How many numbers the parameter has on a robot with so many joints."""
        return joints if self.size == "joint" else self.size


@dataclass(frozen=True)
class JointInput:
    """What a joint law is given: columns (n,), one row per joint."""

    torque: ca.SX  # generalised force of gravity and environment, N*m
    elastic: ca.SX  # deflection of the base model (joint-stiffness) under it, rad
    angle: ca.SX  # commanded, rad
    state: ca.SX  # the effect's own memory, zeros when it has none
    temperature: ca.SX  # (1,) K above the model's reference temperature


@dataclass(frozen=True)
class TwistInput:
    """What a place that yields is given."""

    place: int  # 0 base ... n flange
    wrench: ca.SX  # (6,) N and N*m, in the axes of the place, about its displaced origin
    temperature: ca.SX  # (1,) K above the model's reference temperature


@dataclass(frozen=True)
class PointMass:
    """A mass that the robot model does not contain."""

    link: int  # 0 base ... n flange
    mass: ca.SX  # kg
    com: ca.SX  # (3,) m in the frame of the link


@dataclass(frozen=True)
class Clamp:
    """state' = min(max(state + shift, low), high); arrays (..., n), low <= high."""

    shift: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class Memory:
    """What a joint remembers of the way it came.

    Attributes:
        unit: unit of the state.
        rule: (commanded move (N, n) rad, torque (N, n) N*m, parameters) -> Clamp.
        bounds: parameters, numbers or symbols -> half range (n,): the state lies in [-half, half].
        gain: parameters -> (n,): change of deflection per commanded move while the state moves
            freely. Not zero for a state that is itself a deflection: a correction then acts back
            on it, and the walk along a corrected path has to solve for both.
    """

    unit: str
    rule: Callable[[Floats, Floats, Numbers], Clamp]
    bounds: Callable[[Numbers], Floats]
    gain: Callable[[Numbers], Floats]


def _nothing_wrong(values: Numbers) -> str:
    return ""


@dataclass(frozen=True)
class Effect:
    """A physical cause of deflection: parameters, and the slots of the equation that it fills.

    Attributes:
        name: as files and reports write it.
        cause: one sentence for the report.
        scope: ``robot`` goes where the robot goes, ``tool`` with the tool it was measured with,
            ``instruments`` concerns readings only and never a path.
        parameters: in the order of the model file.
        joint, torque, mass, twist: the slots, None where not filled.
        places: joints -> the places that ``twist`` acts at (0 base ... n flange).
        memory: the state of a joint law that has one.
        needs_torque_sign: the law is not linear in torque, so gravity matters to it even where the
            controller takes the sag off.
        check: what is wrong with values that lie within their bounds one by one; "" when nothing is.
    """

    name: str
    cause: str
    scope: Scope
    parameters: tuple[Parameter, ...]
    joint: Callable[[JointInput, Values], ca.SX] | None = None
    torque: Callable[[ca.SX, Values], ca.SX] | None = None
    mass: Callable[[int, Values], tuple[PointMass, ...]] | None = None
    twist: Callable[[TwistInput, Values], ca.SX] | None = None
    places: Callable[[int], tuple[int, ...]] = lambda n: ()
    memory: Memory | None = None
    needs_torque_sign: bool = False
    check: Callable[[Numbers], str] = _nothing_wrong

    def __repr__(self) -> str:
        return f"Effect({self.name})"
