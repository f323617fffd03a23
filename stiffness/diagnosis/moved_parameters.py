"""Moved parameters: numbers of a model that differ from those that a fit finds now."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.result import MovedParameter
from stiffness.effects import BY_NAME
from stiffness.effects.effect import part_of
from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import Unknown, numbers_of
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import inverse

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/diagnosis/test_diagnose.py
CHANCE = 1e-3  # false-positive rate: of a model none of whose numbers has moved


def moved_parameters(
    fits: ModelFits, model: ComplianceModel, base: Fit, fit: Fit, additions: Sequence[Addition]
) -> list[MovedParameter]:
    """Numbers that differ from the model beyond what it and the data leave open.

    A model that was made with an effect undeclared has its numbers bent by it: where something was added, a number has
    moved only if it differs in the fit without the addition too, and to the same side.
    """
    fixed = fits.fit([], base, base_fixed=True)
    drop = (fixed.solution.chi2 - base.solution.chi2) / base.solution.misfit**2
    if stats.chi2.sf(max(drop, 0.0), max(len(base.unknowns), 1)) > CHANCE:
        return []
    first, last = _distance(base, model), _distance(fit, model)
    least = float(stats.norm.isf(CHANCE / 2 / max(len(first), 1)))
    # an effect added at a joint, or at a link beside it, takes over part of its spring
    beside = {part_of(w, fits.joints) for a in additions for w in a.where}
    out = []
    for key, z in first.items():
        still = last.get(key, 0.0)  # no longer determined: not moved either
        if abs(z) < least or (additions and (abs(still) < least or still * z < 0)):
            continue
        found = _moved(key, fit, model, fits.joints)
        if not any(abs(part_of(w, fits.joints) - b) <= 1 for w in found.where for b in beside if b >= 0):
            out.append(found)
    if not out and not additions:
        out = [_moved(key, fit, model, fits.joints) for key in fewest_moved(base, model)]
    return out


def fewest_moved(fit: Fit, model: ComplianceModel) -> list[tuple[str, str, int]]:
    """The fewest numbers (effect, parameter, index) whose move makes the rest of a model agree with a fit.

    Numbers that are known together only, as the springs of joints that bend alike, may none stand out by itself and
    yet not be what they were. The differences d have the covariance S of model and fit. That only the numbers m have
    moved explains g_m' (S^-1_mm)^-1 g_m of d' S^-1 d, with g = S^-1 d: they are taken one after the other, the one that
    explains most first, until the rest is what chance leaves.
    """
    keys, difference, covariance = _differences(fit, model)
    if not keys:
        return []
    precision = inverse(covariance)
    slope = precision @ difference
    total, taken = float(difference @ slope), list[int]()
    explained = 0.0
    while len(taken) < len(keys) and stats.chi2.sf(total - explained, len(keys) - len(taken)) < CHANCE:
        gain = {k: _explained(precision, slope, [*taken, k]) for k in range(len(keys)) if k not in taken}
        best = max(gain, key=lambda k: gain[k])
        taken, explained = [*taken, best], gain[best]
    return [keys[k] for k in taken]


def _explained(precision: Floats, slope: Floats, some: list[int]) -> float:
    return float(slope[some] @ np.linalg.solve(precision[np.ix_(some, some)], slope[some]))


def _differences(fit: Fit, model: ComplianceModel) -> tuple[list[tuple[str, str, int]], Floats, Floats]:
    """Numbers (P,) that the model and the data determine, what they differ by, and its covariance (P, P)."""
    keys, columns, difference, own, size = [], [], [], [], []
    for k, (u, value, ok) in enumerate(zip(fit.unknowns.free, fit.parameters, fit.determined(), strict=True)):
        if u.effect not in model.values or not ok or _not_identified(model, u):
            continue
        before, sd = _of_model(model, u)
        keys.append((u.effect, u.parameter.name, u.index))
        columns.append(k)
        difference.append(_between(u, value, before))
        size.append(value if u.inverse else 1.0)
        own.append(-sd / before if u.inverse else sd)
    data = fit.solution.covariance[np.ix_(columns, columns)] * fit.solution.misfit**2
    together = _correlation(model, keys)
    return keys, np.array(difference), data / np.outer(size, size) + together * np.outer(own, own)


def _between(u: Unknown, value: float, before: float) -> float:
    """What two numbers, as the solver sees them, differ by.

    Stiffnesses by their logarithm: three times too stiff on a data sheet is as likely as three times too soft, and half
    as stiff as stated is no more standard deviations of 1/k away than of k.
    """
    return float(np.log(value / before)) if u.inverse else float(value - before)


def _correlation(model: ComplianceModel, keys: Sequence[tuple[str, str, int]]) -> Floats:
    """(P, P) between numbers of a model; none where the file does not tell."""
    out = np.eye(len(keys))
    if model.correlations is None:
        return out
    place = {name: k for k, name in enumerate(model.correlations.names)}
    at = [place.get(f"{effect}.{name}[{index + 1}]", -1) for effect, name, index in keys]
    for i, a in enumerate(at):
        for j, b in enumerate(at):
            if i != j and a >= 0 and b >= 0:
                out[i, j] = model.correlations.matrix[a, b]
    return out


def _not_identified(model: ComplianceModel, u: Unknown) -> bool:
    """Whether the model itself tells that a number of it is none."""
    flags = model.identified.get(u.effect)
    return flags is not None and u.parameter.size == "joint" and not bool(flags[u.index])


def _of_model(model: ComplianceModel, u: Unknown) -> tuple[float, float]:
    """A number of the model as the solver sees it, and its standard deviation."""
    before = float(model.values[u.effect][u.parameter.name][u.index])
    given = model.sd.get(u.effect, {}).get(u.parameter.name)
    own = float(given[u.index]) if given is not None else 0.0
    return (1 / before, own / before**2) if u.inverse else (before, own)


def _distance(fit: Fit, model: ComplianceModel) -> dict[tuple[str, str, int], float]:
    """Standard deviations between a fit and the model, of every number that the data determine."""
    out = {}
    known = fit.determined()
    for u, value, sd, ok in zip(fit.unknowns.free, fit.parameters, fit.sd, known, strict=True):
        if u.effect not in model.values or not ok:
            continue
        before, own = _of_model(model, u)
        spread = np.hypot(sd / value, own / before) if u.inverse else np.hypot(sd, own)
        out[u.effect, u.parameter.name, u.index] = _between(u, value, before) / float(spread)
    return out


def _moved(key: tuple[str, str, int], fit: Fit, model: ComplianceModel, joints: int) -> MovedParameter:
    effect, name, index = key
    parameter = next(p for p in BY_NAME[effect].parameters if p.name == name)
    sites = BY_NAME[effect].sites(joints)
    where = next(
        (
            s.where
            for s in sites
            if any(
                u.index == index and u.parameter is parameter
                for extras in (False, True)
                for u in numbers_of(BY_NAME[effect], s, joints, extras)
            )
        ),
        (),
    )
    return MovedParameter(
        effect=effect,
        where=where,
        parameter=name,
        before=float(model.values[effect][name][index]),
        after=float(fit.values()[effect][name][index]),
        sd=float(fit.deviations()[effect][name][index]),
        unit=parameter.unit,
    )
