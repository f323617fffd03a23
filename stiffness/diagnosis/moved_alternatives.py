"""Alternatives of numbers that have moved: effects that explain the same, the numbers of the model as they were.

A fit takes up with the springs of a model what a trace does not tell from them: on one path the torque of a joint is a
function of its angle, and a joint that is softer, that hardens, or that stands a little aside yields alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.adoption import adopted
from stiffness.diagnosis.alternatives import LINEAR
from stiffness.diagnosis.linearisation import Linearisation
from stiffness.diagnosis.result import MovedParameter
from stiffness.diagnosis.search import ODDS, bic, like_noise, within
from stiffness.diagnosis.selection import CHANCE
from stiffness.identification.fit import Fit
from stiffness.model.model import ComplianceModel
from stiffness.session.session import traces_alone

# studied in tests/traces_report
MOST = 10  # alternatives that are fitted


@dataclass(frozen=True, repr=False, eq=False)
class Imitation:
    """An effect, added to a model whose numbers stay as well as it knows them, and its fit.

    Attributes:
        cost: Bayesian information criterion, what the numbers of the model moved against their deviations included.
    """

    additions: list[Addition]
    fit: Fit
    cost: float

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.additions[0].effect.name


def imitating(fits: ModelFits, model: ComplianceModel, base: Fit) -> list[Imitation]:
    """Effects that explain the readings as well as numbers of the model that have moved do in ``base``, the cheapest
    first.

    They are found with the numbers of the model as they were, or, where its standard deviations leave these open (a
    data sheet), as they fit; and fitted with these held by their standard deviations: no model is without error.

    Args:
        fits: of the model, its numbers free.
    """
    known, names = fits.held_by(model), tuple(e.name for e in fits.base)
    chance = float(stats.chi2.isf(CHANCE, max(len(base.unknowns), 1)))  # what free numbers take up of noise
    start = known.fit([])
    if start.surprise_of(names) < chance:
        linearisation = Linearisation(known)
    else:
        fixed = replace(fits, given=names)
        linearisation, start = Linearisation(fixed), fixed.fit([])
    linear = linearisation.at(start, [])
    gain = linear.fit.solution.chi2 - base.solution.chi2
    found = [s for e in linearisation.effects if (s := within(linear.selector, e)).terms]
    expansion = linear.expansion
    del linear
    near = [s for s in found if s.fit.gain > gain * (1 - LINEAR) - ODDS]
    least = base.solution.chi2 + chance
    out = []
    for chosen in sorted(near, key=lambda s: -s.bic_gain)[:MOST]:
        additions, fit = adopted(known, expansion, chosen, [])
        surprise = fit.surprise_of(names)
        if like_noise(fit) and fit.solution.chi2 + surprise < least:
            out.append(Imitation(additions, fit, bic(fit, 1.0) + surprise))
    return sorted(out, key=lambda i: (i.cost, i.name))


def with_imitations(
    changed: Sequence[MovedParameter], fits: ModelFits, model: ComplianceModel, *, base: Fit, more: Sequence[Addition]
) -> list[MovedParameter]:
    """Numbers that have moved, each with the effects that would move them so; ``more``: those of the process."""
    group = [a.effect.name for a in more]
    if traces_alone(fits.sessions):
        group += [i.name for i in imitating(fits, model, base) if i.name not in group]
    return [replace(c, confused_with=tuple(group)) for c in changed]
