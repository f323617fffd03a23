"""Linearisation: a model with all effects that may be added to it, linear about a fit, compared by normal equations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.candidates import Column, Term, columns_of
from stiffness.diagnosis.linear_fit import NormalEquations
from stiffness.diagnosis.selection import CROSSED, Selector
from stiffness.diagnosis.sensitivities import Sensitivities
from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect
from stiffness.identification.fit import Fit
from stiffness.identification.reading_slopes import Slopes, SlopesOfRows
from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.whitened import Whitened
from stiffness.session.session import Session, count_setups

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Further = Callable[[Index], Sequence[Slopes]]

# studied in tests/trace_bench.py
FOLDS = 10
PIECE = 2048  # set-ups
KEPT = 0.01  # of a stretch that is left out: what it alone tells of the model's own numbers is not to be extrapolated
WARMED = 0.1  # K; a smaller range of temperature tells nothing


@dataclass(frozen=True, repr=False, eq=False)
class Expansion:
    """Where a model has been linearised: the fit, and the columns of the terms that may be added."""

    fit: Fit
    columns: tuple[Column, ...]


@dataclass(frozen=True, repr=False, eq=False)
class Linearised(Expansion):
    """The model linearised at a fit, and the selector of terms, with the products of all columns: a hundred MB and more
    where tables are candidates, to be let go when terms have been chosen."""

    selector: Selector

    @property
    def expansion(self) -> Expansion:
        """The same without products."""
        return Expansion(self.fit, self.columns)


@dataclass(frozen=True, repr=False, eq=False)
class Linearisation:
    """What can be linearised: the model at hand of ``fits``, with all effects that it lacks."""

    fits: ModelFits

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Effects that the model lacks and the sessions could show."""
        own = {e.name for e in self.fits.base}
        return tuple(e for e in CATALOGUE if e.name not in own and can_show(e, self.fits.sessions))

    def at(self, fit: Fit, additions: Sequence[Addition]) -> Linearised:
        """At a fit, with the columns of all terms that may be added."""
        torque = np.zeros(self.fits.joints)
        for s in fit.sessions:
            torque = np.maximum(torque, np.abs(s.predicted.torque).max(axis=0))
        columns, every = columns_of(self.effects, self.fits.joints, torque, self.fits.setups)
        remaining = [u for u in (_remaining(u, columns, additions) for u in every) if u is not None]
        columns, terms = _in_use(columns, remaining)
        more = [
            partial(self._slopes, sensitivities=sensitivities, s=s, fit=fit, columns=columns, additions=additions)
            for sensitivities, s in zip(self.sensitivities, fit.sessions, strict=True)
        ]
        width = len(fit.solution.vector)
        equations, fit = normal_equations(fit, more, len(columns), np.full(width, 1e-12) + weak(fit))
        crossed = self.fits.setups >= CROSSED
        selector = Selector(equations, terms, fit.solution.freedom, crossed=crossed)
        return Linearised(fit, tuple(columns), selector)

    @cached_property
    def sensitivities(self) -> tuple[Sensitivities, ...]:
        """Of every session; they do not depend on a fit."""
        columns, _ = columns_of(self.effects, self.fits.joints, np.ones(self.fits.joints), self.fits.setups)
        numbers = list(dict.fromkeys(c.number for c in columns))
        effects = tuple(e for e in CATALOGUE if e in self.effects or e in self.fits.base)
        return tuple(Sensitivities(d, effects, numbers) for d in self.fits.data)

    def _slopes(
        self,
        rows: Index,
        *,
        sensitivities: Sensitivities,
        s: SessionFit,
        fit: Fit,
        columns: Sequence[Column],
        additions: Sequence[Addition],
    ) -> list[SlopesOfRows]:
        """Derivatives of some readings by all columns, run by run."""
        place = {u: i for i, u in enumerate(sensitivities.numbers)}
        out, fitted = [], fit.values()
        for run in sorted({c.run for c in columns}):
            mine = [i for i, c in enumerate(columns) if c.run == run]
            trial = {c.number.effect: c.trial.values for c in columns if c.run == run}
            values = {x.name: x.neutral(self.fits.joints) for x in sensitivities.layout.effects}
            values.update({name: dict(v) for name, v in trial.items()})
            values.update({x.name: fitted[x.name] for x in self.fits.base})
            for a in additions:
                values[a.effect.name] = _kept(a, values[a.effect.name], fitted[a.effect.name], self.fits.joints)
            wanted = np.unique([place[columns[i].number] for i in mine])
            slopes = sensitivities.of(s, values, rows, wanted)
            at = np.searchsorted(wanted, [place[columns[i].number] for i in mine]).tolist()
            out.append(SlopesOfRows.of(slopes.taken(at, mine, len(columns)), rows, len(s.samples)))
        return out


def normal_equations(
    fit: Fit, more: Sequence[Further], count: int, precision: Floats
) -> tuple[NormalEquations, Fit]:
    """Products of further columns with the residuals of a fit, fold by fold; the fit's own numbers are nuisance. And
    the fit, evaluated once more.

    Args:
        more: per session the derivatives, by ``count`` columns, of the readings that are asked for: few at a time.
        precision: (V,) prior weight of the fit's numbers.
    """
    states = []

    def parts() -> Iterator[tuple[list[Whitened], list[int]]]:
        for s, own in zip(fit.sessions, more, strict=True):
            seen = s.observations.predict(s.predicted.state, s.vector, s.columns)
            states.append(seen.state)
            fold = folds(s.session)
            for some in _pieces(s.samples.setup):
                used = seen.state.used & some
                if not used.any():
                    continue
                slopes = own(np.flatnonzero(used))
                for k in np.unique(fold[used]).tolist():
                    part = replace(seen, state=replace(seen.state, used=used & (fold == k)))
                    mine = s.observations.weighting.blocks(part, s.columns, len(s.vector), slopes)
                    yield mine, [k] * len(mine)

    kept = KEPT if any(s.session.path is not None for s in fit.sessions) else 0.0
    equations = NormalEquations(parts(), len(fit.solution.vector), count, precision, kept=kept)
    return equations, replace(fit, states=tuple(states))


def _pieces(setup: npt.NDArray[np.int64]) -> list[npt.NDArray[np.bool_]]:
    """(N,) readings of some set-ups each, few enough at a time to keep memory small."""
    setups = np.unique(setup)
    return [np.isin(setup, some) for some in np.array_split(setups, -(-len(setup) // PIECE))]


def _kept(a: Addition, trial: Mapping[str, Floats], fitted: Mapping[str, Floats], joints: int) -> dict[str, Floats]:
    """Values on trial, but those of a fit at the sites that an addition has."""
    out = {k: np.array(v) for k, v in trial.items()}
    for p in a.effect.parameters:
        for s in (s for s in a.sites if s.kind == p.site):
            out[p.name][p.of_site(s.index)] = fitted[p.name][p.of_site(s.index)]
    return out


def _remaining(term: Term, columns: Sequence[Column], additions: Sequence[Addition]) -> Term | None:
    """What of a term an addition does not have yet."""
    a = next((a for a in additions if a.effect is term.effect and term.site in a.sites), None)
    if a is None:
        return term
    if not term.extras or term.site in a.extras or term.choice != 0:
        return None
    keep = [i for i, c in enumerate(term.columns) if columns[c].number.parameter.extra]
    return replace(term, columns=tuple(term.columns[i] for i in keep), positive=tuple(term.positive[i] for i in keep))


def _in_use(columns: Sequence[Column], terms: Sequence[Term]) -> tuple[list[Column], list[Term]]:
    """The columns that some term has, and the terms with their places among these: products of hundreds of numbers of a
    table that has been added would be of no use."""
    used = sorted({k for u in terms for k in u.columns})
    place = {k: i for i, k in enumerate(used)}
    return [columns[k] for k in used], [replace(u, columns=tuple(place[k] for k in u.columns)) for u in terms]


def weak(fit: Fit) -> Floats:
    """(V,) prior precision that keeps what the data do not determine near the fit: 1000 of its standard deviations."""
    return np.asarray(1e-6 / np.maximum(np.diag(fit.solution.covariance), 1e-300))


def folds(session: Session) -> npt.NDArray[np.intp]:
    """(N,) which fold a reading's set-up is in: set-ups are dealt in turn, in their order in the file."""
    _, first, of = np.unique(session.samples.setup, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))
    return np.asarray(order[of.reshape(-1)] % FOLDS)


def can_show(effect: Effect, sessions: Sequence[Session]) -> bool:
    """Whether the sessions have what an effect shows in: enough set-ups, a wrench, a time, a range of temperature."""
    setups = count_setups(sessions)
    if effect.is_base or any(p.each > setups for p in effect.parameters if not p.extra):
        return False
    if effect.wrench_reading:
        return any(s.has_wrench for s in sessions)
    if effect.position_reading:
        return any(bool(np.ptp(_finite(s.samples.time)) > 0) for s in sessions if s.numbers_each == 3)
    if effect.surface_reading:
        return any(_shows_a_size(s) for s in sessions)
    if effect.process_wrench:
        return any(_programmed(s) and bool(s.samples.load.wrench.any()) for s in sessions)
    if effect.thermal:
        return any(bool(np.ptp(_finite(s.samples.temperature)) > WARMED) for s in sessions)
    return True


def _shows_a_size(session: Session) -> bool:
    """Whether the same deviation along all normals is the cutter's, and no offset of a probe."""
    path = session.path
    return path is not None and path.kind == "surface" and not path.as_said and not path.probe_sd


def _programmed(session: Session) -> bool:
    return session.path is not None and not session.path.as_said


def _finite(column: Floats) -> Floats:
    found = column[np.isfinite(column)]
    return found if len(found) else np.zeros(1)
