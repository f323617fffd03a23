"""Alternatives: other effects that explain the same readings as well, and every effect added by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition, at_values_of
from stiffness.diagnosis.adoption import adopted
from stiffness.diagnosis.linearisation import Expansion, Linearised
from stiffness.diagnosis.result import Candidate
from stiffness.diagnosis.search import ODDS, Search, bic, within
from stiffness.diagnosis.selection import Selection, steady
from stiffness.diagnosis.twin_start import like_its_twin
from stiffness.effects.effect import Effect, Site
from stiffness.identification.fit import Fit
from stiffness.session.session import traces_alone

# studied in tests/stiffness/diagnosis/test_alternatives.py, tests/effects_report
LINEAR = 0.08  # of a gain: how far the linearised model may be off
CLOSEST = 3  # alternatives that are fitted
ALIKE = 1.1  # of chi-square: what two effects leave that are one to the readings, one of them as a table with a prior
BETTER = 6.0  # difference of BIC by which an alternative takes the place


@dataclass(frozen=True, repr=False, eq=False)
class Alternatives:
    """An addition with its alternatives.

    Attributes:
        explains: fraction of the residual above the noise.
        fits: of the effects that explain the readings as well, by name.
        held_out: fraction that it explains in cross-validation of the linearised model; runner_up: the largest that any
            other effect does in its place.
    """

    addition: Addition
    explains: float
    fits: Mapping[str, Fit]
    held_out: float = 0.0
    runner_up: float = 0.0


def candidates(effects: Sequence[Effect], base: Linearised) -> tuple[list[Candidate], float]:
    """Every effect added by itself to the model at hand, lowest cross-validated residual first; and m, RMS of none
    added."""
    selector = base.selector
    floor, count = _floor(base.fit), max(selector.equations.count, 1)
    found = []
    for effect in effects:
        chosen = within(selector, effect)
        chi2 = selector.cross_validated(chosen.terms)
        where = tuple(dict.fromkeys(w for t in chosen.terms for w in t.site.where))
        found.append((float(chi2.sum()), effect.name, where, chi2, bool(chosen.terms)))
    out = []
    for total, name, where, chi2, there in sorted(found, key=lambda f: (f[0], f[1])):
        alike = [
            n
            for _, n, _, other, t in found
            if n != name and t and there and not steady(other - chi2) and not steady(chi2 - other)
        ]
        out.append(Candidate(name, where, floor * float(np.sqrt(max(total, 0.0) / count)), tuple(alike)))
    none_added = float(selector.cross_validated([]).sum())
    return out, floor * float(np.sqrt(max(none_added, 0.0) / count))


def _floor(fit: Fit) -> float:
    """m, RMS per axis of the tracker's noise."""
    return float(np.sqrt(np.mean(np.concatenate([s.samples.sd[s.used] for s in fit.sessions]) ** 2)))


def with_alternatives(
    search: Search, fit: Fit, additions: list[Addition], base: Fit
) -> tuple[Fit, list[Addition], list[Alternatives]]:
    """Every addition compared with the other effects of the catalogue in its place; a better one takes it."""
    out: dict[str, Alternatives] = {}
    for a in (a for a in additions if not a.held):
        rest = [b for b in additions if b is not a]
        if len(rest) == len(additions):  # another has taken its place
            continue
        bare = search.fits.fit(rest, fit) if rest else base
        trials, shares = _trials(search=search, bare=bare, rest=rest, a=a, fit=fit)
        better = [t for t in trials if t.bic < bic(fit, fit.solution.misfit) - BETTER]
        if better:
            best = min(better, key=lambda t: t.bic)
            trials = [t for t in trials if t is not best] + [_Trial(a.effect.name, fit, additions, bic(fit, 1.0))]
            fit, additions = best.fit, best.additions
            a = next((b for b in additions if b.effect.name == best.name), a)
        explains = _explained(base, bare, fit)
        least = bic(fit, fit.solution.misfit)
        alike = {t.name: t.fit for t in trials if bic(t.fit, fit.solution.misfit) < least + ODDS or _twin(a, t, fit)}
        if len(a.sites) > 1 and traces_alone(s.session for s in fit.sessions):
            alike = {**_at_one_site(search, fit, additions, a), **alike}
        out[a.effect.name] = Alternatives(a, explains, alike, *shares)
    return fit, additions, [out[a.effect.name] for a in additions if a.effect.name in out]


def explained_at_last(
    search: Search, fit: Fit, additions: Sequence[Addition], base: Fit, found: Sequence[Alternatives]
) -> list[Alternatives]:
    """Alternatives of the additions that stayed, each with what it explains beside the others that did."""
    kept = [r for r in found if any(a.effect is r.addition.effect for a in additions)]
    if len(kept) == len(found):
        return kept
    out = []
    for r in kept:
        rest = [a for a in additions if a.effect is not r.addition.effect]
        out.append(replace(r, explains=_explained(base, search.fits.fit(rest, fit) if rest else base, fit)))
    return out


def _explained(base: Fit, bare: Fit, fit: Fit) -> float:
    """Fraction of what is above the noise in ``base`` that a fit takes away beside ``bare``."""
    above = max(base.solution.chi2 - base.solution.freedom, 1e-9)
    return float(np.clip((bare.solution.chi2 - fit.solution.chi2) / above, 0, 1))


def _at_one_site(search: Search, fit: Fit, additions: list[Addition], a: Addition) -> dict[str, Fit]:
    """Effects that explain the readings as well at one of the sites of an addition, which stays at its others: a gap in
    one joint, say, beside the friction of another."""
    out: dict[str, Fit] = {}
    rest, least = [b for b in additions if b is not a], bic(fit, fit.solution.misfit)
    others = [e for e in search.effects if all(e is not b.effect for b in additions)]
    for site in a.sites:
        if (less := a.without(site, search.fits.joints)) is None:
            continue
        bare = search.fits.fit([*rest, less], fit)
        start, found = _each_at(search, bare, [*rest, less], effects=others, site=site)
        gain = bic(bare, fit.solution.misfit) - least
        found = [s for s in found if s.terms and s.bic_gain > gain - ODDS - LINEAR * s.fit.gain]
        for chosen in sorted(found, key=lambda s: -s.bic_gain)[:CLOSEST]:
            _, trial = adopted(search.fits, start, chosen, [*rest, less])
            if bic(trial, fit.solution.misfit) < least + ODDS:
                out.setdefault(chosen.terms[0].effect.name, trial)
    return out


def _each_at(
    search: Search, bare: Fit, rest: list[Addition], *, effects: Sequence[Effect], site: Site
) -> tuple[Expansion, list[Selection]]:
    """Every effect at a site, beside the ``rest``, and where the model was linearised."""
    linear = search.linearisation.at(bare, rest)
    return linear.expansion, [within(linear.selector, e, site) for e in effects]


@dataclass(frozen=True, repr=False, eq=False)
class _Trial:
    """Another effect in an addition's place, fitted."""

    name: str
    fit: Fit
    additions: list[Addition]
    bic: float


def _twin(a: Addition, trial: _Trial, fit: Fit) -> bool:
    """Whether an effect that no static readings tell from an addition, with however many numbers, leaves no more."""
    return trial.name in a.effect.twins and trial.fit.solution.chi2 < ALIKE * fit.solution.chi2


def _trials(
    search: Search, bare: Fit, rest: list[Addition], a: Addition, fit: Fit
) -> tuple[list[_Trial], tuple[float, float]]:
    """Effects that the linearised model does not put clearly behind an addition, each fitted in its place; and what the
    addition and the best of the others explain in cross-validation."""
    start, rivals, shares = _rivals(search, bare, rest, a)
    out = []
    for chosen in rivals:
        more, trial = adopted(search.fits, start, chosen, rest)
        other = chosen.terms[0].effect
        if other.name in a.effect.twins and trial.solution.chi2 > fit.solution.chi2:
            for begun in like_its_twin(fit, a, other):
                again = search.fits.fit([*rest, begun], fit)
                if again.solution.chi2 < trial.solution.chi2:
                    more, trial = at_values_of(again, [*rest, begun]), again
        out.append(_Trial(other.name, trial, more, bic(trial, fit.solution.misfit)))
    return out, shares


def _rivals(
    search: Search, bare: Fit, rest: list[Addition], a: Addition
) -> tuple[Expansion, list[Selection], tuple[float, float]]:
    """Where the model was linearised without an addition, the effects that are not clearly behind it there, and what
    it and the best of the others explain in cross-validation."""
    linear = search.linearisation.at(bare, rest)
    selector = linear.selector
    own = within(selector, a.effect)
    found = [within(selector, e) for e in search.effects if e is not a.effect]
    none = float(selector.cross_validated([]).sum())
    above = max(none - selector.equations.count, 1e-9)
    gains = [(none - float(selector.cross_validated(s.terms).sum())) / above for s in (own, *found)]
    twins = [
        chosen
        for e in search.effects
        for site in e.sites(search.fits.joints)
        if e.name in a.effect.twins and any(site.where == s.where for s in a.sites)
        if (chosen := within(selector, e, site)).terms
    ]
    near = own.bic_gain - ODDS - LINEAR * own.fit.gain
    taken = {t.terms[0].effect.name for t in twins}
    found = [s for s in found if s.terms and s.bic_gain > near and s.terms[0].effect.name not in taken]
    rivals = [*sorted(found, key=lambda s: -s.bic_gain)[:CLOSEST], *twins]
    return linear.expansion, rivals, (gains[0], max(gains[1:], default=0.0))
