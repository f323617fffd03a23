"""Structure: whether a fit leaves more than noise, where that sits, and which additions stand beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from stiffness.diagnosis.added_effects import Addition, at_values_of
from stiffness.diagnosis.adoption import better, richest
from stiffness.diagnosis.alternatives import Alternatives
from stiffness.diagnosis.attribution import ResidualSource, residual_sources
from stiffness.diagnosis.beyond_catalogue import beyond_catalogue
from stiffness.diagnosis.last_fit import of_all_readings
from stiffness.diagnosis.search import Search, like_noise
from stiffness.effects.effect import part_of
from stiffness.identification.coherence import coherent
from stiffness.identification.fit import CLEAR, Fit

# studied in tests/effects_report (its targets)
SLIGHT = 0.1  # of what was above the noise: so much may stay when an explanation is right but its law not exact
SLIGHTLY = 1.3  # residual over noise that a law which is not exact may leave
TRIFLE = 0.05  # of what was above the noise: so much may stay where
MINOR = 0.1  # of it is the most that any place or column explains
MANY = 3  # kinds of effects added to one session that are no explanation unless noise is all they leave
CRUMB = 0.03  # of what was above the noise: an addition that explains less beside others is left out
LARGE = 0.6  # of what was above the noise: an effect that explains more and leaves all others behind stands
AHEAD = 0.5  # of what it explains in cross-validation: where no other explains more, it leaves all others behind
WHOLE = 0.95  # of what was above the noise: where one source explains so much, it needs no effect beside it
PARTLY = 0.2  # of what was above the noise: an effect that explains less is not called the explanation


@dataclass(frozen=True, repr=False, eq=False)
class Structure:
    """What a fit leaves: whether structure is ``left``, where it sits, and ``notes`` for the report."""

    left: bool
    sources: list[ResidualSource]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False, eq=False)
class Judged:
    """The additions that stand, their fit, and what it leaves."""

    fit: Fit
    additions: list[Addition]
    structure: Structure


def without_crumbs(
    search: Search, fit: Fit, additions: list[Addition], found: Sequence[Alternatives]
) -> tuple[Fit, list[Addition]]:
    """Without additions that only polish what another explains: laws that are not exact to the last digit, or the
    simple form of one whose richer form leaves no more. A small cause of its own is no polish: of what is left without
    it, it explains nearly all."""
    for r in sorted((r for r in found if r.explains < CRUMB), key=lambda r: r.explains):
        kept = [a for a in additions if a.effect is not r.addition.effect]
        if len(kept) == len(additions) or not kept:
            continue
        rich = richest(search.fits, kept)
        if rich != kept and (whole := search.fits.fit(rich, fit)).solution.chi2 <= fit.solution.chi2:
            fit, additions = whole, at_values_of(whole, rich)
            continue
        trial = search.fits.fit(kept, fit)
        if trial.solution.chi2 > SLIGHTLY**2 * trial.solution.freedom:
            continue
        if better(fit, trial) and _above(fit) < PARTLY * _above(trial):
            continue
        fit, additions = trial, at_values_of(trial, kept)
    return fit, additions


def judged(
    search: Search, base: Fit, fit: Fit, additions: list[Addition], found: Sequence[Alternatives]
) -> Judged:
    """Additions that stand beside what is left, and the structure that is left or, where none is, that was there."""
    search.say("80 %: looking where the rest sits")
    now = standing(search, base=base, fit=fit, additions=additions, found=found)
    beyond = beyond_catalogue(search, base, now.fit) if now.additions and not search.known else None
    if beyond is not None:
        named = " and ".join(a.effect.name for a in now.additions)
        note = f"{beyond.words}, in no catalogue, explains what was left more simply than {named}: not added"
        return Judged(base, [], Structure(True, _sources(search, base), (note,)))
    added = [a for a in now.additions if all(a.effect is not k.effect for k in search.known)]
    if now.structure.left or not added:
        return now
    return replace(now, structure=replace(now.structure, sources=_sources(search, base)))


def standing(
    search: Search, base: Fit, fit: Fit, additions: list[Addition], found: Sequence[Alternatives]
) -> Judged:
    """Additions that stand beside what is left, and the structure that is left."""
    now = _seen(search, base, fit, additions)
    notes = now.structure.notes
    compared = {r.addition.effect.name: r for r in found}
    while now.structure.left and (doubtful := _doubtful(search, base, now, compared)) is not None:
        known = any(k.effect is doubtful.effect for k in search.known)
        stands = "the model has it, these readings do not confirm it" if known else "not added"
        note = (
            f"{doubtful.effect.name} in {' '.join(doubtful.where)} would explain a part only, beside clear "
            f"structure in the same place: {stands}"
        )
        kept = [a for a in now.additions if a is not doubtful]
        fit = search.fits.fit(kept, now.fit)
        now = _seen(search, base, fit, at_values_of(fit, kept))
        notes = (*notes, note, *now.structure.notes)
    return replace(now, structure=replace(now.structure, notes=notes))


def _seen(search: Search, base: Fit, fit: Fit, additions: list[Addition]) -> Judged:
    """Additions with what they leave."""
    new = [a for a in additions if all(a.effect is not k.effect for k in search.known)]
    return Judged(fit, additions, _structure(search, base, fit, additions, many=len(new) >= MANY))


def _structure(search: Search, base: Fit, fit: Fit, additions: list[Addition], *, many: bool) -> Structure:
    """Whether a fit leaves clear structure, and where; of ``many`` kinds of effects, whether anything is left."""
    misfit = fit.solution.noises
    above, first = _above(fit), _above(base)
    if like_noise(fit):
        return Structure(False, [])
    if misfit < CLEAR and not many:
        small = (
            f"the residual is {misfit:.2f} times the noise: more than chance, less than can be named; standard "
            "deviations hold what it may hide"
        )
        return Structure(False, [], (small,) if any(coherent(s) for s in fit.sessions) else ())
    slight = fit is not base and not many and misfit < SLIGHTLY and above < SLIGHT * first and first > 0
    # a law that is right to a trifle is so of readings that did not choose it as well
    if slight and of_all_readings(search.fits, additions, fit)[1].solution.noises < SLIGHTLY:
        note = f"what was added leaves {misfit:.2f} times the noise: its law is right, but not to the last digit"
        return Structure(False, [], (note,))
    sources = _sources(search, fit)
    if fit is not base and not many and above < TRIFLE * first and all(s.fraction < MINOR for s in sources):
        note = (
            f"what was added leaves {misfit:.2f} times the noise, {100 * above / first:.0f} % of what there was above "
            "it, and no place and no column explains a tenth of that"
        )
        return Structure(False, sources, (note,))
    if sources or (fit is not base and above > PARTLY * first) or any(coherent(s) for s in fit.sessions):
        return Structure(True, sources)
    note = (
        f"the residual is {misfit:.2f} times the noise, but readings of one state do not agree on it and it "
        "follows nothing that was looked at: the instruments scatter more than their data sheet says"
    )
    if any(e.memory for e in fit.unknowns.effects):
        note += ", or some states came to rest on another flank than the model has them on"
    return Structure(False, sources, (note,))


def _sources(search: Search, fit: Fit) -> list[ResidualSource]:
    return [] if like_noise(fit) else residual_sources(fit, search.sensitivities)


def _doubtful(search: Search, base: Fit, now: Judged, compared: Mapping[str, Alternatives]) -> Addition | None:
    """An addition that only took the nearest name beside structure that is left: in the same place, or beside a
    source that explains all of it by itself; of several the one that explains least, for the others may stand without
    it. One that is far ahead of all other effects is the right name for its part."""
    joints = search.fits.joints
    doubtful: list[tuple[float, Addition]] = []
    places = [s.what for s in now.structure.sources if s.is_place]
    for a in (a for a in now.additions if not a.held):
        without = search.fits.fit([b for b in now.additions if b is not a], now.fit)
        explained = (_above(without) - _above(now.fit)) / max(_above(base), 1e-9)
        beside = {part_of(w, joints) for w in a.where}
        # numbers of an instrument take in what an unknown load does anywhere
        shown = a.effect.scope == "instruments"
        there = shown or not places or part_of(places[0], joints) in beside
        own = compared.get(a.effect.name)
        share = explained if own is None else min(explained, own.held_out)
        certain = own is not None and share > LARGE and own.runner_up < AHEAD * own.held_out and not shown
        nearest = share < PARTLY or (share < 1 - PARTLY and there and not certain)
        if nearest or (share < LARGE and _one_source(search, without, now)):
            doubtful.append((share, a))
    return min(doubtful, key=lambda d: d[0])[1] if doubtful else None


def _one_source(search: Search, without: Fit, now: Judged) -> bool:
    """Whether what is left points at one source that, without an addition, explains all of it too."""
    left = now.structure.sources[:1]
    if not left or left[0].fraction < WHOLE:
        return False
    return any(s.what == left[0].what and s.fraction > WHOLE for s in _sources(search, without))


def _above(fit: Fit) -> float:
    """Chi-square above what noise leaves."""
    return max(fit.solution.chi2 - fit.solution.freedom, 0.0)
