"""Selection: which units explain the residual better than chance, in the linear picture of a ledger.

Forward one unit at a time, each time looking back whether an earlier one can be exchanged or has become superfluous.
A unit has to beat the noise after correction for all that were tried, and has to improve set-ups that it has not seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.candidates import Unit
from stiffness.diagnosis.linear_fit import Ledger, Linear

Floats = npt.NDArray[np.float64]

CHANCE = 0.01  # that one session of a robot which lacks nothing shows an effect
STEADY = 1.5  # standard errors by which folds left out have to improve on the whole
MOST = 14  # units; a robot that lacks more has to be looked at otherwise
TRIED = 5  # of the best, where the best does not hold on set-ups left out
ROUNDS = 3  # of exchanges per step


@dataclass(frozen=True, repr=False)
class Choice:
    """Units and what they explain together.

    Attributes:
        fit: of all their columns, in order.
        price: chi-square that their numbers cost.
        scale: factor on variances where the noise does not explain what is left.
    """

    units: tuple[Unit, ...]
    fit: Linear
    price: float
    scale: float

    @property
    def worth(self) -> float:
        """Gain above what as many numbers without meaning would cost."""
        return self.fit.gain / self.scale - self.price

    def weights(self, unit: Unit) -> Floats:
        """Weights of one unit's columns."""
        at = 0
        for u in self.units:
            if u is unit:
                return self.fit.weight[at : at + len(u.columns)]
            at += len(u.columns)
        raise ValueError(f"{unit} was not chosen")


class Selector:
    """Compares units on one ledger; ``tried`` counts what chance could have picked from."""

    def __init__(self, ledger: Ledger, units: Sequence[Unit], freedom: float) -> None:
        self.ledger, self.units, self.freedom = ledger, tuple(units), freedom
        self.tried = max(len(self.units), 1)
        self._cost = float(np.log(max(ledger.count, 8)))

    def together(self, units: Sequence[Unit]) -> Choice:
        """Some units, fitted at once."""
        columns = [c for u in units for c in u.columns]
        positive = [p for u in units for p in u.positive]
        fit = self.ledger.fit(columns, positive)
        left = max(self.ledger.all.chi2 - fit.gain, 0.0)
        scale = max(1.0, left / max(self.freedom - fit.rank, 1.0))
        return Choice(tuple(units), fit, self._cost * fit.rank, scale)

    def heldout(self, units: Sequence[Unit]) -> Floats:
        """(folds,) chi-square on set-ups left out."""
        return self.ledger.heldout([c for u in units for c in u.columns], [p for u in units for p in u.positive])

    def ranked(self, chosen: Choice) -> list[Choice]:
        """``chosen`` with one unit more each, those that are worth most first."""
        taken = {u.key for u in chosen.units}
        options = [self.together([*chosen.units, u]) for u in self.units if u.key not in taken]
        # the residual that the best leaves is the yardstick for all
        scale = min((o.scale for o in options), default=1.0)
        return sorted(options, key=lambda o: o.price - o.fit.gain / scale)

    def beats(self, more: Choice, less: Choice) -> bool:
        """Whether ``more`` is better than ``less`` beyond chance, inside the data and outside."""
        drop, numbers = (more.fit.gain - less.fit.gain) / more.scale, max(more.fit.rank - less.fit.rank, 1)
        if stats.chi2.sf(max(drop, 0.0), numbers) * self.tried > CHANCE or more.worth <= less.worth:
            return False
        return steady(self.heldout(less.units) - self.heldout(more.units))

    def forward(self) -> Choice:
        """All units that pay, forward and looking back."""
        chosen = self.together([])
        while len(chosen.units) < MOST:
            more = next((o for o in self.ranked(chosen)[:TRIED] if self.beats(o, chosen)), None)
            if more is None:
                break
            chosen = self._exchanged(more)
        return self._without_superfluous(chosen)

    def _exchanged(self, chosen: Choice) -> Choice:
        """Every unit in turn against the best other in its place."""
        for _ in range(ROUNDS if len(chosen.units) > 1 else 0):
            before = chosen
            for unit in chosen.units:
                rest = self.together([u for u in chosen.units if u is not unit])
                other = self.ranked(rest)[0]
                if other.worth > chosen.worth + 1e-6 * abs(chosen.worth):
                    chosen = other
                    break
            if chosen is before:
                break
        return chosen

    def _without_superfluous(self, chosen: Choice) -> Choice:
        for unit in chosen.units:
            rest = self.together([u for u in chosen.units if u is not unit])
            if not self.beats(chosen, rest):
                return self._without_superfluous(rest)
        return chosen


def steady(gain: Floats) -> bool:
    """Whether folds left out improve: on the whole, and by more than they scatter."""
    error = float(np.std(gain, ddof=1) / np.sqrt(len(gain))) if len(gain) > 1 else np.inf
    return bool(gain.mean() > STEADY * error)
