"""Instruments that lie: a tracker that wanders, a force sensor that is bent."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .geometry import Array, turn


def _none() -> Array:
    return np.zeros(3)


@dataclass(frozen=True)
class Wandering:
    """The measuring frame creeps and turns about the tracker's stand; what it shows moves the other way round.

    Shown = about + turn(rate t) (true - about) + speed t. With `settling` s, t becomes settling (1 - exp(-t/settling)).
    """

    speed: Array = field(default_factory=_none)  # (3,) m/s
    rate: Array = field(default_factory=_none)  # (3,) rad/s
    about: Array = field(default_factory=_none)  # (3,) m, the stand in the base frame
    settling: float = np.inf

    def shown(self, position: Array, time: float) -> Array:
        """(3,) m that the tracker shows for a true position at a time (s)."""
        t = time if np.isinf(self.settling) else self.settling * -np.expm1(-time / self.settling)
        out: Array = self.about + turn(self.rate * t) @ (position - self.about) + self.speed * t
        return out


@dataclass(frozen=True)
class Crooked:
    """Shown wrench = scale x turned wrench + zero, all in the sensor's axes: those of the tool, at the TCP."""

    zero: Array = field(default_factory=lambda: np.zeros(6))  # (6,) N, N*m
    scale: Array = field(default_factory=lambda: np.zeros(6))  # (6,) relative, 0 is right
    tilt: Array = field(default_factory=_none)  # (3,) rad

    def shown(self, wrench: Array) -> Array:
        """(6,) that it shows for a true wrench (6,) in tool axes about the TCP."""
        R = turn(self.tilt)
        turned = np.concatenate([R @ wrench[:3], R @ wrench[3:]])
        out: Array = (1 + self.scale) * turned + self.zero
        return out
