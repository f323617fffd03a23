"""Unknowns: the numbers of a model as one vector, the way a least-squares solver likes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers, Parameter, Site

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """One number: ``index`` of ``parameter`` of ``effect``; ``solver`` is 1/value where ``inverse``."""

    effect: str
    parameter: Parameter
    index: int

    @property
    def inverse(self) -> bool:
        """Whether the solver sees the inverse."""
        return self.parameter.fit == "inverse"

    @property
    def scale(self) -> float:
        """A typical size of what the solver sees."""
        return 1 / self.parameter.scale if self.inverse else self.parameter.scale

    def __str__(self) -> str:
        return f"{self.effect}.{self.parameter.name}[{self.index + 1}]"


@dataclass(frozen=True, repr=False)
class Unknowns:
    """Which numbers of ``effects`` are free on a robot of ``joints`` joints, in the order of a vector."""

    effects: tuple[Effect, ...]
    joints: int
    free: tuple[Unknown, ...]

    def __len__(self) -> int:
        return len(self.free)

    def __repr__(self) -> str:
        return f"Unknowns({len(self)} of {', '.join(e.name for e in self.effects)})"

    def start(self, values: Mapping[str, Numbers]) -> Floats:
        """The vector of given values."""
        raw = np.array([values[u.effect][u.parameter.name][u.index] for u in self.free])
        return np.where(self.inverse, 1 / np.where(self.inverse, raw, 1.0), raw)

    @property
    def inverse(self) -> npt.NDArray[np.bool_]:
        """(P,) which the solver sees inverted."""
        return np.array([u.inverse for u in self.free], dtype=bool)

    @property
    def springs(self) -> npt.NDArray[np.bool_]:
        """(P,) which belong to a joint and are seen inverted: its stiffness, and shares of that."""
        return np.array([u.inverse and u.parameter.size == "joint" for u in self.free], dtype=bool)

    @property
    def scale(self) -> Floats:
        """(P,) typical sizes."""
        return np.array([u.scale for u in self.free])

    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds (P,) of the vector."""
        low = np.array([1 / u.parameter.high if u.inverse else u.parameter.low for u in self.free])
        high = np.array([1 / u.parameter.low if u.inverse else u.parameter.high for u in self.free])
        return low, high

    def values(self, vector: Any, fixed: Mapping[str, Numbers]) -> dict[str, dict[str, Any]]:
        """Values per effect and parameter: symbols for a vector of SX, else numbers; ``fixed`` where not free."""
        symbolic = isinstance(vector, ca.SX)
        out: dict[str, dict[str, Any]] = {}
        for effect in self.effects:
            numbers = fixed[effect.name]
            out[effect.name] = {
                p.name: ca.SX(ca.DM(numbers[p.name])) if symbolic else np.array(numbers[p.name], dtype=float)
                for p in effect.parameters
            }
        for k, u in enumerate(self.free):
            out[u.effect][u.parameter.name][u.index] = 1 / vector[k] if u.inverse else vector[k]
        return out


def unknowns(
    effects: Sequence[Effect],
    joints: int,
    fixed: Sequence[str] = (),
    extras: Callable[[Effect, Site], bool] = lambda effect, site: False,
) -> Unknowns:
    """Every number of ``effects`` that a derivative leads to, but for the effects named in ``fixed``.

    Args:
        extras: where with those parameters that are freed only where the data ask for it.
    """
    free = [
        u
        for e in effects
        if e.name not in fixed
        for site in e.sites(joints)
        for u in numbers_of(e, site, joints, extras(e, site))
    ]
    free.sort(key=lambda u: [p.name for p in _by_name(effects)[u.effect].parameters].index(u.parameter.name))
    order = {e.name: k for k, e in enumerate(effects)}
    free.sort(key=lambda u: order[u.effect])
    return Unknowns(tuple(effects), joints, tuple(free))


def every_number(effects: Sequence[Effect], joints: int) -> Unknowns:
    """Every number that a derivative leads to, but for tables: their laws are worked out beside the statics."""
    free = [
        Unknown(e.name, p, k)
        for e in effects
        for p in e.parameters
        if p.fit != "given" and not e.angle
        for k in range(p.count(joints))
    ]
    return Unknowns(tuple(effects), joints, tuple(free))


def _by_name(effects: Sequence[Effect]) -> dict[str, Effect]:
    return {e.name: e for e in effects}


def can_be_richer(effect: Effect, setups: int) -> bool:
    """Whether readings of so many set-ups can ask for the extras of an effect: a table needs as many as its knots."""
    each = [p.each for p in effect.parameters if p.extra]
    return bool(each) and max(each) <= setups


def numbers_of(effect: Effect, site: Site, joints: int, extras: bool = False) -> list[Unknown]:
    """The numbers of an effect at one of its sites that a derivative leads to; a table stands in the place of the
    others."""
    out: list[Unknown] = []
    for p in effect.parameters:
        if p.fit == "given" or (p.extra and not extras) or p.site != site.kind:
            continue
        if effect.as_table and extras and not p.extra:
            continue
        out += [Unknown(effect.name, p, k) for k in range(p.count(joints))[p.of_site(site.index)]]
    return out


def start_values(effects: Sequence[Effect], joints: int) -> dict[str, dict[str, Floats]]:
    """Where an identification begins: the parameters' start values, or defaults where they are given."""
    return {
        e.name: {
            p.name: np.full(p.count(joints), p.start if p.default is None or p.fit != "given" else p.default)
            for p in e.parameters
        }
        for e in effects
    }
