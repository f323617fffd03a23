"""Hidden effects: how far an effect that a model lacks, whichever it is, may have moved the numbers of its fit.

A fit without an effect gives a part of it to the numbers that imitate it best: of a bracket that bends at the flange to
the springs of the wrist, at many of their own standard deviations. How far, the fits with the effects that explain most
of what is left show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.added_effects import ModelFits
from stiffness.diagnosis.adoption import adopted, pruned
from stiffness.diagnosis.linearisation import Expansion
from stiffness.diagnosis.search import Say, Search
from stiffness.diagnosis.selection import Selection
from stiffness.identification.coherence import hidden_bias
from stiffness.identification.fit import CLEAR, Fit
from stiffness.numerics.least_squares import ROUGH
from stiffness.session.session import traces_alone

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class Look:
    """What a first look at the catalogue says of a fit: where the ways of a ``search`` begin, from ``start``."""

    search: Search
    start: Expansion
    beginnings: Sequence[Selection]

    @classmethod
    def of(cls, fit: Fit, say: Say) -> Look:
        """At a fit of all effects that its sessions show by themselves."""
        sessions, values = [s.session for s in fit.sessions], fit.values()
        whole = ModelFits.of(sessions, fit.unknowns.effects, values, [s.used for s in fit.sessions])
        fits = replace(whole, ending=ROUGH)
        if traces_alone(sessions):
            # of the geometry a trace determines a part; the rest must not imitate, far out, what the model still lacks
            drawing = {e.name: fit.fixed[e.name] for e in fit.unknowns.effects if e.unloaded}
            fits = replace(fits, values={**values, **drawing}, widened=fit.solution.misfit)
        search = Search(fits, (), say)
        linear = search.linearisation.at(fits.fit([]), [])
        return cls(search, linear.expansion, search.beginnings(linear))

    def explained(self) -> list[Fit]:
        """Fits with the effect of every beginning; once one leaves noise, of those that promise to."""
        out, before = list[Fit](), self.start.fit.solution
        for chosen in self.beginnings:
            promised = before.chi2 - chosen.fit.gain
            if promised < CLEAR**2 * before.freedom or all(f.lacks for f in out):
                fits = self.search.fits
                out.append(pruned(fits, *adopted(fits, self.start, chosen, []))[1])
        return out


def may_hide(fit: Fit) -> bool:
    """Whether a fit lacks something, of sessions whose effects can be told by a first look: not of traces alone."""
    return bool(fit.lacks) and not traces_alone([s.session for s in fit.sessions])


def with_hidden(fit: Fit, others: Sequence[Fit]) -> Fit:
    """A fit that knows how far what it lacks may have moved its numbers: as far as those of the farthest of others,
    with their standard deviations and what the best still lacks; one that lacks nothing has refuted those that do."""
    if not others or not may_hide(fit):
        return fit
    best = min(others, key=lambda f: f.solution.chi2)
    rest = _as_in(fit, best, hidden_bias(best.solution, best.sessions)) if best.lacks else 0.0
    alike = [f for f in others if best.lacks or not f.lacks]
    moved = [np.hypot(_as_in(fit, f, f.parameters) - fit.parameters, _as_in(fit, f, f.sd)) for f in alike]
    return replace(fit, hidden=np.hypot(np.max(moved, axis=0), rest))


def _as_in(fit: Fit, other: Fit, numbers: Floats) -> Floats:
    """(P,) numbers of another fit in the order of this one; 0 for what it has not."""
    own = zip(other.unknowns.free, numbers[: len(other.unknowns)], strict=True)
    place = {(u.effect, u.parameter.name, u.index): v for u, v in own}
    return np.array([place.get((u.effect, u.parameter.name, u.index), 0.0) for u in fit.unknowns.free])
