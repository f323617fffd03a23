"""Outliers: rows of a session that all others contradict, found by deletion statistics and left out of the fit.

A reading is judged against the bulk of its own kind, the readings of its reflector: where the model lacks something,
all of them are widened by it, and reflectors on the base are not. What is left out stays a small share of a session:
more of them are structure and no wrong rows, and stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.identification.agreement import agreeing, rigid, said_of_states, within_reach
from stiffness.identification.fit import Fit
from stiffness.identification.fitting import fitted
from stiffness.identification.problem import States
from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.least_squares import EXACT, ROUGH, Ending
from stiffness.session.far_readings import far_rows

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/identification/test_wrong_rows.py
FALSE_ALARM = 1e-4  # false-positive rate: of a clean session that loses a row
ROUNDS = 8
MOST_RECONSIDERED = 60  # rows left out that are looked at again one by one
WRONG_SETUPS = 0.02  # of all set-ups that may be wrong as a whole
WRONG = 0.05  # of the rows of a session, and
WRONG_OF_ONE = 0.1  # of those of a reflector, may be wrong; more are structure
FEW = 6  # rows that may be wrong in any session
MIDDLE, UPPER = 0.5, 0.95  # quantiles that measure the bulk: against wrong rows, and where there is structure
ENOUGH = 10  # readings of a reflector that have a bulk of their own


def cleaned(fit: Fit, ending: Ending = EXACT) -> Fit:
    """Without the rows that the others contradict, as exact as ``ending`` asks; ``fit`` may be rough."""
    start = _without_far(fit)
    for level in (MIDDLE, UPPER):
        found = _settled(start, level)
        if not any(_too_many(s) for s in found.sessions):
            found = _with_good_rows(found, level)
            return found if ending == ROUGH else _again(found, ending)
    return start if ending == ROUGH else _again(start, ending)


def _settled(fit: Fit, level: float) -> Fit:
    for _ in range(ROUNDS):
        states, found = _without_outliers(fit, level)
        fit = replace(fit, states=states)
        if not found:
            break
        fit = _again(fit)
    states, found = _with_rows_back(fit, level)
    fit = replace(fit, states=states)
    return _again(fit) if found else fit


def _without_far(fit: Fit) -> Fit:
    """Without gross errors; the fit starts anew, as they may have led it anywhere."""
    used = [s.used & ~far_rows(s.session) for s in fit.sessions]
    if all(np.array_equal(u, s.used) for u, s in zip(used, fit.sessions, strict=True)):
        return fit
    first = fit.problem.first_states()
    states = tuple(
        replace(state, used=rows, allowed=s.allowed) for state, rows, s in zip(first, used, fit.sessions, strict=True)
    )
    return fitted(fit.problem, states, notes=fit.notes)


def _with_good_rows(fit: Fit, level: float) -> Fit:
    """With those rows back that are not alone: what a model lacks it misses in all reflectors of a state. Where it
    lacks something with them in, rows are back that its link may have moved, turning about the others."""
    fit = _with(fit, [_confirmed(s, level) for s in fit.sessions])
    return _with(fit, [rigid(s, _left_out(s)) for s in fit.sessions]) if fit.lacks else fit


def _left_out(s: SessionFit) -> Bools:
    """(N,) rows that were left out and may come back: none that is farther off than a model can be wrong."""
    out = s.allowed & ~s.used
    return np.asarray(out & ~far_rows(s.session) & within_reach(s)) if out.any() else out


def _confirmed(s: SessionFit, level: float) -> Bools:
    """(N,) rows that were left out, and that others of their state confirm."""
    out = _left_out(s)
    if not out.any():
        return out
    return _agreeing(s, out, _Deletions.of(s, level))


def _agreeing(s: SessionFit, rows: Bools, scores: _Deletions) -> Bools:
    limit = np.zeros(len(rows))
    for k in np.unique(s.samples.reflector[rows]).tolist():
        limit[s.samples.reflector == k] = scores.limit_of(k, s)
    return agreeing(s, rows, limit)


def odd_states(fit: Fit) -> list[str]:
    """Sentences on single states in use that the bulk contradicts with several reflectors; none where they are many:
    there the model as a whole lacks something."""
    out = []
    for s in fit.sessions:
        if s.session.path is None:
            scores = _Deletions.of(s, MIDDLE)
            rows = _marked(s, scores, _worst_of_setups(s, scores))
            if 0 < rows.sum() <= WRONG * s.used.sum():
                rows = _agreeing(s, rows, scores)
                out += [said_of_states(s, rows)] if rows.any() else []
    return out


def _worst_of_setups(s: SessionFit, scores: _Deletions) -> Bools:
    """(D,) readings that are contradicted, and not because another of their set-up drew its free offset aside."""
    over = scores.chi2 > scores.limit(int(s.used.sum()))
    if not s.observations.weighting.offset > 0 or not over.any():
        return over
    worst = np.zeros(int(scores.block.max()) + 1)
    np.maximum.at(worst, scores.block, scores.chi2)
    return np.asarray(over & (scores.chi2 >= 0.5 * worst[scores.block]))


def _with(fit: Fit, rows: Sequence[Bools]) -> Fit:
    """Fitted anew with more rows, (N,) per session."""
    if not any(r.any() for r in rows):
        return fit
    states = tuple(replace(s.state, used=s.used | r) for s, r in zip(fit.sessions, rows, strict=True))
    return _again(replace(fit, states=states))


def _too_many(fit: SessionFit) -> bool:
    """Whether more was left out than can be wrong."""
    out, reflector = fit.allowed & ~fit.used, fit.samples.reflector
    if out.sum() > max(FEW, WRONG * fit.allowed.sum()):
        return True
    own = np.bincount(reflector[out], minlength=len(fit.session.reflectors))
    every = np.bincount(reflector[fit.allowed], minlength=len(fit.session.reflectors))
    return bool(np.any(own > np.maximum(FEW, WRONG_OF_ONE * every)))


def contradicting(fit: SessionFit) -> Bools:
    """(N,) rows in use that the bulk of their reflector contradicts, too many of them to be wrong rows."""
    found = _Deletions.of(fit, MIDDLE)
    return _marked(fit, found, found.chi2 > found.limit(int(fit.used.sum())))


def _marked(fit: SessionFit, scores: _Deletions, some: Bools) -> Bools:
    """(N,) the rows of ``some`` (D,) readings."""
    out = np.zeros(len(fit.samples), dtype=bool)
    for rows, told in zip(scores.rows, some, strict=True):
        out[rows] = told
    return out


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


def _again(fit: Fit, ending: Ending = ROUGH) -> Fit:
    return fitted(fit.problem, fit.states, fit.solution.vector, notes=fit.notes, ending=ending)


def _without_outliers(fit: Fit, level: float) -> tuple[States, bool]:
    """The states without the rows that all others contradict, and whether there were any."""
    total = sum(int(s.used.sum()) for s in fit.sessions)
    after: list[Any] = []
    found = False
    for s in fit.sessions:
        scores = _Deletions.of(s, level)
        over = scores.chi2 / scores.limit(total)
        used = s.used.copy()
        for block in np.unique(scores.block[over > 1]):
            mine = scores.block == block
            worst = mine & (over > 1) & (scores.chi2 >= 0.5 * scores.chi2[mine & (over > 1)].max())
            for k in np.flatnonzero(worst).tolist():
                used[scores.rows[k]] = False
            found = True
        after.append(replace(s.state, used=used))
    return tuple(after), found


@dataclass(frozen=True, repr=False, eq=False)
class _Deletions:
    """What leaving out each of the D readings of a session, or poses of a probe, would say.

    Attributes:
        rows: rows of each. chi2: (D,) of leaving it out. freedom: (D,) its degrees of freedom.
        block: (D,) the block of residuals that it is in.
        bulk: (D,) factor on chi-square that the bulk of its reflector shows.
    """

    rows: Sequence[npt.NDArray[np.intp]]
    chi2: Floats
    freedom: Floats
    block: npt.NDArray[np.intp]
    bulk: Floats

    @classmethod
    def of(cls, fit: SessionFit, level: float) -> _Deletions:
        """Of the readings in use; ``level``: the quantile that measures the bulk."""
        scores = [fit.observations.weighting.deletion(b) for b in fit.blocks()]
        rows = [r for some, _, _ in scores for r in some]
        if not rows:
            none = np.empty(0)
            return cls(rows=[], chi2=none, freedom=none, block=np.empty(0, dtype=np.intp), bulk=none)
        chi2 = np.concatenate([each for _, each, _ in scores])
        freedom = np.concatenate([each for _, _, each in scores])
        block = np.repeat(np.arange(len(scores)), [len(some) for some, _, _ in scores])
        ratio = chi2 / stats.chi2.ppf(level, freedom)
        reflector = np.array([fit.samples.reflector[r[0]] for r in rows])
        bulk = np.full(len(rows), float(np.quantile(ratio, level)))
        for k in np.unique(reflector):
            mine = reflector == k
            if mine.sum() >= ENOUGH:
                bulk[mine] = np.quantile(ratio[mine], level)
        return cls(rows=rows, chi2=chi2, freedom=freedom, block=block, bulk=np.maximum(bulk, 1.0))

    def limit(self, total: int) -> Floats:
        """(D,) chi-square that a clean session of ``total`` readings exceeds once in 1 / FALSE_ALARM."""
        return np.asarray(stats.chi2.isf(FALSE_ALARM / max(total, 1), self.freedom) * self.bulk)

    def limit_of(self, reflector: int, fit: SessionFit) -> float:
        """As ``limit``, of a reading of a reflector; by the bulk of all where no reading of it is in use."""
        mine = [float(b) for r, b in zip(self.rows, self.bulk, strict=True) if fit.samples.reflector[r[0]] == reflector]
        bulk = mine[0] if mine else float(np.median(self.bulk))
        return float(stats.chi2.isf(FALSE_ALARM / max(int(fit.used.sum()), 1), fit.session.numbers_each) * bulk)


def _with_rows_back(fit: Fit, level: float) -> tuple[States, bool]:
    """The states with rows that were dropped while a wrong one still disturbed the fit, and whether there were any."""
    after: list[Any] = []
    found = False
    for s in fit.sessions:
        state = s.state
        out = np.flatnonzero(~s.used & s.allowed)
        probes = s.session.group.max() >= 0
        if not len(out) or len(out) > MOST_RECONSIDERED or probes:
            after.append(state)
            continue
        scores = _Deletions.of(s, level)
        for row in out:
            limit = scores.limit_of(int(s.samples.reflector[row]), s)
            used = state.used.copy()
            used[row] = True
            with_row = replace(state, used=used)
            chi2, with_row = _deletion_of_row(s, with_row, int(row))
            state = with_row if chi2 <= limit else replace(with_row, used=state.used)
            found |= bool(chi2 <= limit)
        after.append(state)
    return tuple(after), found


def _deletion_of_row(s: SessionFit, state: Any, row: int) -> tuple[float, Any]:
    """Chi-square of leaving one row out again; infinite where it is not there."""
    blocks, state = s.observations.blocks(state, s.vector, s.columns)
    for block in blocks:
        if row in block.rows:
            rows, chi2, _ = s.observations.weighting.deletion(block)
            return next((float(c) for r, c in zip(rows, chi2, strict=True) if row in r), float("inf")), state
    return float("inf"), state
