"""Nearest to the drawing: of all solutions that the readings cannot tell apart, the one that a fit is to give.

What loads a joint too little to tell its stiffness is held where the fit began; directions of all other parameters that
the data do not determine (``Gauge``) are held at the mean of the prior; the rest is fitted anew. Where the readings
contradict that (they know a spring together with another number, which cannot make up for where it began), springs
take part in the directions, and at last nothing is held.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.gauge import Gauge

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/identification/test_gauge.py
HELD = 1e-6  # prior standard deviations that what is held may move
CONTRADICTED = 1.1  # of chi-square: what is held may not cost more
FIXED = 1e-3  # of that for a single number: a stiff start is 3e-4 prior standard deviations of compliance from rigid


def nearest_to_drawing(fit: Fit) -> Fit:
    """The fit with what its data do not determine put where the prior has it."""
    if not len(fit.unknowns):
        return fit
    unknown = fit.unknowns.springs & ~fit.determined()
    for springs in (unknown, np.zeros_like(unknown)) if unknown.any() else (unknown,):
        rows = _held(fit, springs)
        near = _with(fit, rows) if len(rows) else fit
        lacking = fit.solution.misfit > CLEAR  # what it lacks, springs that no reading tells would imitate
        if lacking or near.solution.chi2 < CONTRADICTED * fit.solution.chi2:
            return near
    return fit


def _with(fit: Fit, rows: Floats) -> Fit:
    """With combinations (K, P) of the parameters held where the prior is."""
    moved = np.abs(rows @ (fit.parameters - fit.problem.start[: len(fit.unknowns)]))
    if moved.max() <= HELD:
        return fit
    wide = np.zeros((len(rows), len(fit.solution.vector)))
    wide[:, : len(fit.unknowns)] = rows / HELD
    solution, states = fit.problem.solved(fit.states, fit.solution.vector, widened=fit.solution.misfit, held=wide)
    return replace(fit, solution=solution, states=states)


def _held(fit: Fit, unknown: npt.NDArray[np.bool_]) -> Floats:
    """(K, P): combinations of the parameters, in prior standard deviations, that are to stay where the prior is; the
    ``unknown`` (P,) each by itself."""
    n = len(fit.unknowns)
    single = np.eye(n)[unknown] / fit.gauge.unit[unknown, None] / FIXED
    # what is held is known: the others are judged with it in its place
    firm = np.where(unknown, HELD * fit.gauge.unit, fit.problem.sd[:n])
    rest = Gauge.of(
        unit=fit.gauge.unit,
        scale=fit.gauge.scale,
        data=fit.solution.information,
        sd=np.concatenate([firm, fit.problem.sd[n:]]),
        misfit=fit.solution.misfit,
    )
    return np.vstack([single, rest.open_rows()])
