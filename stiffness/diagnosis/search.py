"""Search: which effects of the catalogue a model lacks, on readings that may take part.

Terms are selected in the model linearised at a fit, then fitted with the full model, and linearised again at that fit,
until nothing pays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits, at_values_of, merged
from stiffness.diagnosis.candidates import Column, Term, columns_of
from stiffness.diagnosis.linear_fit import NormalEquations
from stiffness.diagnosis.selection import CHANCE, Selection, Selector
from stiffness.diagnosis.sensitivities import Sensitivities
from stiffness.diagnosis.switching_torques import with_better_torques
from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect, Site
from stiffness.identification.fit import Fit
from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.least_squares import inverse
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Say = Callable[[str], None]

FOLDS = 10
ROUNDS = 4  # of linearisation and fit
WARMED = 0.1  # K; a smaller range of temperature tells nothing
SETTLED = 1.1  # residual over noise below which a fit is not started anew from elsewhere
NOT_THERE = 1e-3  # chance above which a site of a fitted effect counts as empty


@dataclass(frozen=True, repr=False, eq=False)
class Linearised:
    """The model linearised at a fit: the columns of all terms that may be added, and their selector."""

    fit: Fit
    columns: tuple[Column, ...]
    selector: Selector


@dataclass(frozen=True, repr=False, eq=False)
class Search:
    """The search of one diagnosis: ``fits`` of the model at hand; ``say`` reports progress."""

    fits: ModelFits
    say: Say

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Effects that the model lacks and the sessions could show."""
        own = {e.name for e in self.fits.base}
        return tuple(e for e in CATALOGUE if e.name not in own and _can_show(e, self.fits.sessions))

    def run(self, start: Linearised) -> tuple[Fit, list[Addition]]:
        """From a fit of the model at hand to one that lacks nothing the data can show."""
        fit, additions, linear = start.fit, list[Addition](), start
        for round_ in range(ROUNDS):
            if round_:
                linear = self.linearised(fit, additions)
                fit = linear.fit
            chosen = linear.selector.forward()
            if not chosen.terms:
                break
            more, trial = self.adopted(linear, chosen, additions)
            kept, trial = self.pruned(more, trial)
            self.say(f"round {round_ + 1}: " + ", ".join(f"{a.effect.name} ({' '.join(a.where)})" for a in kept))
            if not _better(trial, fit):
                break
            same = {(a.effect.name, a.sites, a.extras) for a in kept} == {
                (a.effect.name, a.sites, a.extras) for a in additions
            }
            fit, additions = trial, kept
            if same:
                break
        return fit, additions

    def adopted(
        self, linear: Linearised, chosen: Selection, additions: Sequence[Addition]
    ) -> tuple[list[Addition], Fit]:
        """Chosen terms as additions, fitted; where much is left, the fit is started from every shape on trial."""
        weights = {u.key: chosen.weights(u) for u in chosen.terms}
        begun = self._merged(linear, chosen.terms, weights, additions)
        fit = self.fits.fit(begun, linear.fit)
        if fit.solution.misfit > SETTLED:  # the numbers of a model without the effect may be far off with it
            other = self.fits.fit(begun)
            fit = min(fit, other, key=lambda f: f.solution.chi2)
        for term in chosen.terms if fit.solution.misfit > SETTLED else ():
            for alone in _one_trial_each(term, linear.columns, weights[term.key]):
                trial = self._merged(linear, chosen.terms, {**weights, term.key: alone}, additions)
                other = self.fits.fit(trial, linear.fit)
                if other.solution.chi2 < fit.solution.chi2:
                    fit, begun = other, trial
        if fit.solution.misfit > SETTLED:
            begun = at_values_of(fit, begun)
            moved = with_better_torques(fit, begun)
            if moved is not None:
                other = self.fits.fit(moved, fit)
                if other.solution.chi2 < fit.solution.chi2:
                    fit, begun = other, moved
        return at_values_of(fit, begun), fit

    def _merged(
        self,
        linear: Linearised,
        terms: Sequence[Term],
        weights: Mapping[tuple[str, tuple[str, ...]], Floats],
        additions: Sequence[Addition],
    ) -> list[Addition]:
        more = list(additions)
        for term in terms:
            more = merged(
                old=more,
                term=term,
                columns=linear.columns,
                weight=weights[term.key],
                joints=self.fits.joints,
            )
        return more

    def pruned(self, additions: list[Addition], fit: Fit) -> tuple[list[Addition], Fit]:
        """Without sites that the fit leaves empty, the emptiest first."""
        while True:
            empty = [(self._chance(fit, a, s), a, s) for a in additions for s in a.sites]
            worst = max(empty, key=lambda t: t[0], default=None)
            if worst is None or worst[0] < NOT_THERE:
                return additions, fit
            _, where, site = worst
            less = where.without(site, self.fits.joints)
            additions = [b for a in additions if (b := less if a is where else a) is not None]
            fit = self.fits.fit(additions, fit)
            additions = at_values_of(fit, additions)

    def _chance(self, fit: Fit, addition: Addition, site: Site) -> float:
        """Probability that noise alone gives what the fit finds at a site (Wald test)."""
        mine = set(replace(addition, sites=(site,)).numbers(self.fits.joints))
        at = [k for k, u in enumerate(fit.unknowns.free) if u in mine and u.parameter.neutral is not None]
        neutral = np.array([fit.unknowns.free[k].parameter.neutral for k in at], dtype=float)
        off = fit.parameters[at] - np.where(fit.unknowns.inverse[at], 1 / np.where(neutral == 0, 1, neutral), neutral)
        # shapes stand still: without the effect they are of no account
        shapes = [k for k, u in enumerate(fit.unknowns.free) if u in mine and u.parameter.neutral is None]
        rest = np.delete(np.arange(len(fit.solution.vector)), shapes)
        information = fit.solution.information + np.diag(_weak(fit))
        known = inverse(information[np.ix_(rest, rest)]) * fit.solution.misfit**2
        place = np.searchsorted(rest, at)
        covariance = known[np.ix_(place, place)]
        scale = np.sqrt(np.diag(covariance))
        score = float(
            (off / scale) @ np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True) @ (off / scale)
        )
        return float(stats.chi2.sf(score, len(at)))

    def linearised(self, fit: Fit, additions: Sequence[Addition]) -> Linearised:
        """The model linearised at a fit, with the columns of all terms that may be added."""
        torque = np.zeros(self.fits.joints)
        for s in fit.sessions:
            torque = np.maximum(torque, np.abs(s.predicted.torque).max(axis=0))
        columns, terms = columns_of(self.effects, self.fits.joints, torque)
        more = (
            self._slopes(sensitivities=sensitivities, s=s, fit=fit, columns=columns, additions=additions)
            for sensitivities, s in zip(self.sensitivities, fit.sessions, strict=True)
        )
        width = len(fit.solution.vector)
        equations, fit = normal_equations(fit, more, np.full(width, 1e-12) + _weak(fit))
        terms = [u for u in (_remaining(u, columns, additions) for u in terms) if u is not None]
        return Linearised(fit, tuple(columns), Selector(equations, terms, fit.solution.freedom))

    @cached_property
    def sensitivities(self) -> tuple[Sensitivities, ...]:
        """Of every session; they do not depend on a fit."""
        columns, _ = columns_of(self.effects, self.fits.joints, np.ones(self.fits.joints))
        numbers = list(dict.fromkeys(c.number for c in columns))
        effects = tuple(e for e in CATALOGUE if e in self.effects or e in self.fits.base)
        return tuple(Sensitivities(d, effects, numbers) for d in self.fits.data)

    def _slopes(
        self,
        sensitivities: Sensitivities,
        s: SessionFit,
        fit: Fit,
        columns: Sequence[Column],
        additions: Sequence[Addition],
    ) -> Floats:
        """(N, 3, C) derivatives of the readings by all columns, run by run."""
        place = {u: i for i, u in enumerate(sensitivities.numbers)}
        out = np.zeros((len(s.samples), 3, len(columns)))
        fitted = fit.values()
        for run in range(max((c.run for c in columns), default=-1) + 1):
            mine = [i for i, c in enumerate(columns) if c.run == run]
            trial = {c.number.effect: c.trial.values for c in columns if c.run == run}
            values = {x.name: x.neutral(self.fits.joints) for x in sensitivities.layout.effects}
            values.update({name: dict(v) for name, v in trial.items()})
            values.update({x.name: fitted[x.name] for x in self.fits.base})
            for a in additions:
                values[a.effect.name] = _kept(a, values[a.effect.name], fitted[a.effect.name], self.fits.joints)
            slopes = sensitivities.of(s, values)
            out[:, :, mine] = slopes[:, :, [place[columns[i].number] for i in mine]]
        return out


def normal_equations(fit: Fit, more: Iterable[Floats], precision: Floats) -> tuple[NormalEquations, Fit]:
    """Products of further columns with the residuals of a fit, fold by fold; the fit's own numbers are nuisance. And
    the fit, evaluated once more.

    Args:
        more: per session (N, 3, C) derivatives of the readings. precision: (V,) prior weight of the fit's numbers.
    """
    blocks, folds, states = [], [], []
    for s, own in zip(fit.sessions, more, strict=True):
        mine, state = s.observations.blocks(s.predicted.state, s.vector, s.columns, own)
        blocks += mine
        folds += [fold_of(s.session, int(b.rows[0])) for b in mine]
        states.append(state)
    return NormalEquations(blocks, folds, len(fit.solution.vector), precision), replace(fit, states=tuple(states))


def _kept(a: Addition, trial: Mapping[str, Floats], fitted: Mapping[str, Floats], joints: int) -> dict[str, Floats]:
    """Values on trial, but those of a fit at the sites that an addition has."""
    out = {k: np.array(v) for k, v in trial.items()}
    for p in a.effect.parameters:
        for s in (s for s in a.sites if s.kind == p.site):
            out[p.name][p.of_site(s.index)] = fitted[p.name][p.of_site(s.index)]
    return out


def _one_trial_each(term: Term, columns: Sequence[Column], weight: Floats) -> list[Floats]:
    """Weights that put all of a term on one of its trials; none where it has but one."""
    trial = [id(columns[k].trial) for k in term.columns]
    number = [columns[k].number for k in term.columns]
    total = {u: sum(w for w, v in zip(weight, number, strict=True) if v == u) for u in number}
    if len(set(trial)) < 2:
        return []
    return [
        np.array([total[u] if t == one else 0.0 for t, u in zip(trial, number, strict=True)])
        for one in dict.fromkeys(trial)
    ]


def _remaining(term: Term, columns: Sequence[Column], additions: Sequence[Addition]) -> Term | None:
    """What of a term an addition does not have yet."""
    a = next((a for a in additions if a.effect is term.effect and term.site in a.sites), None)
    if a is None:
        return term
    if not term.extras or term.site in a.extras or term.choice != 0:
        return None
    keep = [i for i, c in enumerate(term.columns) if columns[c].number.parameter.extra]
    return replace(term, columns=tuple(term.columns[i] for i in keep), positive=tuple(term.positive[i] for i in keep))


def _weak(fit: Fit) -> Floats:
    """(V,) prior precision that keeps what the data do not determine near the fit: 1000 of its standard deviations."""
    return np.asarray(1e-6 / np.maximum(np.diag(fit.solution.covariance), 1e-300))


def _better(more: Fit, less: Fit) -> bool:
    """Whether a fit beats another beyond chance for the numbers it has more; both see the same readings."""
    numbers = len(more.unknowns) - len(less.unknowns)
    drop = (less.solution.chi2 - more.solution.chi2) / more.solution.misfit**2
    return bool(stats.chi2.sf(max(drop, 0.0), max(numbers, 1)) < CHANCE)


def fold_of(session: Session, row: int) -> int:
    """Which fold a reading's set-up is in: set-ups are dealt in turn, in their order in the file."""
    setups = session.samples.setup
    order = {int(s): k for k, s in enumerate(dict.fromkeys(setups.tolist()))}
    return order[int(setups[row])] % FOLDS


def _can_show(effect: Effect, sessions: Sequence[Session]) -> bool:
    """Whether the sessions have what an effect shows in: enough set-ups, a wrench, a time, a range of temperature."""
    setups = sum(len(np.unique(s.samples.setup)) for s in sessions)
    if effect.is_base or any(p.each > setups for p in effect.parameters):
        return False
    if effect.wrench_reading:
        return any(s.has_wrench for s in sessions)
    if effect.position_reading:
        return any(bool(np.ptp(_finite(s.samples.time)) > 0) for s in sessions)
    if effect.thermal:
        return any(bool(np.ptp(_finite(s.samples.temperature)) > WARMED) for s in sessions)
    return True


def _finite(column: Floats) -> Floats:
    found = column[np.isfinite(column)]
    return found if len(found) else np.zeros(1)
