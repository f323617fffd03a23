"""Alternatives of numbers that have moved: effects that explain the same, the numbers of the model as they were.

A fit takes up with the springs of a model what a trace does not tell from them: on one path the torque of a joint is a
function of its angle, and a joint that is softer, that hardens, or that stands a little aside yields alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.adoption import adopted
from stiffness.diagnosis.alternatives import LINEAR
from stiffness.diagnosis.linearisation import Linearisation
from stiffness.diagnosis.result import MovedParameter
from stiffness.diagnosis.search import ODDS, bic, like_noise, within
from stiffness.identification.fit import Fit
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

# studied in tests/traces_report
MOST = 10  # alternatives that are fitted


def imitating(fits: ModelFits, model: ComplianceModel, base: Fit) -> tuple[str, ...]:
    """Effects that explain the readings as well as numbers of the model that have moved do in ``base``, the fewest
    numbers first.

    They are found with the numbers of the model as they were, and fitted with these held by their standard deviations:
    a model is not known without error.

    Args:
        fits: of the model, its numbers free.
    """
    held = replace(fits, given=tuple(e.name for e in fits.base))
    known = fits.held_by(model)
    linearisation = Linearisation(held)
    linear = linearisation.at(held.fit([]), [])
    gain = linear.fit.solution.chi2 - base.solution.chi2
    found = [s for e in linearisation.effects if (s := within(linear.selector, e)).terms]
    near = [s for s in found if s.fit.gain > gain * (1 - LINEAR) - ODDS]
    # numbers that are free take up so much noise
    least = base.solution.chi2 + len(base.unknowns) + ODDS
    out = []
    for chosen in sorted(near, key=lambda s: -s.bic_gain)[:MOST]:
        _, fit = adopted(known, linear, chosen, [])
        surprise = fit.surprise_of(e.name for e in fits.base)
        if like_noise(fit) and fit.solution.chi2 + surprise < least:
            out.append((bic(fit, 1.0), chosen.terms[0].effect.name))
    return tuple(name for _, name in sorted(out))


def traces_alone(sessions: Sequence[Session]) -> bool:
    """Whether there are traces and no session of set-ups."""
    return all(s.path is not None for s in sessions)


def with_imitations(
    changed: Sequence[MovedParameter], fits: ModelFits, model: ComplianceModel, *, base: Fit, more: Sequence[Addition]
) -> list[MovedParameter]:
    """Numbers that have moved, each with the effects that would move them so; ``more``: those of the process."""
    group = [a.effect.name for a in more]
    if traces_alone(fits.sessions):
        group += [name for name in imitating(fits, model, base) if name not in group]
    return [replace(c, confused_with=tuple(group)) for c in changed]
