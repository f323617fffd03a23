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
from stiffness.identification.unknowns import numbers_of
from stiffness.model.model import ComplianceModel

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
    return out


def _distance(fit: Fit, model: ComplianceModel) -> dict[tuple[str, str, int], float]:
    """Standard deviations between a fit and the model, of every number that the data determine."""
    out = {}
    known = fit.determined()
    for u, value, sd, ok in zip(fit.unknowns.free, fit.parameters, fit.sd, known, strict=True):
        if u.effect not in model.values or not ok:
            continue
        before = float(model.values[u.effect][u.parameter.name][u.index])
        given = model.sd.get(u.effect, {}).get(u.parameter.name)
        own = float(given[u.index]) if given is not None else 0.0
        if u.inverse:
            before, own = 1 / before, own / before**2
        out[u.effect, u.parameter.name, u.index] = float((value - before) / np.hypot(sd, own))
    return out


def _moved(key: tuple[str, str, int], fit: Fit, model: ComplianceModel, joints: int) -> MovedParameter:
    effect, name, index = key
    parameter = next(p for p in BY_NAME[effect].parameters if p.name == name)
    sites = BY_NAME[effect].sites(joints)
    where = next(
        (
            s.where
            for s in sites
            if any(u.index == index and u.parameter is parameter for u in numbers_of(BY_NAME[effect], s, joints, True))
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
