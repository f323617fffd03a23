"""Selection: which terms explain the residual better than chance, in the linear picture of a ledger.

Forward one term at a time, each time looking back whether an earlier one can be exchanged or has become superfluous.
A term has to beat the noise after correction for all that were tried, and has to improve set-ups that it has not seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.candidates import Term
from stiffness.diagnosis.linear_fit import Ledger, Linear

Floats = npt.NDArray[np.float64]

CHANCE = 0.01  # that one session of a robot which lacks nothing shows an effect
STEADY = 1.5  # standard errors by which folds left out have to improve on the whole
MOST = 14  # terms; a robot that lacks more has to be looked at otherwise
TRIED = 5  # of the best, where the best does not hold on set-ups left out
ROUNDS = 3  # of exchanges per step


@dataclass(frozen=True, repr=False)
class Choice:
    """Terms and what they explain together.

    Attributes:
        fit: of all their columns, in order.
        price: chi-square that their numbers cost.
        scale: factor on variances where the noise does not explain what is left.
    """

    terms: tuple[Term, ...]
    fit: Linear
    price: float
    scale: float

    @property
    def worth(self) -> float:
        """Gain above what as many numbers without meaning would cost."""
        return self.fit.gain / self.scale - self.price

    def weights(self, term: Term) -> Floats:
        """Weights of one term's columns."""
        at = 0
        for u in self.terms:
            if u is term:
                return self.fit.weight[at : at + len(u.columns)]
            at += len(u.columns)
        raise ValueError(f"{term} was not chosen")


class Selector:
    """Compares terms on one ledger; ``tried`` counts what chance could have picked from."""

    def __init__(self, ledger: Ledger, terms: Sequence[Term], freedom: float) -> None:
        self.ledger, self.terms, self.freedom = ledger, tuple(terms), freedom
        self.tried = max(len(self.terms), 1)
        self._cost = float(np.log(max(ledger.count, 8)))

    def together(self, terms: Sequence[Term]) -> Choice:
        """Some terms, fitted at once."""
        columns = [c for u in terms for c in u.columns]
        positive = [p for u in terms for p in u.positive]
        fit = self.ledger.fit(columns, positive)
        left = max(self.ledger.all.chi2 - fit.gain, 0.0)
        scale = max(1.0, left / max(self.freedom - fit.rank, 1.0))
        return Choice(tuple(terms), fit, self._cost * fit.rank, scale)

    def heldout(self, terms: Sequence[Term]) -> Floats:
        """(folds,) chi-square on set-ups left out."""
        return self.ledger.heldout([c for u in terms for c in u.columns], [p for u in terms for p in u.positive])

    def ranked(self, chosen: Choice) -> list[Choice]:
        """``chosen`` with one term more each, those that are worth most first."""
        taken = {u.key for u in chosen.terms}
        options = [self.together([*chosen.terms, u]) for u in self.terms if u.key not in taken]
        # the residual that the best leaves is the yardstick for all
        scale = min((o.scale for o in options), default=1.0)
        return sorted(options, key=lambda o: o.price - o.fit.gain / scale)

    def beats(self, more: Choice, less: Choice) -> bool:
        """Whether ``more`` is better than ``less`` beyond chance, inside the data and outside."""
        drop, numbers = (more.fit.gain - less.fit.gain) / more.scale, max(more.fit.rank - less.fit.rank, 1)
        if stats.chi2.sf(max(drop, 0.0), numbers) * self.tried > CHANCE or more.worth <= less.worth:
            return False
        return steady(self.heldout(less.terms) - self.heldout(more.terms))

    def forward(self) -> Choice:
        """All terms that pay, forward and looking back."""
        chosen = self.together([])
        while len(chosen.terms) < MOST:
            more = next((o for o in self.ranked(chosen)[:TRIED] if self.beats(o, chosen)), None)
            if more is None:
                break
            chosen = self._exchanged(more)
        return self._without_superfluous(chosen)

    def _exchanged(self, chosen: Choice) -> Choice:
        """Every term in turn against the best other in its place."""
        for _ in range(ROUNDS if len(chosen.terms) > 1 else 0):
            before = chosen
            for term in chosen.terms:
                rest = self.together([u for u in chosen.terms if u is not term])
                other = self.ranked(rest)[0]
                if other.worth > chosen.worth + 1e-6 * abs(chosen.worth):
                    chosen = other
                    break
            if chosen is before:
                break
        return chosen

    def _without_superfluous(self, chosen: Choice) -> Choice:
        for term in chosen.terms:
            rest = self.together([u for u in chosen.terms if u is not term])
            if not self.beats(chosen, rest):
                return self._without_superfluous(rest)
        return chosen


def steady(gain: Floats) -> bool:
    """Whether folds left out improve: on the whole, and by more than they scatter."""
    error = float(np.std(gain, ddof=1) / np.sqrt(len(gain))) if len(gain) > 1 else np.inf
    return bool(gain.mean() > STEADY * error)
