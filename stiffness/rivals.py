"""Rivals: which other effects would explain the same readings as well, and how every effect fares by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stiffness.additions import Addition
from stiffness.diagnosis import Candidate
from stiffness.effects.effect import Effect
from stiffness.evidence import Evidence
from stiffness.fit import Fit
from stiffness.search import Screened, Search
from stiffness.selection import Choice, Selector, steady

ODDS = 10.0  # twice the logarithm of the odds from which one explanation is preferred to another
LINEAR = 0.05  # of a gain: how far the linear picture may be off
BETTER = 6.0  # chi-square, numbers paid for, by which a rival has to win to take the place
MOST_SITES = 8


@dataclass(frozen=True, repr=False)
class Rival:
    """An addition, the share of the residual above the noise that it ``explains``, and ``fits`` of what is as good."""

    addition: Addition
    explains: float
    fits: Mapping[str, Fit]


def candidates(search: Search, base: Fit) -> list[Candidate]:
    """Every effect added by itself to the model at hand, best on set-ups left out first."""
    screened = search.screened(base, [])
    selector = screened.selector
    floor, count = _floor(base.evidence), max(selector.ledger.count, 1)
    found = []
    for effect in search.effects:
        choice = within(selector, effect)
        heldout = selector.heldout(choice.units)
        where = tuple(dict.fromkeys(w for u in choice.units for w in u.site.where))
        found.append((float(heldout.sum()), effect.name, where, heldout, bool(choice.units)))
    out = []
    for chi2, name, where, heldout, there in sorted(found, key=lambda f: (f[0], f[1])):
        alike = [n for _, n, _, h, t in found if n != name and t and there and not steady(h - heldout) and not steady(heldout - h)]
        out.append(Candidate(name, where, floor * float(np.sqrt(max(chi2, 0.0) / count)), tuple(alike)))
    return out


def within(selector: Selector, effect: Effect) -> Choice:
    """The sites of one effect that pay, one after the other."""
    own = Selector(selector.ledger, [u for u in selector.units if u.effect is effect], selector.freedom)
    chosen = own.together([])
    while len(chosen.units) < MOST_SITES:
        ranked = own.ranked(chosen)
        if not ranked or ranked[0].worth <= chosen.worth:
            break
        chosen = ranked[0]
    return chosen


def _floor(evidence: Sequence[Evidence]) -> float:
    """m, RMS per axis of the tracker's noise."""
    return float(np.sqrt(np.mean(np.concatenate([e.samples.sd[e.used] for e in evidence]) ** 2)))


def rivals(
    search: Search, fit: Fit, additions: list[Addition], base: Fit
) -> tuple[Fit, list[Addition], list[Rival]]:
    """Every addition against the others of the catalogue in its place; a better one takes it."""
    for k in range(len(additions)):
        a = additions[k]
        rest = additions[:k] + additions[k + 1 :]
        bare = search.bench.fit(rest, fit) if rest else base
        swapped = _better_one(search, bare, rest, a, fit)
        if swapped is not None:
            fit, additions = swapped
    out = []
    for a in additions:
        rest = [b for b in additions if b is not a]
        bare = search.bench.fit(rest, fit) if rest else base
        screened = search.screened(bare, rest)
        above = max(base.solution.chi2 - base.solution.freedom, 1e-9)
        explains = (bare.solution.chi2 - fit.solution.chi2) / above
        out.append(Rival(a, float(np.clip(explains, 0, 1)), _as_good(search, screened, rest, a, fit)))
    return fit, additions, out


def _close(screened: Screened, a: Addition, search: Search) -> list[Choice]:
    """Choices of other effects that the linear picture does not put clearly behind an addition."""
    selector = screened.selector
    own = within(selector, a.effect)
    found = [within(selector, e) for e in search.effects if e is not a.effect]
    found = [c for c in found if c.units and c.worth > own.worth - ODDS - LINEAR * own.fit.gain]
    return sorted(found, key=lambda c: -c.worth)[:3]


def _price(fit: Fit, misfit: float) -> float:
    return fit.solution.chi2 / misfit**2 + len(fit.unknowns) * float(np.log(fit.solution.count))


def _better_one(
    search: Search, bare: Fit, rest: list[Addition], a: Addition, fit: Fit
) -> tuple[Fit, list[Addition]] | None:
    """A rival that explains more, numbers paid for."""
    screened = search.screened(bare, rest)
    best = None
    for choice in _close(screened, a, search):
        more, trial = search.adopted(screened, choice, rest)
        more, trial = search.pruned(more, trial)
        misfit = min(trial.solution.misfit, fit.solution.misfit)
        if _price(trial, misfit) < _price(fit if best is None else best[0], misfit) - BETTER:
            best = (trial, more)
    return best


def _as_good(search: Search, screened: Screened, rest: list[Addition], a: Addition, fit: Fit) -> dict[str, Fit]:
    """Effects whose fit these readings do not tell from an addition's."""
    out = {}
    for choice in _close(screened, a, search):
        name = choice.units[0].effect.name
        more, trial = search.adopted(screened, choice, rest)
        misfit = min(trial.solution.misfit, fit.solution.misfit)
        if _price(trial, misfit) < _price(fit, misfit) + ODDS and any(b.effect.name == name for b in more):
            out[name] = trial
    return out
