"""Diagnose: find what a model lacks in measured data, add it, and score the result on readings that took no part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition, ModelFits, at_values_of
from stiffness.diagnosis.adoption import with_richer_forms
from stiffness.diagnosis.alternatives import Alternatives, candidates, explained_at_last, with_alternatives
from stiffness.diagnosis.attribution import ResidualSource
from stiffness.diagnosis.held_out import held_out, held_out_scores
from stiffness.diagnosis.known_effects import KnownEffects, with_known
from stiffness.diagnosis.last_fit import last_fit, without_outliers
from stiffness.diagnosis.moved_alternatives import Imitation, imitating, with_imitations
from stiffness.diagnosis.moved_parameters import moved_parameters
from stiffness.diagnosis.next_traces import next_traces
from stiffness.diagnosis.process_alone import ProcessAlone, process_alone
from stiffness.diagnosis.refined_model import given_way
from stiffness.diagnosis.reported import added_effect, contradicted, worse
from stiffness.diagnosis.result import Candidate, Diagnosis, MovedParameter, RemovedEffect, Verdict
from stiffness.diagnosis.search import Search, like_noise
from stiffness.diagnosis.structure import Judged, Structure, judged, without_crumbs
from stiffness.diagnosis.told_approaches import with_told_approaches
from stiffness.errors import StiffnessError
from stiffness.identification.evaluate import shown_effects
from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.outliers import odd_states
from stiffness.identification.registration import with_registration
from stiffness.identification.robust import one_robot
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import EXACT, ROUGH
from stiffness.planning.next_setups import NextSetup, splitting, spread
from stiffness.session.processes import of_one_process
from stiffness.session.repeats import with_repeats
from stiffness.session.session import Session, traces_alone

ENOUGH = 6  # set-ups: one per joint
Say = Callable[[str], None]


def diagnose(sessions: Sequence[Session], model: ComplianceModel, say: Say = lambda text: None) -> Diagnosis:
    """Compare sessions of one robot with a model.

    Raises:
        StiffnessError: the sessions are not of one robot, or not of the kind the model was made with.
    """
    one_robot(sessions)
    sessions = of_one_process(sessions, model.processes.values())
    for s in sessions:
        if s.gravity != model.gravity:
            raise StiffnessError(
                f"{s.source}: gravity = {s.gravity!r}, but the model {model.source} was made with {model.gravity!r}: "
                "what its stiffness carries is not the same"
            )
    pairs = [with_repeats(s) for s in sessions]
    notes = [f"{s.source}: {found.sentence}" for s, (_, found) in zip(sessions, pairs, strict=True) if found.sentence]
    return with_told_approaches(
        _diagnosed(tuple(session for session, _ in pairs), model, say, notes),
        lambda told, note: _diagnosed(told, model, say, [*notes, note]),
        say,
    )


@dataclass(frozen=True, repr=False, eq=False)
class _Found:
    """What the search brought.

    Attributes:
        ranking: every effect by itself; ``base_rms``: m, of the model at hand, None where it was not scored.
        alternatives: of the additions that stand. removed: effects of the model at hand that do not.
    """

    judged: Judged
    alternatives: tuple[Alternatives, ...] = ()
    ranking: tuple[Candidate, ...] = ()
    base_rms: float | None = None
    removed: tuple[RemovedEffect, ...] = ()


def _diagnosed(sessions: tuple[Session, ...], model: ComplianceModel, say: Say, notes: Sequence[str]) -> Diagnosis:
    effects = shown_effects(model, *sessions)
    values = {e.name: model.values[e.name] for e in effects}
    held = [held_out(s) for s in sessions]
    fits = ModelFits.of(sessions, effects, values, [~h for h in held])
    say("0 %: fitting the model's own parameters")
    fits, base = without_outliers(fits, [])
    enough = sum(len(np.unique(s.samples.setup)) for s in sessions) >= ENOUGH
    own = KnownEffects.of(model, effects, sessions)
    bare = replace(fits, base=own.base, given=own.given, ending=ROUGH)
    alone = _alone(bare, model, base) if enough and not own.known else None
    if alone is not None and alone.better:
        say("70 %: looking for what else would explain it")
        bare, found = alone.fits, _of_process(alone, base, imitating(fits, model, base))
    else:
        found = _searched(Search(bare, own.known, say), base) if enough else _as_it_is(base, own.known)
    additions, structure = found.judged.additions, found.judged.structure
    fit = with_registration(found.judged.fit)  # effects have been compared: readings held out count from that frame
    news = [a for a in (_new(a, own.known) for a in additions) if a is not None]
    # structure that no effect explains biases the model's own numbers: none of them is reported as moved
    known = enough and not structure.left
    known &= alone is None or not alone.better
    changed = moved_parameters(fits=fits, model=model, base=base, fit=fit, additions=news) if known else []
    if changed and not news:
        say("85 %: looking for what else would move these numbers so")
        changed = with_imitations(changed, fits, model, base=base, more=() if alone is None else alone.additions)
    if known and len(news) == 1 and traces_alone(sessions):
        say("85 %: looking for what else would explain all of it")
        found = _grouped(found, news[0].effect.name, imitating(fits, model, fit))
    other = bool(news or found.removed)
    verdict, more = _verdict(
        sessions=sessions, enough=enough, structure=structure, other=other, changed=changed, base=base
    )
    refined = bare.within_limits(fit, additions) if other or changed else None
    say("90 %: scoring on readings that took no part")
    last = last_fit(bare, fit, additions, news)
    scores = held_out_scores(model, base, refined, [s.used for s in last.fit.sessions])
    if refined is not None and (note := contradicted(fit, refined, last.fit, last.allowed)):
        verdict, more, structure = "unexplained", [note], replace(structure, left=True)
    if refined is not None and (note := worse(scores, base, last.allowed)):
        # what was found is no model of these readings: the one at hand stays, and where its residual sits is told
        verdict, more, structure = "unexplained", [*more, note], replace(structure, left=True)
        fit, news, changed, refined = base, [], [], None
        found = replace(found, alternatives=(), removed=())
        last = last_fit(fits, base, [], [])
        scores = held_out_scores(model, base, None, [s.used for s in last.fit.sessions])
    moved = refined is not None
    return Diagnosis(
        verdict=verdict,
        added=tuple(added_effect(a, last.allowed, last.fit, found.alternatives) for a in news),
        removed=found.removed,
        changed=tuple(changed),
        scores=scores,
        candidates=found.ranking,
        residual_sources=tuple(structure.sources),
        next_setups=tuple(_next_setups(verdict, fit, found.alternatives, structure.sources)),
        outliers=tuple(last.fit.outlier_rows()),
        notes=(
            *notes,
            *structure.notes,
            *more,
            *(last.chosen if moved else ()),
            *last.together,
            *odd_states(last.fit),
            *given_way(model, sessions, last.additions),
        ),
        next_traces=tuple(next_traces(sessions, found.alternatives, changed, structure.left)),
        model=last.model(model, found.removed) if moved else model,
        base=base,
        fit=fit,
        last=last.fit,
        held=tuple(tuple(np.unique(s.samples.setup[h]).tolist()) for s, h in zip(sessions, held, strict=True)),
        base_heldout_rms=found.base_rms,
    )


def _searched(search: Search, base: Fit) -> _Found:
    """Effects that explain the residual, those that would as well, and what is left."""
    search.say("10 %: comparing effects")
    linear = search.linearisation.at(search.fits.fit([], base) if search.known else base, [])
    base = linear.fit
    ranking, base_rms = candidates(search.effects, linear)
    beginnings, start = search.beginnings(linear), linear.expansion
    del linear
    fit, additions = search.run(start, beginnings)
    search.say("70 %: trying other effects in the place of what was found")
    fit, additions, found = with_alternatives(search, fit, additions, base)
    fit, additions = without_crumbs(search, fit, additions, found)
    found = explained_at_last(search, fit, additions, base=base, found=found)
    additions, fit = with_richer_forms(search.fits, additions, fit)
    if additions and not like_noise(fit):  # a rough ending may stop short of what these effects explain
        fit = replace(search.fits, ending=EXACT).fit(additions, fit)
        additions = at_values_of(fit, additions)
    fit, additions, removed = with_known(search.fits, fit, additions, search.known)
    outcome = judged(search, base=base, fit=fit, additions=additions, found=found)
    kept = [r for r in found if any(a.effect is r.addition.effect for a in outcome.additions)]
    return _Found(
        judged=outcome, alternatives=tuple(kept), ranking=tuple(ranking), base_rms=base_rms, removed=tuple(removed)
    )


def _alone(fits: ModelFits, model: ComplianceModel, base: Fit) -> ProcessAlone | None:
    """What effects of the process explain by themselves, where a cut was traced."""
    if all(s.path is None or s.path.dry for s in fits.sessions):
        return None
    moved = moved_parameters(fits=fits, model=model, base=base, fit=base, additions=[])
    return process_alone(fits, model, base, len(moved))


def _of_process(alone: ProcessAlone, base: Fit, others: Sequence[Imitation]) -> _Found:
    """Effects of the process, or the one of ``others`` that does with one kind of effect what they do with several;
    numbers of the robot and all others would imitate it."""
    kinds = len(alone.additions)
    simpler = kinds > 1 and bool(others) and others[0].cost < alone.cost
    fit, additions = (others[0].fit, others[0].additions) if simpler else (alone.fit, alone.additions)
    imitated = {e.name: base for e in alone.fits.base if e.is_base and base.solution.misfit < CLEAR}
    imitated |= {i.name: i.fit for i in others} | {a.effect.name: alone.fit for a in alone.additions}
    for a in additions:
        imitated.pop(a.effect.name, None)
    found = [Alternatives(a, alone.explained(fit), imitated) for a in additions]
    return _Found(Judged(fit, additions, Structure(False, [])), alternatives=tuple(found))


def _grouped(found: _Found, name: str, others: Sequence[Imitation]) -> _Found:
    """With ``others`` in the group of an effect: by themselves, on the model as it was, they explain what the effect
    and numbers of the model that went with it do."""
    more = {i.name: found.judged.fit for i in others if i.name != name}
    alternatives = tuple(
        replace(a, fits={**more, **a.fits}) if a.addition.effect.name == name else a for a in found.alternatives
    )
    return replace(found, alternatives=alternatives)


def _as_it_is(base: Fit, known: Sequence[Addition]) -> _Found:
    """What a session that is too small leaves: the model at hand."""
    return _Found(Judged(base, list(known), Structure(False, [])))


def _new(a: Addition, known: Sequence[Addition]) -> Addition | None:
    """An effect where the model at hand does not have it; None where it does."""
    before = next((k for k in known if k.effect is a.effect), None)
    sites = a.sites if before is None else tuple(s for s in a.sites if s not in before.sites)
    return replace(a, sites=sites, extras=a.extras & set(sites)) if sites and not a.held else None


def _verdict(
    sessions: Sequence[Session],
    enough: bool,
    structure: Structure,
    other: bool,
    changed: Sequence[MovedParameter],
    base: Fit,
) -> tuple[Verdict, list[str]]:
    """The verdict, and what the report has to note on it; ``other``: whether effects have been added or removed."""
    if not enough:
        count = sum(len(np.unique(s.samples.setup)) for s in sessions)
        return "insufficient-data", [f"{count} set-ups: fewer than {ENOUGH} cannot tell; measure more postures"]
    if structure.left:
        return "unexplained", []
    if other:
        return "explained", []
    if changed:
        return "parameters-changed", []
    if _mute(sessions, base):
        note = "no joint's stiffness stands out from the noise of these readings: load the arm more"
        return "insufficient-data", [note]
    return "adequate", []


def _mute(sessions: Sequence[Session], base: Fit) -> bool:
    """Whether the sessions could not have shown anything: all that the model predicts drowns in noise."""
    if any(s.has_absolute for s in sessions):
        return False
    springs = {e.name for e in base.unknowns.effects if e.is_base}
    told = [ok for u, ok in zip(base.unknowns.free, base.determined(), strict=True) if u.effect in springs]
    return not any(told)


def _next_setups(
    verdict: Verdict, fit: Fit, found: Sequence[Alternatives], sources: Sequence[ResidualSource]
) -> list[NextSetup]:
    for own in found if fit.sessions[0].session.path is None else ():
        for name, other in own.fits.items():
            return splitting(fit, other, f"tells {own.addition.effect.name} from {name}")
    session = next((s.session for s in fit.sessions if s.session.path is None), None)
    if session is None:  # a trace has no set-ups: ``next_traces``
        return []
    if verdict == "unexplained":
        top = next((s.what for s in sources if s.what.startswith("joint-")), None)
        joint = int(top.removeprefix("joint-")) - 1 if top else None
        return spread(session, joint, f"covers the range of {top or 'all joints'}, where structure is left")
    if verdict == "insufficient-data":
        return spread(session, None, "more postures, each loaded across the arm")
    return []
