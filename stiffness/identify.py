"""Identify: a stiffness model from measurement sessions.

What every model has is fitted to all readings. Effects that the approach to a set-up brings about (a gap, a softer
flank) are added where the search of a diagnosis finds them, against all other effects of the catalogue: so they never
stand in for something else. What the data do not determine is reported as such.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition, at_values_of
from stiffness.diagnosis.alternatives import with_alternatives
from stiffness.diagnosis.hidden_effects import Look, may_hide, with_hidden
from stiffness.diagnosis.searched_numbers import searched_deviations, with_final_numbers, with_middles
from stiffness.diagnosis.structure import standing
from stiffness.effects import CATALOGUE
from stiffness.errors import StiffnessError
from stiffness.identification.fit import Fit
from stiffness.identification.outliers import odd_states, reconsidered
from stiffness.identification.plausibility import doubts
from stiffness.identification.registration import with_registration
from stiffness.identification.robust import named_effects, one_robot, robust_fit
from stiffness.identification.settled import settled
from stiffness.model.model import ComplianceModel
from stiffness.session.processes import in_words, of_one_process, process_of
from stiffness.session.session import Session

Say = Callable[[str], None]


def identify(
    sessions: Sequence[Session],
    effects: Sequence[str] | None = None,
    prior: ComplianceModel | None = None,
    say: Say = lambda text: None,
) -> Fit:
    """Fit a model to sessions of one robot.

    Args:
        effects: names that fix the set; None: joint stiffness, kinematic offsets where absolute positions tell
            of them, and backlash or preload softening where the data ask for it.
        prior: values to start from; its standard deviations are prior knowledge.
        say: reports progress.

    Raises:
        StiffnessError: the sessions are not of one robot, or nothing in them can be fitted.
    """
    one_robot(sessions)
    sessions = of_one_process(sessions, () if prior is None else prior.processes.values())
    if effects is not None:
        return _finished(_told(sessions, effects, prior))
    there = {
        "load": any(s.has_displacement for s in sessions) or _sag(sessions),
        "position": any(s.has_absolute for s in sessions),
    }
    names = [e.name for e in CATALOGUE if there.get(e.fitted_where, False)]
    if prior is not None:  # what is known of the robot stays in its model
        cut = process_of(sessions)
        kept = [e for e in prior.effects if e.scope not in ("instruments", "process") or prior.of_process(e, cut)]
        names += [e.name for e in kept if e.name not in names]
    if not names:
        raise StiffnessError(
            f"{sessions[0].source}: nothing to identify: no loaded state beside an unloaded one, and the positions "
            "only place the tracker and its reflectors"
        )
    fit = robust_fit(sessions, named_effects(names), prior)
    found = _finished(_with_memory(sessions, names=names, fit=fit, prior=prior, say=say))
    return replace(found, notes=(*found.notes, *_left_out(sessions, prior)))


def _left_out(sessions: Sequence[Session], prior: ComplianceModel | None) -> list[str]:
    """Notes on effects of the process that a prior has for another material or cutter than what was traced."""
    cut, others = process_of(sessions), [] if prior is None else [e for e in prior.effects if e.scope == "process"]
    return [
        f"{e.name} of {prior.source} is of {in_words(prior.processes.get(e.name, ('', '')))} and not of "
        f"{in_words(cut)}: it takes no part, and is not in this model"
        for e in others
        if prior is not None and not prior.of_process(e, cut)
    ]


def _finished(fit: Fit) -> Fit:
    """Of all solutions alike the one to give, and what is doubtful in it; comparisons of chi-square are over."""
    fit, chosen = settled(with_registration(fit))
    return replace(fit, notes=(*fit.notes, *chosen, *odd_states(fit), *doubts(fit)))


def _sag(sessions: Sequence[Session]) -> bool:
    return any(s.gravity == "uncompensated" and s.has_absolute for s in sessions)


def _with_memory(
    sessions: Sequence[Session], names: list[str], fit: Fit, prior: ComplianceModel | None, say: Say
) -> Fit:
    """Add what depends on the approach where the approach is known and a search over the catalogue finds it."""
    if not any(np.any(s.samples.approach != 0) for s in sessions):
        return with_hidden(fit, Look.of(fit, say).explained()) if may_hide(fit) else fit
    if not any(_load_levels(s) > 1 for s in sessions):
        note = "one load level: a gap between flanks and a softer flank cannot be told apart"
        fit = replace(fit, notes=(*fit.notes, note))
    look = Look.of(fit, say)
    found, alike, best = _found(look)
    if not found:
        return with_hidden(fit, [best] if best else look.explained() if may_hide(fit) else [])
    every = named_effects([*names, *(a.effect.name for a in found)])
    trial = robust_fit(sessions, effects=every, prior=prior, used=[s.used for s in fit.sessions], only=found)
    found, trial = _numbers_searched(sessions, found, fit=trial, prior=prior)
    notes = tuple(_note(a, fit, trial, alike.get(a.effect.name, ())) for a in found)
    last = reconsidered(replace(trial, notes=(*fit.notes, *notes)))
    last = with_middles(last, at_values_of(last, found))
    last = replace(last, searched_sd=searched_deviations(last, at_values_of(last, found)))
    return with_hidden(last, [best] if best else [])


def _told(sessions: Sequence[Session], effects: Sequence[str], prior: ComplianceModel | None) -> Fit:
    """Effects that the user names; what shapes the memory of their joints is searched where no prior has it."""
    fit = robust_fit(sessions, named_effects(effects), prior)
    known, joints, values = () if prior is None else prior.effects, fit.unknowns.joints, fit.values()
    told = [
        Addition(e, sites, frozenset(sites), values[e.name])
        for e in fit.unknowns.effects
        if e.memory and e not in known and (sites := e.sites(joints))
    ]
    if not told:
        return fit
    told, fit = _numbers_searched(sessions, told, fit=fit, prior=prior)
    return replace(fit, searched_sd=searched_deviations(fit, at_values_of(fit, told)))


def _numbers_searched(
    sessions: Sequence[Session], found: list[Addition], *, fit: Fit, prior: ComplianceModel | None
) -> tuple[list[Addition], Fit]:
    """Additions of a fit and the fit, with better numbers where no derivative leads to them."""
    moved = with_final_numbers(fit, at_values_of(fit, found))
    if moved is None:
        return found, fit
    used = [s.used for s in fit.sessions]
    return moved, robust_fit(sessions, effects=fit.unknowns.effects, prior=prior, used=used, only=moved)


def _load_levels(session: Session) -> int:
    """How many sizes of wrench a session has, apart by a third at least."""
    size = np.linalg.norm(session.samples.load.wrench[:, :3], axis=1)
    loaded = np.sort(size[size > 0.1 * size.max()]) if size.any() else np.empty(0)
    return 0 if not len(loaded) else 1 + int(loaded[-1] > 1.3 * loaded[0])


def _found(look: Look) -> tuple[list[Addition], dict[str, tuple[str, ...]], Fit | None]:
    """What of the approach's effects a search adds to a fit, the names of those that cannot be told from each, and the
    fit with all that it finds; None where it was not gone."""
    search, start = look.search, look.start
    if not any(t.effect.fitted_where == "approach" for chosen in look.beginnings for t in chosen.terms):
        return [], {}, None
    best, additions = search.run(start, look.beginnings)
    if not any(a.effect.fitted_where == "approach" for a in additions):
        return [], {}, best
    best, additions, found = with_alternatives(search, best, additions, start.fit)
    stand = standing(search, base=start.fit, fit=best, additions=additions, found=found).additions
    own = [a for a in stand if a.effect.fitted_where == "approach"]
    return own, {r.addition.effect.name: tuple(r.fits) for r in found}, best


def _note(a: Addition, before: Fit, after: Fit, alike: Sequence[str]) -> str:
    drop, numbers = before.solution.chi2 - after.solution.chi2, len(after.unknowns) - len(before.unknowns)
    text = f"{a.effect.name} in {', '.join(a.where)}: chi-square falls by {drop:.0f} for {numbers} numbers"
    return f"{text}; these readings cannot tell it from {', '.join(alike)}" if alike else text
