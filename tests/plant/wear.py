"""Everything that can be wrong with a cell, as the plant takes it: one frozen record, neutral by default."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .geometry import Array
from .instruments import Crooked, Wandering
from .joints import Bearings, Friction
from .moment import Moment


@dataclass(frozen=True)
class Situation:
    """What an extra joint law may look at."""

    torque: Array  # (n,) N*m, of gravity, environment and every spring inside the arm
    command: Array  # (n,) rad
    angle: Array  # (n,) rad, where the links are
    direction: Array  # (n,) last commanded rotation
    moment: Moment


Law = Callable[[Situation], Array]  # added joint deflection (n,), rad


@dataclass(frozen=True)
class Flexure:
    """Three slides and three hinges somewhere in a link: link 0 is what the robot stands on, link n the flange.

    They sit at `place` (4,4), given in the base frame (link 0) or in the frame right after the turn of joint k.
    """

    link: int
    place: Array  # (4,4)
    compliance: Array  # (6,6) m and rad per N and N*m, in the axes of `place`


@dataclass(frozen=True)
class Tie:
    """A spring that stretches with the sum of coef x deflection of some joints (a MuJoCo fixed tendon)."""

    coef: Array  # (n,)
    stiffness: float  # N*m/rad


@dataclass(frozen=True)
class Strut:
    """A spring between a point of link 1 and a point of link 2 (a MuJoCo spatial tendon)."""

    inner: Array  # (3,) m, in the frame of link 1
    outer: Array  # (3,) m, in the frame of link 2
    stiffness: float  # N/m
    length: float  # m, without force


@dataclass(frozen=True)
class Lump:
    """A mass on a link that nobody declared."""

    link: int
    mass: float  # kg
    com: Array  # (3,) m, in the frame of the link


@dataclass(frozen=True)
class Wear:
    """The true cell. `zeros`, `moved`: the true arm is not the arm that the controller inverts."""

    stiffness: Array  # (n,) N*m/rad
    ratio: Array  # (n,) softer flank over the stiff one
    gap: Array  # (n,) rad
    breakaway: Array  # (n,) N*m
    friction: Friction | Bearings | None = None
    laws: tuple[Law, ...] = ()
    flexures: tuple[Flexure, ...] = ()
    ties: tuple[Tie, ...] = ()
    strut: Strut | None = None
    lumps: tuple[Lump, ...] = ()
    zeros: Array = field(default_factory=lambda: np.zeros(6))  # (n,) rad, added to the shown angle
    moved: tuple[tuple[int, Array], ...] = ()  # (link k, (4,4) where frame k really is, seen from frame k of the file)
    growth: Array = field(default_factory=lambda: np.zeros(7))  # (n+1,) 1/K, of the lengths of link k
    tracker: Wandering | None = None
    sensor: Crooked | None = None

    @classmethod
    def healthy(cls, stiffness: Array) -> Wear:
        """Joint springs and nothing else."""
        n = len(stiffness)
        free = np.zeros(n)
        return cls(np.array(stiffness, dtype=float), np.ones(n), free, free, zeros=free, growth=np.zeros(n + 1))
