"""Searched numbers: what shapes the memory of a joint and no derivative leads to: a switching torque, a side.

Each is a number of a joint's memory alone, so a value on trial costs one prediction of the readings. Chi-square is
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
from stiffness.identification.problem import States

Floats = npt.NDArray[np.float64]

VALUES = 30  # between the smallest and the largest torque of a joint
SURE = 0.95  # of an interval
NORMAL = float(stats.norm.isf((1 - SURE) / 2))


@dataclass(frozen=True, repr=False)
class _Profile:
    """Values on trial, the range that each stands for, and the chi-square of each."""

    values: list[float]
    low: list[float]
    high: list[float]
    chi2: list[float]


def with_better_numbers(fit: Fit, additions: Sequence[Addition]) -> list[Addition] | None:
    """Additions with searched numbers that leave less chi-square; None where there are none to move."""
    out, found, states = list(additions), False, fit.states
    for k, a in enumerate(additions):
        for p, index in _searched(a, fit.unknowns.joints):
            now, states = _chi2(fit, states, out[k])
            profile, states = _profile(fit, states, out[k], p, index)
            best = int(np.argmin(profile.chi2)) if profile.values else 0
            if profile.values and profile.chi2[best] < now * (1 - 1e-9):
                out[k], found = with_number(out[k], p.name, index, profile.values[best]), True
    return out if found else None


def searched_deviations(fit: Fit, additions: Sequence[Addition]) -> dict[str, dict[str, Floats]]:
    """Standard deviations of the searched numbers of additions, by effect and parameter, 0 for all others: half the
    interval of the profile likelihood over NORMAL."""
    out: dict[str, dict[str, Floats]] = {}
    states = fit.states
    for a in additions:
        for p, index in _searched(a, fit.unknowns.joints):
            profile, states = _profile(fit, states, a, p, index)
            if not profile.values:
                continue
            least = min(profile.chi2) + float(stats.chi2.isf(1 - SURE, 1)) * fit.solution.misfit**2
            inside = [k for k, chi2 in enumerate(profile.chi2) if chi2 <= least]
            width = max(profile.high[k] for k in inside) - min(profile.low[k] for k in inside)
            numbers = out.setdefault(a.effect.name, {}).setdefault(p.name, np.zeros(p.count(fit.unknowns.joints)))
            numbers[index] = width / (2 * NORMAL)
    return out


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


def _profile(fit: Fit, states: States, a: Addition, p: Parameter, index: int) -> tuple[_Profile, States]:
    out = _Profile([], [], [], [])
    for low, value, high in _tried(fit, p, index):
        chi2, states = _chi2(fit, states, with_number(a, p.name, index, value))
        out.values.append(value)
        out.low.append(low)
        out.high.append(high)
        out.chi2.append(chi2)
    return out, states


def _tried(fit: Fit, p: Parameter, index: int) -> list[tuple[float, float, float]]:
    """Lowest, middle and highest of ranges: between torques of the joint that the readings have nothing changes."""
    if p.trials_of != "torque":
        return [(t, t, t) for t in p.trials]
    torque = np.unique(np.concatenate([[0.0], *(np.abs(s.torque[:, index]) for s in fit.states)]))
    at = np.unique(np.linspace(0, len(torque) - 1, VALUES + 1).astype(int))
    edges = [*torque[at].tolist(), 2 * float(torque[-1])]  # the last range: no torque of the readings reaches it
    return [(low, 0.5 * (low + high), high) for low, high in pairwise(edges) if high > low]


def _chi2(fit: Fit, states: States, a: Addition) -> tuple[float, States]:
    """With the memory's numbers of an addition, all others refitted."""
    return fit.problem.lowest_with({**fit.fixed, a.effect.name: a.values}, fit.solution.vector, states)
