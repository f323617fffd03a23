"""Selection: stepwise selection of terms in a linearised model.

Forward one term at a time; after every step an earlier term may be exchanged for a better one, and at the end terms
that have become superfluous are removed. A term must be significant after correction for the number of terms that were
tried (Bonferroni), it must lower the Bayesian information criterion (BIC), and it must improve the cross-validated
chi-square.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.candidates import Term
from stiffness.diagnosis.linear_fit import LinearFit, NormalEquations

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/diagnosis/test_selection.py, tests/effects_report
CHANCE = 0.01  # false-positive rate: of one session of a robot to whose model nothing needs to be added
STEADY = 1.5  # standard errors of the mean by which held-out folds have to improve
EVERY = 7  # folds that all gain by chance once in 128 times
CROSSED = 8  # set-ups from which on cross-validation decides too
MOST = 14  # terms
PROMISING = 12  # steps that are fitted together with all that is chosen
TABLED = 2.0  # price of a number of a table
TRIED = 5  # of the best terms, where the best does not improve the cross-validated chi-square
ROUNDS = 3  # of exchanges per step


@dataclass(frozen=True, repr=False)
class Selection:
    """Some terms, fitted together.

    Attributes:
        fit: of all their columns, in order.
        penalty: of the BIC: rank times the logarithm of the number of readings.
        scale: factor on variances where the noise does not explain the residual that is left.
    """

    terms: tuple[Term, ...]
    fit: LinearFit
    penalty: float
    scale: float

    @property
    def bic_gain(self) -> float:
        """How far the terms lower the BIC."""
        return self.fit.gain / self.scale - self.penalty

    def weights(self, term: Term) -> Floats:
        """Weights of one term's columns."""
        at = 0
        for u in self.terms:
            if u is term:
                return self.fit.weight[at : at + len(u.columns)]
            at += len(u.columns)
        raise ValueError(f"{term} was not chosen")


class Selector:
    """Compares terms by the normal equations of one fit, which has ``freedom`` degrees of freedom.

    Args:
        crossed: whether cross-validation decides too: not of a handful of set-ups, where what one of them shows the
            others cannot bear out.
    """

    def __init__(
        self, equations: NormalEquations, terms: Sequence[Term], freedom: float, *, crossed: bool = True
    ) -> None:
        self.equations, self.terms, self.freedom, self.crossed = equations, tuple(terms), freedom, crossed
        self.tried = max(len(self.terms), 1)  # what chance could have picked from
        self._cost = float(np.log(max(equations.count, 8)))

    def together(self, terms: Sequence[Term]) -> Selection:
        """Some terms, fitted at once."""
        columns = [c for u in terms for c in u.columns]
        positive = [p for u in terms for p in u.positive]
        fit = self.equations.fit(columns, positive)
        left = max(self.equations.reduced.chi2 - fit.gain, 0.0)
        scale = max(1.0, left / max(self.freedom - fit.rank, 1.0))
        return Selection(tuple(terms), fit, self._price(terms, fit.rank), scale)

    def cross_validated(self, terms: Sequence[Term]) -> Floats:
        """(folds,) chi-square of every fold, fitted on the others."""
        columns = [c for u in terms for c in u.columns]
        return self.equations.cross_validated(columns, [p for u in terms for p in u.positive])

    def ranked(self, chosen: Selection) -> list[Selection]:
        """``chosen`` with one term more each, those of the lowest BIC first."""
        taken = {u.key for u in chosen.terms}
        options = [self.together([*chosen.terms, *us]) for us in self._promising(chosen, taken)]
        # the residual that the best leaves sets the scale for all
        scale = min((o.scale for o in options), default=1.0)
        return sorted(options, key=lambda o: o.penalty - o.fit.gain / scale)

    def _promising(self, chosen: Selection, taken: set[tuple[str, tuple[str, ...]]]) -> list[tuple[Term, ...]]:
        """The steps that look best when what is chosen keeps its weights' directions: a small fit of each."""
        given = self.equations.given([c for u in chosen.terms for c in u.columns], chosen.fit.weight)
        scored = []
        for step in self._steps(taken):
            columns = [c for u in step for c in u.columns]
            own = self.equations.fit(columns, [p for u in step for p in u.positive], given)
            scored.append((own.gain, self._price(step, own.rank), step))
        left = min((given.chi2 - gain for gain, _, _ in scored), default=0.0)
        scale = max(1.0, left / max(self.freedom, 1.0))
        scored.sort(key=lambda s: s[1] - s[0] / scale)
        return [step for _, _, step in scored[:PROMISING]]

    def _steps(self, taken: set[tuple[str, tuple[str, ...]]]) -> list[tuple[Term, ...]]:
        """Every term that may be added, and tables of one effect in all places at once."""
        free = [u for u in self.terms if u.key not in taken]
        tables: dict[str, list[Term]] = {}
        for u in free:
            if u.tabled:
                tables.setdefault(u.effect.name, []).append(u)
        return [*((u,) for u in free), *(tuple(us) for us in tables.values() if len(us) > 1)]

    def _price(self, terms: Sequence[Term], rank: int) -> float:
        """What numbers cost: the logarithm of the count of readings each (BIC), of tables 2 (AIC, which asks what
        cross-validation asks: Stone, J. R. Statist. Soc. B 39, 1977): their numbers are not free of each other."""
        if not terms:
            return 0.0
        columns = sum(len(u.columns) for u in terms)
        tabled = sum(len(u.columns) for u in terms if u.tabled) / max(columns, 1)
        return rank * (tabled * TABLED + (1 - tabled) * self._cost)

    def beats(self, more: Selection, less: Selection) -> bool:
        """Whether ``more`` is better than ``less``: significantly, by BIC, and in cross-validation."""
        drop, numbers = (more.fit.gain - less.fit.gain) / more.scale, max(more.fit.rank - less.fit.rank, 1)
        if stats.chi2.sf(max(drop, 0.0), numbers) * self.tried > CHANCE or more.bic_gain <= less.bic_gain:
            return False
        return not self.crossed or steady(self.cross_validated(less.terms) - self.cross_validated(more.terms))

    def forward(self) -> Selection:
        """The selected terms."""
        chosen = self.together([])
        while len(chosen.terms) < MOST:
            more = next((o for o in self.ranked(chosen)[:TRIED] if self.beats(o, chosen)), None)
            if more is None:
                break
            chosen = self._exchanged(more)
        return self._without_superfluous(chosen)

    def _exchanged(self, chosen: Selection) -> Selection:
        """With terms exchanged one by one for others that lower the BIC."""
        for _ in range(ROUNDS if len(chosen.terms) > 1 else 0):
            before = chosen
            for term in chosen.terms:
                rest = self.together([u for u in chosen.terms if u is not term])
                other = self.ranked(rest)[0]
                if other.bic_gain > chosen.bic_gain + 1e-6 * abs(chosen.bic_gain):
                    chosen = other
                    break
            if chosen is before:
                break
        return chosen

    def _without_superfluous(self, chosen: Selection) -> Selection:
        for term in chosen.terms:
            rest = self.together([u for u in chosen.terms if u is not term])
            if not self.beats(chosen, rest):
                return self._without_superfluous(rest)
        return chosen


def steady(gain: Floats) -> bool:
    """Whether the gain (folds,) of held-out folds is positive by more than its scatter explains; or in every one of
    them, and twice as clearly without the largest: one that gains far more than the others scatters, and is no doubt.
    """
    if len(gain) >= EVERY and gain.min() > 0 and _clear(np.sort(gain)[:-1], 2 * STEADY):
        return True
    return _clear(gain, STEADY)


def _clear(gain: Floats, errors: float) -> bool:
    """Whether a mean is positive by so many standard errors."""
    error = float(np.std(gain, ddof=1) / np.sqrt(len(gain))) if len(gain) > 1 else np.inf
    return bool(gain.mean() > errors * error)
