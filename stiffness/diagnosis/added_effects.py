"""Added effects: what a diagnosis adds to a model, effects at some of their sites, and the fits that have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.candidates import Column, Term, started
from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect, Numbers, Site
from stiffness.identification.fit import Fit
from stiffness.identification.fitting import fitted
from stiffness.identification.problem import Problem
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import Unknown, Unknowns, numbers_of, unknowns
from stiffness.identification.weighting import Weighting
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import EXACT, Ending
from stiffness.session.session import Session, count_setups

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Addition:
    """One effect: ``sites`` where it is, those of them with ``extras``, ``values`` of all its numbers, and whether they
    are ``held`` as they are."""

    effect: Effect
    sites: tuple[Site, ...]
    extras: frozenset[Site]
    values: Numbers
    held: bool = False

    @property
    def where(self) -> tuple[str, ...]:
        """Places in the words of reports, each once."""
        return tuple(dict.fromkeys(w for s in self.sites for w in s.where))

    def numbers(self, joints: int) -> list[Unknown]:
        """Its free numbers."""
        if self.held:
            return []
        return [u for s in self.sites for u in numbers_of(self.effect, s, joints, s in self.extras)]

    def without(self, site: Site, joints: int) -> Addition | None:
        """The same elsewhere; None when nothing is left."""
        sites = tuple(s for s in self.sites if s != site)
        return with_sites(replace(self, sites=sites), joints) if sites else None


def as_addition(effect: Effect, values: Numbers, joints: int) -> Addition | None:
    """An effect of a model as if it had been added: the sites where its numbers are not neutral; None where there are
    none."""
    def used(site: Site, extra: bool) -> bool:
        mine = (p for p in effect.parameters if p.site == site.kind and p.neutral is not None and p.extra == extra)
        return any(np.any(values[p.name][p.of_site(site.index)] != p.neutral) for p in mine)

    sites = tuple(s for s in effect.sites(joints) if used(s, False) or used(s, True))
    return Addition(effect, sites, frozenset(s for s in sites if used(s, True)), values) if sites else None


def with_sites(addition: Addition, joints: int) -> Addition:
    """Values neutral wherever it is not."""
    neutral = addition.effect.neutral(joints)
    kept = {k: v.copy() for k, v in neutral.items()}
    for p in addition.effect.parameters:
        for s in (s for s in addition.sites if s.kind == p.site):
            kept[p.name][p.of_site(s.index)] = addition.values[p.name][p.of_site(s.index)]
    return replace(addition, values=kept, extras=addition.extras & set(addition.sites))


def enriched(a: Addition, site: Site, joints: int) -> Addition:
    """An addition with extras at a site; a table begins as what it stands in the place of."""
    rich = replace(a, extras=a.extras | {site})
    if a.effect.as_table is None:
        return rich
    values = {name: np.array(v) for name, v in a.values.items()}
    plain = [p.name for p in a.effect.parameters if not p.extra]
    (table,) = (p for p in a.effect.parameters if p.extra)
    own = np.array([values[name][site.index] for name in plain])
    values[table.name][table.of_site(site.index)] += a.effect.as_table() @ own
    for name in plain:
        values[name][site.index] = a.effect.neutral(joints)[name][site.index]
    return replace(rich, values=values)


def simplified(a: Addition, site: Site, joints: int) -> Addition:
    """An addition without extras at a site."""
    idle = a.effect.neutral(joints)
    values = {name: np.array(v) for name, v in a.values.items()}
    for p in (p for p in a.effect.parameters if p.extra and p.site == site.kind):
        values[p.name][p.of_site(site.index)] = idle[p.name][p.of_site(site.index)]
    return replace(a, values=values, extras=a.extras - {site})


def merged(
    old: Sequence[Addition], term: Term, columns: Sequence[Column], weight: Floats, joints: int
) -> list[Addition]:
    """Additions with one term more, its numbers started where the linear fit found them."""
    begun = started(term, columns, weight, joints)
    extras = frozenset({term.site}) if term.extras or _shaped(term, begun) else frozenset()
    before = next((a for a in old if a.effect is term.effect), None)
    if before is None:
        return [*old, with_sites(Addition(term.effect, (term.site,), extras, begun), joints)]
    rich = term.extras and term.site in before.sites
    values = {k: np.array(v) for k, v in (enriched(before, term.site, joints) if rich else before).values.items()}
    for p in (p for p in term.effect.parameters if p.site == term.site.kind):
        # of a site that is there only the extras are new; what shapes the law stays as it was fitted
        if term.site not in before.sites or (p.extra and p.neutral is not None):
            at = p.of_site(term.site.index)
            so_far = values[p.name][at] if rich and p.each > 1 else 0.0
            values[p.name][at] = begun[p.name][at] + so_far
    sites = before.sites if term.site in before.sites else (*before.sites, term.site)
    order = {s: k for k, s in enumerate(term.effect.sites(joints))}
    now = Addition(term.effect, tuple(sorted(sites, key=order.__getitem__)), before.extras | extras, values)
    return [now if a is before else a for a in old]


def _shaped(term: Term, begun: Numbers) -> bool:
    """Whether the extras of an effect are shapes alone, and one of them is better away from its start: it is fitted."""
    extras = [p for p in term.effect.parameters if p.extra and p.site == term.site.kind]
    if any(p.neutral is not None for p in extras):
        return False
    return any(np.any(begun[p.name][p.of_site(term.site.index)] != p.start) for p in extras)


@dataclass(frozen=True, repr=False, eq=False)
class ModelFits:
    """Fits of one model to the same readings, with and without effects added.

    Attributes:
        base: effects of the model that these sessions show; ``values``: theirs; ``given``: names of those that stay as
            they are.
        ending: what ends a fit. widened: factor on the noise that prior knowledge is weighed against.
        prior: a model whose standard deviations hold its numbers; else they are loose.
        used: per session (N,), readings that take part. allowed: readings that may.
    """

    data: tuple[SessionData, ...]
    base: tuple[Effect, ...]
    values: Mapping[str, Numbers]
    used: tuple[Bools, ...]
    allowed: tuple[Bools, ...]
    given: tuple[str, ...] = ()
    prior: ComplianceModel | None = None
    ending: Ending = EXACT
    widened: float = 1.0

    @classmethod
    def of(
        cls,
        sessions: Sequence[Session],
        base: Sequence[Effect],
        values: Mapping[str, Numbers],
        used: Sequence[Bools],
    ) -> ModelFits:
        """Fits to the ``used`` readings of sessions; no others may take part."""
        return cls(
            data=tuple(SessionData.of(s) for s in sessions),
            base=tuple(base),
            values=values,
            used=tuple(used),
            allowed=tuple(used),
        )

    def __repr__(self) -> str:
        return f"ModelFits({len(self.data)} sessions, {', '.join(e.name for e in self.base)})"

    @property
    def sessions(self) -> tuple[Session, ...]:
        """What was measured."""
        return tuple(d.session for d in self.data)

    @cached_property
    def setups(self) -> int:
        """How many there are."""
        return count_setups(self.sessions)

    @property
    def joints(self) -> int:
        """Of the robot."""
        return self.data[0].session.robot.n

    @cached_property
    def weightings(self) -> tuple[Weighting, ...]:
        """Absolute positions are trusted."""
        return tuple(Weighting(d.session, 0.0) for d in self.data)

    def held_by(self, model: ComplianceModel) -> ModelFits:
        """The numbers of a model held by their standard deviations, those without any as they are."""
        sure = [e.name for e in self.base if not all(np.all(sd > 0) for sd in self._deviations(model, e))]
        # what was not identified has a standard deviation that means nothing: it is loose
        sd = {name: {k: _of_known(v, model.identified.get(name)) for k, v in p.items()} for name, p in model.sd.items()}
        return replace(self, prior=replace(model, sd=sd), given=(*self.given, *sure))

    def _deviations(self, model: ComplianceModel, e: Effect) -> list[npt.NDArray[np.float64]]:
        """Of every parameter of an effect that is fitted."""
        names = {u.parameter.name for u in self.layout([]).free if u.effect == e.name}
        given = model.sd.get(e.name, {})
        return [np.asarray(given.get(name, np.zeros(1))) for name in sorted(names)]

    def layout(self, additions: Sequence[Addition], *, base_fixed: bool = False) -> Unknowns:
        """The free numbers: all of the model at hand, and those of the additions."""
        names = {e.name for e in self.base} | {a.effect.name for a in additions}
        effects = tuple(e for e in CATALOGUE if e.name in names)
        own = () if base_fixed else unknowns(self.base, self.joints, self.given, extras=self._rich).free
        own = tuple(u for u in own if not u.parameter.extra or self._there(u))
        more = [u for a in additions for u in a.numbers(self.joints)]
        return Unknowns(effects, self.joints, (*own, *more))

    def _rich(self, effect: Effect, site: Site) -> bool:
        """Whether extras of the model at hand may be free at a site: not a table that it does not have there."""
        own = as_addition(effect, self.values[effect.name], self.joints) if effect.as_table else None
        return effect.as_table is None or (own is not None and site in own.extras)

    def _there(self, u: Unknown) -> bool:
        """Whether the model at hand uses a number that is freed only where data ask for it."""
        idle = u.parameter.start if u.parameter.neutral is None else u.parameter.neutral
        return bool(np.any(self.values[u.effect][u.parameter.name] != idle))

    def fit(
        self,
        additions: Sequence[Addition],
        start: Fit | None = None,
        *,
        base_fixed: bool = False,
        held: tuple[str, ...] = (),
        anew: str = "",
    ) -> Fit:
        """The model at hand with additions.

        Args:
            start: a fit to begin with, but for the effect ``anew``.
            held: effects that stay as they are.
        """
        layout = self.layout(additions, base_fixed=base_fixed)
        layout = replace(layout, free=tuple(u for u in layout.free if u.effect not in held))
        fixed = {e.name: self.values[e.name] for e in self.base}
        fixed |= {a.effect.name: a.values for a in additions}
        problem = Problem.of_sessions(self.data, self.weightings, layout, fixed, prior=self.prior)
        # increments of tracker poses count from the first guess of the fit that gives their start
        poses = [None] * len(self.data) if start is None else [s.state.poses for s in start.sessions]
        states = tuple(
            replace(state, used=used, allowed=allowed, poses=guess)
            for state, used, allowed, guess in zip(problem.first_states(), self.used, self.allowed, poses, strict=True)
        )
        vector = None if start is None else _begun(problem, start, anew)
        return fitted(
            problem,
            states,
            vector,
            once=not any(u.parameter.each > 1 for a in additions for u in a.numbers(self.joints)),
            widened=self.widened,
            ending=self.ending,
        )

    def within_limits(self, fit: Fit, additions: Sequence[Addition]) -> Fit:
        """A fit whose effects allow their values: what one does not allow is moved to the nearest that it does and held
        there, and all else is fitted again."""
        values = fit.values()
        wrong = [a for a in additions if a.effect.nearest and a.effect.check(values[a.effect.name])]
        if not wrong:
            return fit
        allowed = fit.allowed_values()
        held = {a.effect.name: allowed[a.effect.name] for a in wrong}
        moved = [replace(a, values=held.get(a.effect.name, values[a.effect.name])) for a in additions]
        return self.fit(moved, fit, held=tuple(held))


def _of_known(sd: npt.ArrayLike, identified: Bools | None) -> npt.NDArray[np.float64]:
    """Standard deviations, 0 where a number was not identified."""
    out = np.array(sd, dtype=float)
    if identified is not None and len(out) == len(identified):
        out[~np.asarray(identified)] = 0.0
    return out


def _begun(problem: Problem, start: Fit, anew: str) -> Floats:
    """(V,) numbers of another fit where it has them, but for the effect ``anew``; those of the stations are the same in
    both."""
    pairs = zip(start.unknowns.free, start.parameters, strict=True)
    known = {(u.effect, u.parameter.name, u.index): v for u, v in pairs if u.effect != anew}
    layout = problem.unknowns
    first = layout.start(problem.fixed)
    own = np.array(
        [known.get((u.effect, u.parameter.name, u.index), v) for u, v in zip(layout.free, first, strict=True)]
    )
    return np.concatenate([own, start.solution.vector[len(start.unknowns) :]])


def at_values_of(fit: Fit, additions: Sequence[Addition]) -> list[Addition]:
    """Additions with the values of a fit."""
    values = fit.values()
    return [replace(a, values=values[a.effect.name]) for a in additions]
