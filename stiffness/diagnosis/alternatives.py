"""Rivals: which other effects would explain the same readings as well, and how every effect fares by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stiffness.diagnosis.added_effects import Addition
from stiffness.diagnosis.result import Candidate
from stiffness.diagnosis.search import Linearised, Search
from stiffness.diagnosis.selection import Choice, Selector, steady
from stiffness.effects.effect import Effect
from stiffness.identification.fit import Fit

ODDS = 10.0  # twice the logarithm of the odds from which one explanation is preferred to another
LINEAR = 0.08  # of a gain: how far the linear picture may be off
CLOSEST = 3  # rivals that are fitted
BETTER = 6.0  # chi-square, numbers paid for, by which a rival has to win to take the place
MOST_SITES = 8


@dataclass(frozen=True, repr=False)
class Rival:
    """An addition, the share of the residual above the noise that it ``explains``, and ``fits`` of what is as good."""

    addition: Addition
    explains: float
    fits: Mapping[str, Fit]


def candidates(effects: Sequence[Effect], base: Linearised) -> tuple[list[Candidate], float]:
    """Every effect added by itself to the model at hand, best on set-ups left out first; and m, RMS of none added."""
    selector = base.selector
    floor, count = _floor(base.fit), max(selector.ledger.count, 1)
    found = []
    for effect in effects:
        choice = within(selector, effect)
        heldout = selector.heldout(choice.terms)
        where = tuple(dict.fromkeys(w for u in choice.terms for w in u.site.where))
        found.append((float(heldout.sum()), effect.name, where, heldout, bool(choice.terms)))
    out = []
    for chi2, name, where, heldout, there in sorted(found, key=lambda f: (f[0], f[1])):
        alike = [
            n
            for _, n, _, h, t in found
            if n != name and t and there and not steady(h - heldout) and not steady(heldout - h)
        ]
        out.append(Candidate(name, where, floor * float(np.sqrt(max(chi2, 0.0) / count)), tuple(alike)))
    return out, floor * float(np.sqrt(max(float(selector.heldout([]).sum()), 0.0) / count))


def within(selector: Selector, effect: Effect) -> Choice:
    """The sites of one effect that pay, one after the other."""
    own = Selector(selector.ledger, [u for u in selector.terms if u.effect is effect], selector.freedom)
    chosen = own.together([])
    while len(chosen.terms) < MOST_SITES:
        ranked = own.ranked(chosen)
        if not ranked or ranked[0].worth <= chosen.worth:
            break
        chosen = ranked[0]
    return chosen


def _floor(fit: Fit) -> float:
    """m, RMS per axis of the tracker's noise."""
    return float(np.sqrt(np.mean(np.concatenate([s.samples.sd[s.used] for s in fit.sessions]) ** 2)))


def rivals(search: Search, fit: Fit, additions: list[Addition], base: Fit) -> tuple[Fit, list[Addition], list[Rival]]:
    """Every addition against the others of the catalogue in its place; a better one takes it."""
    out: dict[str, Rival] = {}
    for a in additions:
        rest = [b for b in additions if b is not a]
        if len(rest) == len(additions):  # another has taken its place
            continue
        bare = search.fits.fit(rest, fit) if rest else base
        trials = _trials(search, bare, rest, a, fit)
        better = [t for t in trials if t.price < _price(fit, fit.solution.misfit) - BETTER]
        if better:
            best = min(better, key=lambda t: t.price)
            trials = [t for t in trials if t is not best] + [_Trial(a.effect.name, fit, additions, _price(fit, 1.0))]
            fit, additions = best.fit, best.additions
            a = next((b for b in additions if b.effect.name == best.name), a)
        above = max(base.solution.chi2 - base.solution.freedom, 1e-9)
        explains = float(np.clip((bare.solution.chi2 - fit.solution.chi2) / above, 0, 1))
        least = _price(fit, fit.solution.misfit)
        alike = {t.name: t.fit for t in trials if _price(t.fit, fit.solution.misfit) < least + ODDS}
        out[a.effect.name] = Rival(a, explains, alike)
    return fit, additions, [out[a.effect.name] for a in additions if a.effect.name in out]


@dataclass(frozen=True, repr=False)
class _Trial:
    """Another effect in an addition's place, fitted."""

    name: str
    fit: Fit
    additions: list[Addition]
    price: float


def _trials(search: Search, bare: Fit, rest: list[Addition], a: Addition, fit: Fit) -> list[_Trial]:
    """Effects that the linear picture does not put clearly behind an addition, each fitted in its place."""
    linear = search.linearised(bare, rest)
    selector = linear.selector
    own = within(selector, a.effect)
    found = [within(selector, e) for e in search.effects if e is not a.effect]
    found = [c for c in found if c.terms and c.worth > own.worth - ODDS - LINEAR * own.fit.gain]
    out = []
    for choice in sorted(found, key=lambda c: -c.worth)[:CLOSEST]:
        more, trial = search.adopted(linear, choice, rest)
        name = choice.terms[0].effect.name
        out.append(_Trial(name, trial, more, _price(trial, fit.solution.misfit)))
    return out


def _price(fit: Fit, misfit: float) -> float:
    """Chi-square in units of what is left, and what the numbers cost."""
    return fit.solution.chi2 / misfit**2 + len(fit.unknowns) * float(np.log(fit.solution.count))
