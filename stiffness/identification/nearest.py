"""Nearest to the drawing: of all solutions that the readings cannot tell apart, the one that a fit is to give.

Directions of the parameters that the data do not determine (``Gauge``) are held at the mean of the prior, which of an
effect is that it is not there, wherever the fit began; the rest is fitted anew. A joint that is loaded too little to
tell its stiffness even then is held where the fit began, as far as the readings allow.

Of a joint's spring and a place that yields about its axis the readings know the sum. The place is then taken as stiff
there, the spring stands for both, and is as sure as the sum: base parameters (Khalil & Dombre, Modeling, Identification
and Control of Robots, ch. 9).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.gauge import Gauge
from stiffness.identification.problem import Problem, loose_sd
from stiffness.numerics.least_squares import inverse

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/identification/test_gauge.py
HELD = 1e-6  # prior standard deviations that what is held may move
CONTRADICTED = 1.1  # of chi-square: what is held may not cost more
ONE = 1 - 1e-4  # correlation of what two numbers do to all readings
FIXED = 1e-3  # of that for a single number: a stiff start is 3e-4 prior standard deviations of compliance from rigid


def nearest_to_drawing(fit: Fit) -> Fit:
    """The fit with what its data do not determine put where the prior has it."""
    if not len(fit.unknowns):
        return fit
    fit = replace(fit, problem=_about_nothing(fit.problem))
    return _with_sums(_nearest(fit))


def _nearest(fit: Fit) -> Fit:
    """With springs in the directions; then with those held that stay unknown."""
    near = _holding(fit, np.zeros(len(fit.unknowns), dtype=bool), otherwise=fit)
    alike = yielding_alike(near, fit.unknowns.springs & ~_with_sums(near).determined())
    near = _holding(near, alike, otherwise=near) if alike.any() else near
    unknown = fit.unknowns.springs & ~_with_sums(near).determined()
    return _holding(fit, unknown, otherwise=near) if unknown.any() else near


def yielding_alike(fit: Fit, springs: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """(P,) places that all readings see yield as one of the ``springs`` (P,) does: where one is not told by itself, the
    place may have taken their sum and left it rigid."""
    n = len(fit.unknowns)
    information = fit.solution.information[:n, :n]
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    as_one = np.abs(information / np.outer(size, size))[:, springs] > ONE
    return np.asarray(as_one.any(axis=1) & [u.parameter.yields for u in fit.unknowns.free])


def _holding(fit: Fit, unknown: npt.NDArray[np.bool_], otherwise: Fit) -> Fit:
    """With the ``unknown`` (P,) and the open directions held; ``otherwise`` where the readings contradict that."""
    rows = _held(fit, unknown)
    near = _with(fit, rows) if len(rows) else fit
    lacking = fit.solution.misfit > CLEAR  # what it lacks, springs that no reading tells would imitate
    return near if lacking or near.solution.chi2 < CONTRADICTED * fit.solution.chi2 else otherwise


def _about_nothing(problem: Problem) -> Problem:
    """The problem with the mean of loose priors where an effect is not there, if its law is linear in its numbers."""
    shaped = {
        e.name for e in problem.unknowns.effects if any(p.neutral is None for p in e.parameters if p.fit != "given")
    }
    loose = problem.parameter_sd >= loose_sd(problem.unknowns, problem.fixed)
    fixed = {name: {k: np.array(v, dtype=float) for k, v in own.items()} for name, own in problem.fixed.items()}
    for u, ok in zip(problem.unknowns.free, loose, strict=True):
        if ok and u.effect not in shaped:
            fixed[u.effect][u.parameter.name][u.index] = u.parameter.neutral
    return replace(problem, fixed=fixed)


def _with_sums(fit: Fit) -> Fit:
    """The fit with springs as sure as their sums with what yields and is the choice of a solution, or yields as one
    of them that is not told by itself."""
    yields = np.array([u.parameter.yields for u in fit.unknowns.free], dtype=bool)
    alike = yielding_alike(fit, fit.unknowns.springs & ~fit.determined())
    at = np.flatnonzero(fit.gauge.chosen & yields | alike)
    if not len(at):
        return fit
    covariance, springs = fit.solution.covariance, np.flatnonzero(fit.unknowns.springs)
    turn = np.eye(len(covariance))
    turn[np.ix_(springs, at)] = -covariance[np.ix_(springs, at)] @ inverse(covariance[np.ix_(at, at)])
    rest = turn @ covariance @ turn.T
    return replace(fit, solution=replace(fit.solution, covariance=rest))


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
