"""Plausibility: signs in a fit that a session is not of this robot, or that the model lacks an effect."""

from __future__ import annotations

import numpy as np

from stiffness.effects import CATALOGUE
from stiffness.identification.fit import Fit

# studied in tests/stiffness/identification/test_identify_trust.py
DOUBTFUL = 3.0  # a residual so many times the noise is no matter of noise
ASIDE = 0.01  # m, RMS; no arm that was mastered is so far from its drawing
FAR = 0.02  # m or rad, a single kinematic offset


def doubts(fit: Fit) -> list[str]:
    """Sentences for the report; none where all is well."""
    return [*_unfinished(fit), *_residual(fit), *_aside(fit), *_far(fit)]


def _unfinished(fit: Fit) -> list[str]:
    if fit.solution.converged:
        return []
    return [
        f"the fit has not settled within {fit.solution.steps} steps: its numbers are not the best ones; start from a "
        "model of this robot (a prior), or look for wrong rows and units"
    ]


def _residual(fit: Fit) -> list[str]:
    if fit.solution.misfit <= DOUBTFUL:
        return []
    return [
        f"the residual is {fit.solution.misfit:.1f} times what the noise leaves: another robot or tool than the "
        "session says, instruments worse than it says, or an effect that the model lacks"
    ]


def _aside(fit: Fit) -> list[str]:
    """Without kinematic offsets a fit looks at displacements alone: are the positions where they should be?"""
    if not any(s.observations.weighting.offset for s in fit.sessions):
        return []
    off = [(s.samples.position - s.predicted.position)[s.used] for s in fit.sessions]
    aside = float(np.sqrt(np.mean(np.sum(np.concatenate(off) ** 2, axis=1))))
    if aside <= ASIDE:
        return []
    geometry = ", ".join(e.name for e in CATALOGUE if e.fitted_where == "position")
    return [
        f"readings lie {aside * 1e3:.0f} mm (RMS) from where the robot model has its reflectors: is it the robot that "
        f"was measured? {geometry} would fit them"
    ]


def _far(fit: Fit) -> list[str]:
    geometry = {e.name for e in fit.unknowns.effects if e.fitted_where == "position"}
    far = [
        f"{u.parameter.name} of joint {u.index + 1}: {value * 1e3:.0f} m{u.parameter.unit}"
        for u, value in zip(fit.unknowns.free, fit.parameters, strict=True)
        if u.effect in geometry and abs(value) > FAR
    ]
    if not far:
        return []
    return [f"no arm is so far from its drawing ({', '.join(far)}): is it the robot that was measured?"]
