"""Adoption: terms that the linearised model chose, fitted with the full model, without what the fit leaves empty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits, at_values_of, enriched, merged, simplified
from stiffness.diagnosis.candidates import Column, Term
from stiffness.diagnosis.linearisation import Expansion, weak
from stiffness.diagnosis.searched_numbers import with_better_numbers
from stiffness.diagnosis.selection import CHANCE, Selection
from stiffness.effects.effect import Numbers, Site
from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import can_be_richer
from stiffness.numerics.least_squares import inverse

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/diagnosis/test_rich_laws.py, tests/effects_report
SETTLED = 1.1  # residual over noise below which a fit is not started anew from elsewhere
PLAIN = 1e-6  # chance from which on a table needs no fit of its simple form beside it
NOT_THERE = 1e-3  # chance above which a site of a fitted effect counts as empty
SEARCHES = 2  # of the numbers that no derivative leads to, a fit after each


def adopted(
    fits: ModelFits, start: Expansion, chosen: Selection, additions: Sequence[Addition]
) -> tuple[list[Addition], Fit]:
    """Chosen terms as additions, fitted; where much is left, the fit is started from every shape on trial."""
    weights = {u.key: chosen.weights(u) for u in chosen.terms}
    begun = _merged(fits, columns=start.columns, terms=chosen.terms, weights=weights, additions=additions)
    fit = fits.fit(begun, start.fit)
    if fit.solution.misfit > SETTLED:  # the numbers of a model without the effect may be far off with it
        other = fits.fit(begun)
        fit = min(fit, other, key=lambda f: f.solution.chi2)
    for term in chosen.terms if fit.solution.misfit > SETTLED else ():
        for alone in _one_trial_each(term, start.columns, weights[term.key]):
            trial = _merged(
                fits,
                columns=start.columns,
                terms=chosen.terms,
                weights={**weights, term.key: alone},
                additions=additions,
            )
            other = fits.fit(trial, start.fit)
            if other.solution.chi2 < fit.solution.chi2:
                fit, begun = other, trial
    for _ in range(SEARCHES if fit.solution.misfit > 1 else 0):
        begun = at_values_of(fit, begun)
        moved = with_better_numbers(fit, begun)
        other = fit if moved is None else fits.fit(moved, fit)
        if moved is None or other.solution.chi2 >= fit.solution.chi2 * (1 - 1e-6):
            break
        fit, begun = other, moved
    return _restarted(fits, at_values_of(fit, begun), fit)


def _restarted(fits: ModelFits, additions: list[Addition], fit: Fit) -> tuple[list[Addition], Fit]:
    """The best of fits that begin with other values of about the same law: bounds of its extras can hold a fit."""
    for k, a in enumerate(additions):
        for site in sorted(a.extras, key=str) if fit.solution.misfit > 1 else ():
            for other in a.effect.restarts(additions[k].values):
                trial = list(additions)
                trial[k] = replace(a, values=_at_site(additions[k], site, other))
                again = fits.fit(trial, fit, anew=a.effect.name)
                if again.solution.chi2 < fit.solution.chi2 - 1:
                    additions, fit = at_values_of(again, trial), again
    return additions, fit


def _at_site(a: Addition, site: Site, other: Numbers) -> dict[str, Floats]:
    """Values of an addition, but for others at one of its sites."""
    values = {name: np.array(v) for name, v in a.values.items()}
    for p in (p for p in a.effect.parameters if p.site == site.kind and p.name in other):
        values[p.name][p.of_site(site.index)] = other[p.name][p.of_site(site.index)]
    return values


def _merged(
    fits: ModelFits,
    columns: Sequence[Column],
    terms: Sequence[Term],
    weights: Mapping[tuple[str, tuple[str, ...]], Floats],
    additions: Sequence[Addition],
) -> list[Addition]:
    more = list(additions)
    for term in terms:
        more = merged(old=more, term=term, columns=columns, weight=weights[term.key], joints=fits.joints)
    return more


def _one_trial_each(term: Term, columns: Sequence[Column], weight: Floats) -> list[Floats]:
    """Weights that put all of a term on one of its trials; none where it has but one."""
    trial = [id(columns[k].trial) for k in term.columns]
    number = [columns[k].number for k in term.columns]
    total = {u: sum(w for w, v in zip(weight, number, strict=True) if v == u) for u in number}
    if len(set(trial)) < 2:
        return []
    return [
        np.array([total[u] if t == one else 0.0 for t, u in zip(trial, number, strict=True)])
        for one in dict.fromkeys(trial)
    ]


def pruned(fits: ModelFits, additions: Sequence[Addition], fit: Fit) -> tuple[list[Addition], Fit]:
    """Without sites that the fit leaves empty, the emptiest first, and without effects that others have made
    superfluous."""
    now = list(additions)
    while True:
        empty = [(site_chance(fits, fit, a, s), a, s) for a in now for s in a.sites]
        worst = max(empty, key=lambda t: t[0], default=None)
        if worst is None or worst[0] < NOT_THERE:
            break
        _, where, site = worst
        less = where.without(site, fits.joints)
        now = [b for a in now if (b := less if a is where else a) is not None]
        fit = fits.fit(now, fit)
        now = at_values_of(fit, now)
    return without_superfluous(fits, *_with_simple_forms(fits, now, fit))


def _with_simple_forms(fits: ModelFits, additions: list[Addition], fit: Fit) -> tuple[list[Addition], Fit]:
    """With the simple form of a law wherever the richer one is not better beyond chance: by the criterion of
    Bayes a law of fifteen numbers more would leave so much to the joints that their stiffness is off by its intervals.
    """
    for a in additions:
        for site in sorted(a.extras, key=str):
            if _plainly_rich(fit, a, site, fits.joints):
                continue
            simple = simplified(a, site, fits.joints)
            trial = [simple if b is a else b for b in additions]
            less = fits.fit(trial, fit, anew=a.effect.name)
            if not better(fit, less):
                return _with_simple_forms(fits, at_values_of(less, trial), less)
    return additions, fit


def _plainly_rich(fit: Fit, a: Addition, site: Site, joints: int) -> bool:
    """Whether a table is so far from all that its simple form and an offset could be that no fit needs to show it."""
    if a.effect.as_table is None or a.held:
        return False
    place = {u: k for k, u in enumerate(fit.unknowns.free)}
    at = np.array([place[u] for u in replace(a, sites=(site,)).numbers(joints)])
    seen = fit.learned()[at]
    simple = np.column_stack([a.effect.as_table(), np.ones(len(at))])[seen]
    precision = inverse(fit.solution.covariance[np.ix_(at[seen], at[seen])])
    own = fit.parameters[at[seen]]
    left = own - simple @ np.linalg.lstsq(simple.T @ precision @ simple, simple.T @ precision @ own, rcond=None)[0]
    drop = float(left @ precision @ left) / fit.solution.misfit**2
    return bool(stats.chi2.sf(drop, max(len(left) - simple.shape[1], 1)) < PLAIN)


def with_richer_forms(fits: ModelFits, additions: list[Addition], fit: Fit) -> tuple[list[Addition], Fit]:
    """With the richer form of a law where it is better beyond chance, once it is settled which effects there are."""
    sites = [(k, s) for k, a in enumerate(additions) for s in _simple(fits, a)]
    for k, site in sites:
        now = additions[k]
        rich = [enriched(now, site, fits.joints) if b is now else b for b in additions]
        more = fits.fit(rich, fit)
        if better(more, fit, len(sites)):
            additions, fit = _restarted(fits, at_values_of(more, rich), more)
    return additions, fit


def richest(fits: ModelFits, additions: Sequence[Addition]) -> list[Addition]:
    """With the richer form of every law, wherever it has one."""
    return [reduce(lambda b, s: enriched(b, s, fits.joints), _simple(fits, a), a) for a in additions]


def _simple(fits: ModelFits, a: Addition) -> list[Site]:
    """Sites where the law of an addition could be richer."""
    if a.held or not can_be_richer(a.effect, fits.setups):
        return []
    kinds = {p.site for p in a.effect.parameters if p.extra}
    return [s for s in a.sites if s.kind in kinds and s not in a.extras]


def without_superfluous(fits: ModelFits, additions: list[Addition], fit: Fit) -> tuple[list[Addition], Fit]:
    """Without effects that, left out as a whole, raise chi-square no more than chance would."""
    for a in additions if len(additions) > 1 else ():
        rest = [b for b in additions if b is not a]
        less = fits.fit(rest, fit)
        if not better(fit, less):
            return without_superfluous(fits, at_values_of(less, rest), less)
    return additions, fit


def better(more: Fit, less: Fit, tried: int = 1) -> bool:
    """Whether a fit beats another beyond chance for the numbers it has more, as one of so many ``tried``; both see the
    same readings."""
    numbers = len(more.unknowns) - len(less.unknowns)
    drop = (less.solution.chi2 - more.solution.chi2) / more.solution.misfit**2
    return bool(stats.chi2.sf(max(drop, 0.0), max(numbers, 1)) * tried < CHANCE)


def site_chance(fits: ModelFits, fit: Fit, addition: Addition, site: Site) -> float:
    """Probability that noise alone gives what the fit finds at a site (Wald test)."""
    mine = set(replace(addition, sites=(site,)).numbers(fits.joints))
    at = [k for k, u in enumerate(fit.unknowns.free) if u in mine and u.parameter.neutral is not None]
    neutral = np.array([fit.unknowns.free[k].parameter.neutral for k in at], dtype=float)
    off = fit.parameters[at] - np.where(fit.unknowns.inverse[at], 1 / np.where(neutral == 0, 1, neutral), neutral)
    # shapes stand still: without the effect they are of no account
    shapes = [k for k, u in enumerate(fit.unknowns.free) if u in mine and u.parameter.neutral is None]
    rest = np.delete(np.arange(len(fit.solution.vector)), shapes)
    information = fit.solution.information + np.diag(weak(fit))
    known = inverse(information[np.ix_(rest, rest)]) * fit.solution.misfit**2
    place = np.searchsorted(rest, at)
    covariance = known[np.ix_(place, place)]
    scale = np.sqrt(np.diag(covariance))
    score = float((off / scale) @ np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True) @ (off / scale))
    return float(stats.chi2.sf(score, len(at)))
