"""Searched numbers: what shapes the memory of a joint and no derivative leads to: a switching torque, a side.

Each is a number of a joint's memory alone, so a value on trial costs no equilibrium of the arm. Chi-square is
compared with all other numbers refitted, in the model linearised at the fit: a profile of the likelihood, which gives
the value that explains most and the interval that the readings leave (Venzon & Moolgavkar, Appl. Statist. 37, 1988).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.added_effects import Addition
from stiffness.effects.effect import Parameter
from stiffness.identification.fit import Fit
from stiffness.identification.memory_trials import MemoryTrials

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/diagnosis/test_search.py
VALUES = 8  # on trial at a time
FINER = 2  # looks at what is between them
ALIKE = 1.0  # of chi-square over the misfit: values that leave no more than that beside the least are alike
SURE = 0.95  # of an interval
NORMAL = float(stats.norm.isf((1 - SURE) / 2))


@dataclass(frozen=True)
class _Range:
    """Values that the readings do not tell apart, from ``low`` to ``high``, one of them, and its chi-square."""

    low: float
    value: float
    high: float
    chi2: float


def with_better_numbers(fit: Fit, additions: Sequence[Addition]) -> list[Addition] | None:
    """Additions with searched numbers that leave less chi-square; None where there are none to move."""
    return _better(fit, MemoryTrials(fit.problem, fit.solution.vector, fit.states), additions)


def _better(fit: Fit, trials: MemoryTrials, additions: Sequence[Addition]) -> list[Addition] | None:
    out, found = list(additions), False
    for k, a in enumerate(additions):
        for p, index in _searched(a, fit.unknowns.joints):
            now = _chi2(fit, trials, every=out, a=out[k])
            profile = _profile(fit, trials, every=out, a=out[k], p=p, index=index)
            best = min(profile, key=lambda r: r.chi2, default=None)
            if best is not None and best.chi2 < now * (1 - 1e-9):
                out[k], found = with_number(out[k], p.name, index, best.value), True
    return out if found else None


def with_final_numbers(fit: Fit, additions: Sequence[Addition]) -> list[Addition] | None:
    """Additions with searched numbers that leave less chi-square, torques in the middle of all that leave as little:
    between two torques of the readings none is likelier, and the middle is least wrong at a load that lies between
    them. None where there are none to move."""
    trials = MemoryTrials(fit.problem, fit.solution.vector, fit.states)
    better = _better(fit, trials, additions)
    out, found = list(better or additions), better is not None
    for k, a in enumerate(out):
        for p, index in _searched(a, fit.unknowns.joints):
            middle = _middle(fit, trials, every=out, a=out[k], p=p, index=index) if p.trials_of == "torque" else None
            if middle is not None:
                out[k], found = with_number(out[k], p.name, index, middle), True
    return out if found else None


def with_middles(fit: Fit, additions: Sequence[Addition]) -> Fit:
    """A fit with its torques in the middle of all that leave as little, which other rows may have moved: its other
    numbers and what it leaves stay as they are."""
    trials = MemoryTrials(fit.problem, fit.solution.vector, fit.states)
    out, fixed = list(additions), dict(fit.fixed)
    for k, a in enumerate(out):
        for p, index in _searched(a, fit.unknowns.joints):
            middle = _middle(fit, trials, every=out, a=out[k], p=p, index=index) if p.trials_of == "torque" else None
            if middle is not None:
                out[k] = with_number(out[k], p.name, index, middle)
                fixed[a.effect.name] = {**fixed[a.effect.name], p.name: out[k].values[p.name]}
    return replace(fit, problem=fit.problem.with_memory_values(fixed))


def _middle(
    fit: Fit, trials: MemoryTrials, *, every: Sequence[Addition], a: Addition, p: Parameter, index: int
) -> float | None:
    """Middle of the torques about that of an addition that leave as little; None where no torque of the readings
    bounds them."""
    found = _alike(fit, trials, every=every, a=a, p=p, index=index, more=ALIKE)
    return None if found is None or not found.bounded else 0.5 * (found.low + found.high)


@dataclass(frozen=True)
class _Interval:
    """Torques from ``low`` to ``high``; whether one of the readings bounds them above."""

    low: float
    high: float
    bounded: bool


def _alike(
    fit: Fit,
    trials: MemoryTrials,
    *,
    every: Sequence[Addition],
    a: Addition,
    p: Parameter,
    index: int,
    more: float,
) -> _Interval | None:
    """Torques about that of an addition that leave no ``more`` of chi-square over the misfit; None beyond all torques
    of the readings."""
    torque, now = _torques(fit, index), float(a.values[p.name][index])
    last = len(torque) - 2  # beyond all torques
    own = int(np.searchsorted(torque, now, side="right")) - 1
    if last < 1 or not 0 <= own < last:
        return None

    def chi2(k: int) -> float:
        value = 0.5 * (torque[k] + torque[k + 1])
        return _chi2(fit, trials, every=every, a=with_number(a, p.name, index, value))

    limit = _chi2(fit, trials, every=every, a=a) + more * fit.solution.misfit**2
    ends = []
    for way, end in ((-1, 0), (1, last)):
        at, step = own, 1
        while step:
            k = at + way * step
            alike = (k - end) * way <= 0 and chi2(k) <= limit
            at, step = (k, 2 * step) if alike else (at, step // 2)
        ends.append(at)
    low, high = ends
    return _Interval(float(torque[low]), float(torque[high + 1]), high != last)


def searched_deviations(fit: Fit, additions: Sequence[Addition]) -> dict[str, dict[str, Floats]]:
    """Standard deviations of the searched numbers of additions, by effect and parameter, 0 for all others: half the
    interval of the profile likelihood over NORMAL, of a torque with the noise of what it is compared with; of a value
    that no torque of the readings reaches, down to where they begin to tell."""
    out: dict[str, dict[str, Floats]] = {}
    trials = MemoryTrials(fit.problem, fit.solution.vector, fit.states)
    more = float(stats.chi2.isf(1 - SURE, 1))
    for a in additions:
        for p, index in _searched(a, fit.unknowns.joints):
            near = _alike(fit, trials, every=additions, a=a, p=p, index=index, more=more) if p.trials_of else None
            if near is not None:
                sd = float(np.hypot((near.high - near.low) / (2 * NORMAL), _torque_noise(fit, index)))
            else:
                profile = _profile(fit, trials, every=additions, a=a, p=p, index=index)
                if not profile:
                    continue
                inside = [r for r in profile if r.chi2 <= min(r.chi2 for r in profile) + more * fit.solution.misfit**2]
                low, high, value = min(r.low for r in inside), max(r.high for r in inside), a.values[p.name][index]
                # beyond: no torque of the readings reaches it
                sd = (2 * (value - low) if value > high else high - low) / (2 * NORMAL)
            numbers = out.setdefault(a.effect.name, {}).setdefault(p.name, np.zeros(p.count(fit.unknowns.joints)))
            numbers[index] = sd
    return out


def _torque_noise(fit: Fit, joint: int) -> float:
    """N*m, standard deviation of a joint's torque among the readings of one state, whose wrench each has read anew."""
    square, freedom = 0.0, 0
    for s in fit.sessions:
        of, torque = s.session.states.of, s.state.torque[:, joint]
        count = np.bincount(of)
        mean = np.bincount(of, torque) / np.maximum(count, 1)
        square += float(np.sum((torque - mean[of]) ** 2))
        freedom += len(of) - int(np.count_nonzero(count))
    return float(np.sqrt(square / freedom)) if freedom else 0.0


def with_number(a: Addition, name: str, index: int, value: float) -> Addition:
    """An addition with one of its numbers changed."""
    values = {k: np.array(v) for k, v in a.values.items()}
    values[name][index] = value
    return replace(a, values=values)


def _searched(a: Addition, joints: int) -> Iterator[tuple[Parameter, int]]:
    """Numbers of an addition that are searched."""
    for p in a.effect.parameters if a.effect.memory and not a.held else ():
        if p.fit == "given" and p.trials:
            yield from ((p, range(p.count(joints))[p.of_site(s.index)][0]) for s in a.sites)


def _profile(
    fit: Fit, trials: MemoryTrials, *, every: Sequence[Addition], a: Addition, p: Parameter, index: int
) -> list[_Range]:
    """Chi-square of values all over their range, then more finely where it is least; ``every``: all that is added."""
    out: list[_Range] = []

    def look(ranges: Sequence[tuple[float, float, float]]) -> None:
        for low, value, high in ranges:
            chi2 = _chi2(fit, trials, every=every, a=with_number(a, p.name, index, value))
            out.append(_Range(low, value, high, chi2))

    if p.trials_of != "torque":
        look([(t, t, t) for t in p.trials])
        return out
    torque = _torques(fit, index)
    look(_between(torque))
    for _ in range(FINER if out else 0):  # a joint that nothing loads has no torque to switch at
        out.sort(key=lambda r: r.low)
        best = min(range(len(out)), key=lambda k: out[k].chi2)
        first, last = out[max(best - 1, 0)].low, out[min(best + 1, len(out) - 1)].high
        inner = torque[(torque >= first) & (torque <= last)]
        if len(inner) <= 4:
            break
        out[max(best - 1, 0) : best + 2] = []
        look(_between(inner))
    return out


def _torques(fit: Fit, joint: int) -> Floats:
    """Sizes of a joint's torque that the readings have, and one that none reaches: between two of them nothing
    changes."""
    found = np.unique(np.concatenate([[0.0], *(np.abs(s.torque[:, joint]) for s in fit.states)]))
    return np.append(found, 2 * found[-1])


def _between(torque: Floats) -> list[tuple[float, float, float]]:
    """At most VALUES ranges between torques: lowest, middle and highest of each."""
    edges = torque[np.unique(np.linspace(0, len(torque) - 1, VALUES + 1).astype(int))].tolist()
    return [(low, 0.5 * (low + high), high) for low, high in pairwise(edges) if high > low]


def _chi2(fit: Fit, trials: MemoryTrials, *, every: Sequence[Addition], a: Addition) -> float:
    """With the memory's numbers of all additions, those of ``a`` as given, and all other numbers refitted."""
    others = {b.effect.name: b.values for b in every}
    return trials.chi2({**fit.fixed, **others, a.effect.name: a.values})
