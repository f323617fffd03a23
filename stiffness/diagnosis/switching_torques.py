"""Switching torques: torques at which a joint law switches, searched between the torques that the readings have.

No derivative leads to such a number. It enters the memory of joints alone, so every value costs one prediction of the
readings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition
from stiffness.identification.fit import Fit
from stiffness.identification.problem import States

VALUES = 30  # between the smallest and the largest torque of a joint


def with_better_torques(fit: Fit, additions: Sequence[Addition]) -> list[Addition] | None:
    """Additions with switching torques that leave less chi-square; None where there are none to move."""
    joints, out, found, states = fit.unknowns.joints, list(additions), False, fit.states
    for k, a in enumerate(additions):
        for p in a.effect.parameters:
            if not (p.fit == "given" and p.trials_of == "torque" and a.effect.memory):
                continue
            for site in a.sites:
                index = range(p.count(joints))[p.of_site(site.index)][0]
                tried = []
                for torque in _tried(fit, states, index):
                    chi2, states = _chi2(fit, states, with_number(out[k], p.name, index, torque))
                    tried.append((chi2, torque))
                if not tried:  # the joint has one torque in all readings
                    continue
                best = min(tried, key=lambda t: t[0])
                now, states = _chi2(fit, states, out[k])
                if best[0] < now:
                    out[k], found = with_number(out[k], p.name, index, best[1]), True
    return out if found else None


def with_number(a: Addition, name: str, index: int, value: float) -> Addition:
    """An addition with one of its numbers changed."""
    values = {k: np.array(v) for k, v in a.values.items()}
    values[name][index] = value
    return replace(a, values=values)


def _tried(fit: Fit, states: States, joint: int) -> list[float]:
    """Middles between torques of a joint that the readings have."""
    torque = np.unique(np.concatenate([np.abs(s.torque[:, joint]) for s in states]))
    at = np.unique(np.linspace(0, len(torque) - 1, VALUES + 1).astype(int))
    return [float(t) for t in 0.5 * (torque[at[1:]] + torque[at[:-1]])]


def _chi2(fit: Fit, states: States, a: Addition) -> tuple[float, States]:
    """Of the used readings' whitened residuals with the memory's numbers of an addition, all others as fitted."""
    problem = fit.problem.with_memory_values({**fit.fixed, a.effect.name: a.values})
    blocks, states = problem.blocks(fit.solution.vector, states)
    return sum(float(b.residual @ b.residual) for b in blocks), states
