"""Search: which effects of the catalogue a model lacks, on readings that may take part.

Terms are selected in the model linearised at a fit, then fitted with the full model, and linearised again at that fit,
until nothing pays. One way through the terms may end in a corner; so the search goes several: from every effect that
explains much by itself, at all of its places, from the term that explains most, and from what the model already had.
Of the ends that the data cannot tell apart, the one with the fewest kinds of effects is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.adoption import adopted, better, pruned
from stiffness.diagnosis.linearisation import Expansion, Linearisation, Linearised
from stiffness.diagnosis.selection import Selection, Selector
from stiffness.diagnosis.sensitivities import Sensitivities
from stiffness.effects.effect import Effect, Site
from stiffness.identification.fit import Fit

Floats = npt.NDArray[np.float64]
Say = Callable[[str], None]

# studied in tests/stiffness/diagnosis/test_search.py, tests/effects_report
ROUNDS = 4  # of linearisation and fit
SINGLE = 3  # effects that a way begins with
MUCH = 0.5  # of what the best single effect explains: a way begins with no effect that explains less
ODDS = 10.0  # difference of BIC, twice the logarithm of the odds, from which one explanation is preferred
NOTICED = 1e-4  # chance of a residual that noise alone would leave
HOPELESS = 10.0  # of the chi-square that an earlier way left
MOST_SITES = 8


@dataclass(frozen=True, repr=False, eq=False)
class End:
    """Where one way of a search ends."""

    fit: Fit
    additions: list[Addition]


@dataclass(frozen=True, repr=False, eq=False)
class Search:
    """One search: ``fits`` of the model that effects are added to; ``known``: effects that the model at hand has
    beside it, with its values; ``say`` reports progress."""

    fits: ModelFits
    known: tuple[Addition, ...]
    say: Say

    @cached_property
    def linearisation(self) -> Linearisation:
        """Of the model, with all effects that it lacks."""
        return Linearisation(self.fits)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects that the model lacks and the sessions could show."""
        return self.linearisation.effects

    @property
    def sensitivities(self) -> tuple[Sensitivities, ...]:
        """Of every session."""
        return self.linearisation.sensitivities

    def run(self, start: Expansion, beginnings: Sequence[Selection]) -> tuple[Fit, list[Addition]]:
        """From a fit of the model to one that lacks nothing the data can show."""
        ends = [End(start.fit, [])]
        for k, chosen in enumerate(beginnings):
            if _hopeless(chosen, start, ends):
                continue
            self.say(f"{20 + 10 * k} %: from {chosen.terms[0].effect.name}")
            ends.append(self._grown(start, chosen, []))
            if self._plain(ends[-1]):
                break
        if self.known and not self._plain(ends[-1]):
            self.say("60 %: from what the model has")
            ends.append(self._from_known(start.fit))
        best = preferred(ends)
        return best.fit, best.additions

    def _plain(self, end: End) -> bool:
        """Whether one kind of effect explains all: no other way can end with fewer."""
        return len(end.additions) == 1 and like_noise(end.fit)

    def beginnings(self, linear: Linearised) -> list[Selection]:
        """Where ways begin: with effects that explain much by themselves, then with terms of any effect."""
        greedy = linear.selector.forward()
        if not greedy.terms:
            return []
        alone = [s for e in self.effects if (s := within(linear.selector, e)).terms]
        alone.sort(key=lambda s: -s.bic_gain)
        out = [s for s in alone[:SINGLE] if s.fit.gain > MUCH * alone[0].fit.gain]
        # a way from some sites of one effect ends where that from all of them does
        return out if any(_keys(greedy) <= _keys(s) for s in out) else [*out, greedy]

    def _grown(self, start: Expansion, chosen: Selection, additions: Sequence[Addition]) -> End:
        """A beginning fitted, and terms added as long as they pay."""
        fit, now = start.fit, list(additions)
        for round_ in range(ROUNDS):
            more, trial = adopted(self.fits, start, chosen, now)
            kept, trial = pruned(self.fits, more, trial)
            self.say(f"round {round_ + 1}: " + ", ".join(f"{a.effect.name} ({' '.join(a.where)})" for a in kept))
            if not better(trial, fit):
                break
            same = _layout(kept) == _layout(now)
            fit, now = trial, kept
            if same or round_ == ROUNDS - 1:
                break
            start, chosen = self._looked(fit, now)
            fit = start.fit
            if not chosen.terms:
                break
        return End(fit, now)

    def _from_known(self, base: Fit) -> End:
        """What the model at hand had, fitted, without what is superfluous, and what pays beside it."""
        known, fit = pruned(self.fits, list(self.known), self.fits.fit(list(self.known), base))
        start, chosen = self._looked(fit, known)
        return self._grown(start, chosen, known) if chosen.terms else End(start.fit, known)

    def _looked(self, fit: Fit, additions: Sequence[Addition]) -> tuple[Expansion, Selection]:
        """The terms that pay beside additions, and where the model was linearised."""
        linear = self.linearisation.at(fit, additions)
        return linear.expansion, linear.selector.forward()


def _hopeless(chosen: Selection, start: Expansion, ends: Sequence[End]) -> bool:
    """Whether a beginning promises to leave far more than where an earlier way ended, which noise is far from too."""
    promised = start.fit.solution.chi2 - chosen.fit.gain
    best = min(e.fit.solution.chi2 for e in ends)
    return promised > HOPELESS * best and not any(like_noise(e.fit) for e in ends)


def _keys(chosen: Selection) -> set[tuple[str, tuple[str, ...]]]:
    return {t.key for t in chosen.terms}


def _layout(additions: Sequence[Addition]) -> set[tuple[object, ...]]:
    return {(a.effect.name, a.sites, a.extras) for a in additions}


def within(selector: Selector, effect: Effect, site: Site | None = None) -> Selection:
    """The sites of one effect, or the one ``site``, that lower the BIC, one after the other."""
    terms = [t for t in selector.terms if t.effect is effect and site in (None, t.site)]
    own = Selector(selector.equations, terms, selector.freedom, crossed=selector.crossed)
    chosen = own.together([])
    while len(chosen.terms) < MOST_SITES:
        ranked = own.ranked(chosen)
        if not ranked or ranked[0].bic_gain <= chosen.bic_gain:
            break
        chosen = ranked[0]
    return chosen


def preferred(ends: Sequence[End]) -> End:
    """The end of the lowest BIC; another kind of effect has to be worth ODDS."""
    misfit = min(e.fit.solution.misfit for e in ends)
    return min(ends, key=lambda e: bic(e.fit, misfit) + ODDS * len(e.additions))


def bic(fit: Fit, misfit: float) -> float:
    """Bayesian information criterion, with the noise widened by ``misfit``; of numbers that share a prior those count
    that the data determine."""
    solution = fit.solution
    return solution.chi2 / misfit**2 + (solution.count - solution.freedom) * float(np.log(solution.count))


def like_noise(fit: Fit) -> bool:
    """Whether noise alone would leave such a residual."""
    return bool(stats.chi2.sf(fit.solution.chi2, max(fit.solution.freedom, 1.0)) > NOTICED)
