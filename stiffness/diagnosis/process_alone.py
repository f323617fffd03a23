"""Process alone: whether a process that is not what it was said to be explains traces of a cut, the robot as it was.

The deflection of an arm that is softer by a third, and that of a cut which pushes harder by as much, are the same. A
fit of the model's own numbers takes up all of it; so the other explanation is fitted by itself, and compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.linearisation import can_show
from stiffness.diagnosis.search import NOTICED, ODDS, bic
from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect
from stiffness.identification.fit import CLEAR, Fit
from stiffness.model.model import ComplianceModel


@dataclass(frozen=True, repr=False, eq=False)
class ProcessAlone:
    """Effects of the process on a robot whose numbers stay as well as the model knows them.

    Attributes:
        fits: with all numbers of the model held by their standard deviations.
        additions, fit: what explains the readings.
        better: whether this takes fewer numbers than those of the robot that would have to move.
        without: the fit without them.
    """

    fits: ModelFits
    additions: list[Addition]
    fit: Fit
    better: bool
    without: Fit

    @property
    def cost(self) -> float:
        """As of an ``Imitation``."""
        return bic(self.fit, 1.0) + self._surprise(self.fit)

    def explained(self, fit: Fit) -> float:
        """Fraction of the chi-square above the noise that a fit takes away."""
        left = self.without.solution.chi2 + self._surprise(self.without)
        above = max(left - self.without.solution.freedom, 1e-9)
        return float(np.clip((left - fit.solution.chi2) / above, 0, 1))

    def _surprise(self, fit: Fit) -> float:
        return fit.surprise_of(e.name for e in self.fits.base)


def process_alone(fits: ModelFits, model: ComplianceModel, base: Fit, moved: int) -> ProcessAlone | None:
    """The fewest effects of the process that leave no more than a fit of the robot's numbers; None where none do.

    They are chosen with the numbers of the robot held by their standard deviations: what these leave open would be
    taken for a force.

    Args:
        base: the model's own numbers fitted. moved: how many of them that takes.
    """
    effects = [e for e in CATALOGUE if e.scope == "process" and e not in fits.base and can_show(e, fits.sessions)]
    if not effects:
        return None
    held = fits.held_by(model)
    names = [e.name for e in fits.base]
    before = held.fit([])
    left = before.solution.chi2 + before.surprise_of(names)
    if stats.chi2.sf(left, max(before.solution.freedom + len(before.unknowns), 1.0)) > NOTICED:
        return None
    price = float(np.log(max(base.solution.count, 8)))
    least, kept = base.solution.chi2 + len(base.unknowns) * price + ODDS, None
    for some in _combinations(effects):
        additions = [_everywhere(e, fits.joints) for e in some]
        trial = held.fit(additions, before)
        numbers = sum(len(a.numbers(fits.joints)) for a in additions)
        cost = trial.solution.chi2 + trial.surprise_of(names) + numbers * price
        if trial.solution.misfit < CLEAR and cost < least:
            least, kept = cost, (additions, trial)
    if kept is None:
        return None
    additions, fit = kept
    better = least < base.solution.chi2 + max(moved, 1) * price
    return ProcessAlone(fits=held, additions=additions, fit=fit, better=better, without=before)


def _combinations(effects: Sequence[Effect]) -> list[tuple[Effect, ...]]:
    return [some for k in range(1, len(effects) + 1) for some in combinations(effects, k)]


def _everywhere(effect: Effect, joints: int) -> Addition:
    return Addition(effect, effect.sites(joints), frozenset(), effect.neutral(joints))
