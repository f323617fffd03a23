"""Last fit: what is written in the end, from all readings, those included that judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.refined_model import refined_model
from stiffness.diagnosis.regrouped import regrouped
from stiffness.diagnosis.result import RemovedEffect
from stiffness.diagnosis.searched_numbers import searched_deviations, with_final_numbers
from stiffness.identification.fit import Fit
from stiffness.identification.outliers import cleaned, with_whole_setups
from stiffness.identification.registration import with_registration
from stiffness.identification.settled import settled
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import EXACT, ROUGH


@dataclass(frozen=True, repr=False, eq=False)
class LastFit:
    """A fit of all readings, to the end.

    Attributes:
        fit: whose standard deviations hold. allowed: the same within the limits of its effects.
        additions: with the numbers that were searched.
        chosen: what only a gauge tells, in words. together: what the readings know together only, in words.
    """

    fit: Fit
    allowed: Fit
    additions: Sequence[Addition]
    chosen: tuple[str, ...]
    together: tuple[str, ...]

    def model(self, before: ComplianceModel, removed: Sequence[RemovedEffect]) -> ComplianceModel:
        """The refined model."""
        gone = [r.effect for r in removed]
        return refined_model(before, fit=self.allowed, free=self.fit, additions=self.additions, removed=gone)


def last_fit(fits: ModelFits, fit: Fit, additions: Sequence[Addition], news: Sequence[Addition]) -> LastFit:
    """The fit of all readings that ``fit``, of some of them, leads to.

    Args:
        news: those of ``additions`` that the model at hand does not have.
    """
    whole, last = of_all_readings(replace(fits, ending=EXACT), additions, fit)
    final = with_final_numbers(last, additions)
    if final is not None:
        additions, last = final, whole.fit(final, last)
    last, chosen = settled(with_registration(last))
    together = tuple(map(str, regrouped(last, [a.effect.name for a in news])))
    last = replace(last, searched_sd=searched_deviations(last, additions))
    allowed, chosen = _allowed(whole, last, additions, chosen)
    return LastFit(last, allowed=allowed, additions=additions, chosen=chosen, together=together)


def of_all_readings(fits: ModelFits, additions: Sequence[Addition], start: Fit) -> tuple[ModelFits, Fit]:
    """Fits, from here on, of all readings but those that the others contradict, and the fit of these."""
    every = tuple(np.ones_like(used) for used in fits.used)
    return without_outliers(replace(fits, used=every, allowed=every), additions, start)


def without_outliers(fits: ModelFits, additions: Sequence[Addition], start: Fit | None = None) -> tuple[ModelFits, Fit]:
    """Fits, from here on, without the rows that the others contradict, and the fit without them."""
    clean = cleaned(replace(fits, ending=ROUGH).fit(additions, start), ROUGH)
    fits = replace(fits, used=with_whole_setups(clean))
    return fits, fits.fit(additions, clean)


def _allowed(
    fits: ModelFits, fit: Fit, additions: Sequence[Addition], chosen: tuple[str, ...]
) -> tuple[Fit, tuple[str, ...]]:
    """A settled fit within the limits of its effects, and what was ``chosen`` in it."""
    allowed = fits.within_limits(fit, additions)
    if allowed is fit:
        return fit, chosen
    again, chosen = settled(with_registration(allowed))  # what was fitted again is free again
    return (again, chosen) if fits.within_limits(again, additions) is again else (allowed, ())
