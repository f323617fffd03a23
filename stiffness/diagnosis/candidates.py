"""Candidates: the terms that a search may add: every effect of the catalogue at each of its sites.

Numbers that scale an effect have derivatives at their neutral value. The others only shape it, and a derivative at one
of their values tells nothing about the rest: they are tried. Values that blend (an angle, a place along a link) are
columns side by side; values that exclude each other (a flank's side, a knee) make terms of their own.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Parameter, Site
from stiffness.identification.unknowns import Unknown, can_be_richer, numbers_of

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trial:
    """One assignment of the shapes of an effect.

    Attributes:
        choice: which of the alternatives it belongs to.
        values: parameter -> (count,) for a number per joint, as in the model file.
    """

    choice: int
    values: Mapping[str, Floats]


@dataclass(frozen=True)
class Column:
    """One column of the Jacobian: the derivative by ``number`` with the shapes of ``trial``, from run ``run``."""

    run: int
    number: Unknown
    trial: Trial


@dataclass(frozen=True)
class Term:
    """What may be added in one step: an effect at a site with one choice of its alternatives.

    Attributes:
        extras: with the numbers that are freed only where the data ask for it.
        columns: indices into the list of all columns.
        positive: (K,) whether a column cannot be negative.
    """

    effect: Effect
    site: Site
    choice: int
    extras: bool
    columns: tuple[int, ...]
    positive: tuple[bool, ...]

    def __str__(self) -> str:
        return f"{self.effect.name} in {' and '.join(self.site.where)}"

    @property
    def tabled(self) -> bool:
        """Whether its numbers are a table."""
        return any(p.each > 1 and p.extra <= self.extras for p in self.effect.parameters)

    @property
    def key(self) -> tuple[str, tuple[str, ...]]:
        """Effect and site."""
        return self.effect.name, self.site.where


def blends(p: Parameter) -> bool:
    """Whether trials of a shape stand side by side, rather than exclude each other."""
    return bool(p.trials) and p.neutral is None and p.fit != "given" and not p.trials_of and not p.extra


def excludes(p: Parameter) -> bool:
    """Whether trials of a shape are alternatives."""
    return bool(p.trials) and not blends(p)


def trials(effect: Effect, joints: int, torque: Floats) -> list[Trial]:
    """All assignments; ``torque`` (n,) N*m, the largest of every joint."""
    start = effect.neutral(joints)  # an effect on trial must not bend the torque that others see
    alternatives = [[(p, t) for t in _with_start(p)] for p in effect.parameters if excludes(p)]
    side_by_side = [s for p in effect.parameters if blends(p) for s in _steps(p, joints)]
    out = []
    for choice, picked in enumerate(product(*alternatives)):
        chosen = {p.name: _filled(p, t, joints, torque) for p, t in picked}
        base = {**start, **chosen}
        out.append(Trial(choice, base))
        out += [Trial(choice, {**base, name: values}) for name, values in side_by_side]
    return out


def _with_start(p: Parameter) -> tuple[float, ...]:
    """The trials, and the start of what stays as it is unless the data ask."""
    return (p.start, *p.trials) if p.extra else p.trials


def _steps(p: Parameter, joints: int) -> list[tuple[str, Floats]]:
    """Values of a blending shape other than its start: one element at a time where they are coordinates."""
    base, out = np.full(p.count(joints), p.start), []
    for t in p.trials:
        if isinstance(p.size, int) and p.size > 1:
            for k in range(p.size):
                moved = base.copy()
                moved[k] = t
                out.append((p.name, moved))
        elif not np.all(base == t):
            out.append((p.name, np.full_like(base, t)))
    return out


def _filled(p: Parameter, value: float, joints: int, torque: Floats) -> Floats:
    if p.trials_of == "torque":
        return np.clip(value * np.maximum(torque, 1e-3), p.low, p.high)
    return np.full(p.count(joints), value)


def columns_of(
    effects: Sequence[Effect], joints: int, torque: Floats, setups: int = sys.maxsize
) -> tuple[list[Column], list[Term]]:
    """Every column that sensitivities have to give, and the terms made of them, for readings of so many set-ups."""
    columns: list[Column] = []
    terms: list[Term] = []
    for effect in effects:
        runs = list(enumerate(trials(effect, joints, torque)))
        for site in effect.sites(joints):
            for choice in sorted({t.choice for _, t in runs}):
                mine = [(r, t) for r, t in runs if t.choice == choice]
                core = _columns_at(effect, site, mine, joints)
                rich_too = mine[:1] if can_be_richer(effect, setups) else []
                extra = _columns_at(effect, site, rich_too, joints, extras=True)
                first, middle = len(columns), len(columns) + len(core)
                columns += core + extra
                rich = range(middle if effect.as_table else first, len(columns))
                for at in (range(first, middle), rich) if extra else (range(first, middle),):
                    if not core:
                        continue
                    terms.append(
                        Term(
                            effect=effect,
                            site=site,
                            choice=choice,
                            extras=at.stop > middle,
                            columns=tuple(at),
                            positive=tuple(_one_sided(columns[k].number.parameter) for k in at),
                        )
                    )
    return columns, terms


def _columns_at(
    effect: Effect, site: Site, runs: Sequence[tuple[int, Trial]], joints: int, *, extras: bool = False
) -> list[Column]:
    """Columns of the numbers at a site, trial by trial."""
    numbers = [u for u in numbers_of(effect, site, joints, extras) if u.parameter.extra == extras]
    return [Column(run, u, trial) for run, trial in runs for u in numbers if u.parameter.neutral is not None]


def _one_sided(p: Parameter) -> bool:
    """Whether the solver's number can only grow from where there is no effect."""
    return p.neutral == (p.high if p.fit == "inverse" else p.low)


def started(term: Term, columns: Sequence[Column], weight: Floats, joints: int) -> dict[str, Floats]:
    """Values that a fit starts with: columns weighted (K,) as the linear fit found them, neutral at all other sites."""
    values = term.effect.neutral(joints)
    picked = [columns[k] for k in term.columns]
    heaviest = max(range(len(picked)), key=lambda i: abs(weight[i]))
    for p in term.effect.parameters:
        mine = [(c, w) for c, w in zip(picked, weight, strict=True) if c.number.parameter is p]
        if p.neutral is None:
            values[p.name] = _shape(p=p, term=term, picked=picked, weight=weight, heaviest=picked[heaviest].trial)
        else:
            for c, w in mine:
                k = c.number.index
                inverse = p.fit == "inverse"
                now = 1 / values[p.name][k] + w if inverse else values[p.name][k] + w
                values[p.name][k] = np.clip(1 / now if inverse else now, p.low, p.high)
    return values


def _shape(p: Parameter, term: Term, picked: Sequence[Column], weight: Floats, heaviest: Trial) -> Floats:
    """A shape as the columns blend it: the mean of the trials, weighted by what was found at each."""
    if not blends(p):
        return heaviest.values[p.name].copy()
    size = np.maximum(weight, 0) + 1e-12
    values = np.stack([c.trial.values[p.name] for c in picked])
    if whole_turn(p):
        return np.arctan2(size @ np.sin(values), size @ np.cos(values))
    return np.asarray(np.clip(size @ values / size.sum(), p.low, p.high))


def whole_turn(p: Parameter) -> bool:
    """Whether a parameter is an angle that comes back to itself."""
    return p.unit == "rad" and p.high - p.low > 2 * math.pi - 1e-6
