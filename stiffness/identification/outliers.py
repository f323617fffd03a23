"""Outliers: rows of a session that all others contradict, found by deletion statistics and left out of the fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.identification.fit import Fit, fitted
from stiffness.identification.problem import States
from stiffness.identification.session_fit import SessionFit

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

FALSE_ALARM = 1e-4  # false-positive rate: of a clean session that loses a row
ROUNDS = 8
MOST_RECONSIDERED = 60  # rows left out that are looked at again one by one
WRONG_SETUPS = 0.02  # of all set-ups that may be wrong as a whole
MEDIAN = 2.366  # of chi-square with three degrees of freedom


def cleaned(fit: Fit) -> Fit:
    """Without the rows that the others contradict."""
    for _ in range(ROUNDS):
        states, found = _without_outliers(fit)
        fit = replace(fit, states=states)
        if not found:
            break
        fit = _again(fit)
    states, found = _with_rows_back(fit)
    fit = replace(fit, states=states)
    return _again(fit) if found else fit


def reconsidered(fit: Fit) -> Fit:
    """All allowed rows again: what a poorer model took for wrong may be right."""
    if all(np.array_equal(s.used, s.allowed) for s in fit.sessions):
        return fit
    every = tuple(replace(s.state, used=s.allowed) for s in fit.sessions)
    return cleaned(_again(replace(fit, states=every)))


def with_whole_setups(fit: Fit) -> tuple[Bools, ...]:
    """Per session (N,) rows in use, with those back that are most of their set-up: structure, and no wrong rows."""
    return tuple(_with_whole_setups(s) for s in fit.sessions)


def _with_whole_setups(fit: SessionFit) -> Bools:
    s, out, used = fit.samples, ~fit.used & fit.allowed, fit.used.copy()
    setups = np.unique(s.setup[out])
    few = len(setups) <= max(1, WRONG_SETUPS * len(np.unique(s.setup)))
    for setup in setups:
        rows = (s.setup == setup) & fit.allowed
        poses = len(np.unique(np.column_stack([s.state[rows], s.repeat[rows]]), axis=0))
        single = poses == 1 and fit.session.group[s.reflector[rows]].max() >= 0  # one reading of a probe
        if np.mean(out[rows]) > 1 / 3 and not (single and few):
            used[rows] = True
    return used


def _again(fit: Fit) -> Fit:
    return fitted(fit.problem, fit.states, fit.solution.vector, notes=fit.notes)


def _without_outliers(fit: Fit) -> tuple[States, bool]:
    """The states without the rows that all others contradict, and whether there were any."""
    total = sum(int(s.used.sum()) for s in fit.sessions)
    after: list[Any] = []
    found = False
    for s in fit.sessions:
        blocks, state = s.observations.blocks(s.state, s.vector, s.columns)
        scores = [s.observations.weighting.deletion(b) for b in blocks]
        every = np.concatenate([chi2 for _, chi2, _ in scores])
        # what the model does not explain widens everything: judge against the bulk of the readings
        bulk = max(1.0, float(np.median(every)) / MEDIAN)
        used = s.used.copy()
        for rows, chi2, freedom in scores:
            limit = stats.chi2.isf(FALSE_ALARM / max(total, 1), freedom) * bulk
            if len(chi2) and np.any(chi2 > limit):
                worst = chi2 >= max(float(limit[0]), 0.5 * chi2.max())
                for r in np.flatnonzero(worst):
                    used[rows[r]] = False
                found = True
        after.append(replace(state, used=used))
    return tuple(after), found


def _with_rows_back(fit: Fit) -> tuple[States, bool]:
    """The states with rows that were dropped while a wrong one still disturbed the fit, and whether there were any."""
    after: list[Any] = []
    found = False
    for s in fit.sessions:
        state = s.state
        out = np.flatnonzero(~s.used & s.allowed)
        limit = stats.chi2.isf(FALSE_ALARM / max(int(s.used.sum()), 1), 3) * fit.solution.misfit**2
        probes = s.session.group.max() >= 0
        for row in out if len(out) <= MOST_RECONSIDERED and not probes else ():
            with_row = replace(state, used=_with(state.used, int(row)))
            chi2, with_row = _deletion_of_row(s, with_row, int(row))
            state = with_row if chi2 <= limit else replace(with_row, used=state.used)
            found |= chi2 <= limit
        after.append(state)
    return tuple(after), found


def _with(used: Bools, row: int) -> Bools:
    out = used.copy()
    out[row] = True
    return out


def _deletion_of_row(s: SessionFit, state: Any, row: int) -> tuple[float, Any]:
    """Chi-square of leaving one row out again; infinite where it is not there."""
    blocks, state = s.observations.blocks(state, s.vector, s.columns)
    for block in blocks:
        if row in block.rows:
            rows, chi2, _ = s.observations.weighting.deletion(block)
            return next((float(c) for r, c in zip(rows, chi2, strict=True) if row in r), float("inf")), state
    return float("inf"), state
