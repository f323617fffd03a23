"""Thresholds: torques at which something switches, searched between the torques that the readings have.

No derivative leads to such a number. It enters the memory of joints alone, so every value costs one look at the
readings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition
from stiffness.identification.fit import Fit

VALUES = 30  # between the smallest and the largest torque of a joint


def thresholds(fit: Fit, additions: Sequence[Addition]) -> list[Addition] | None:
    """Additions with better thresholds; None where there are none to move."""
    joints, out, found = fit.unknowns.joints, list(additions), False
    for k, a in enumerate(additions):
        for p in a.effect.parameters:
            if not (p.fit == "given" and p.trials_of == "torque" and a.effect.memory):
                continue
            for site in a.sites:
                index = range(p.count(joints))[p.of_site(site.index)][0]
                values = {name: np.array(v) for name, v in out[k].values.items()}
                best = min(_tried(fit, index), key=lambda t: _chi2(fit, out[k], p.name, index, t))
                if _chi2(fit, out[k], p.name, index, best) < _chi2(
                    fit, out[k], p.name, index, float(values[p.name][index])
                ):
                    values[p.name][index] = best
                    out[k], found = replace(out[k], values=values), True
    return out if found else None


def _tried(fit: Fit, joint: int) -> list[float]:
    """Middles between torques of a joint that the readings have."""
    torque = np.unique(np.concatenate([np.abs(e.torque[:, joint]) for e in fit.evidence]))
    at = np.unique(np.linspace(0, len(torque) - 1, VALUES + 1).astype(int))
    return [float(t) for t in 0.5 * (torque[at[1:]] + torque[at[:-1]])]


def _chi2(fit: Fit, a: Addition, name: str, index: int, value: float) -> float:
    """Of the used readings' whitened residuals, all other numbers as fitted."""
    own = {k: np.array(v) for k, v in a.values.items()}
    own[name][index] = value
    total = 0.0
    for k, e in enumerate(fit.evidence):
        kept = e.fixed
        e.fixed = {**kept, a.effect.name: own}
        shared, own_numbers = len(fit.unknowns), e.station.size
        at = slice(shared, shared + own_numbers)
        blocks = e.blocks(fit.parameters, fit.station(k), fit.offset, at, at.stop)
        total += sum(float(b.residual @ b.residual) for b in blocks)
        e.fixed = kept
    return total
