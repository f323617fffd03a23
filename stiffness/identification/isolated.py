"""Isolated rows: readings that a model misses by far more than all others, and alone in their state.

A model that lacks something misses many readings, and misses reflectors of one link in one state alike. What is left
over of an evaluation has to be a single reading.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.identification.outliers import ENOUGH, FALSE_ALARM, UPPER
from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.identification.scores import sensor_variance
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/identification/test_isolated_rows.py
GROSS = 10.0  # times the 95 % quantile of its reflector: wrong, whatever others of the state show
ALONE = 3.0  # times the residual of every other reflector of its link in the same state


def isolated_rows(session: Session, seen: PredictedReadings) -> Bools:
    """(N,) readings whose position, or whose displacement, is missed as no other of its kind."""
    s, every = session.samples, np.arange(len(session.samples))
    if session.path is not None:
        return _off_the_path(session, seen)
    counted = every[session.counts]
    variance = s.sd**2 + sensor_variance(session, seen, every)
    off = s.position - seen.position
    out = np.zeros(len(s), dtype=bool)
    out[counted] = _isolated(session, counted, off[counted], variance[counted])
    pairs = session.pairs
    keep = session.counts[pairs.row] & ~out[pairs.row] & ~out[pairs.reference]
    row, reference = pairs.row[keep], pairs.reference[keep]
    if len(row):
        wrong = _isolated(session, row, off[row] - off[reference], variance[row] + variance[reference])
        out[_at_fault(row, reference, wrong)] = True
    return out


def _off_the_path(session: Session, seen: PredictedReadings) -> Bools:
    """(N,) readings of a trace that are missed by far more than all others."""
    numbers = slice(session.numbers_each)
    chi2 = (((session.samples.position - seen.position) / session.samples.sd)[:, numbers] ** 2).sum(axis=1)
    bulk = max(float(np.quantile(chi2, UPPER)), float(stats.chi2.ppf(UPPER, session.numbers_each)))
    return np.asarray(chi2 > GROSS**2 * bulk)


def _at_fault(row: Index, reference: Index, wrong: Bools) -> Index:
    """Readings of wrong pairs: the reference where all of several pairs with it are wrong, else the other."""
    count = np.bincount(reference)
    bad = np.bincount(reference[wrong], minlength=len(count))
    shared = (bad == count) & (count > 1)
    return np.where(shared[reference[wrong]], reference[wrong], row[wrong])


def _isolated(session: Session, rows: Index, off: Floats, variance: Floats) -> Bools:
    """(K,) which of some residuals (K, 3) m at ``rows`` stand out."""
    s = session.samples
    chi2 = (off**2 / variance).sum(axis=1)
    quantile = float(stats.chi2.ppf(UPPER, 3))
    kind = s.reflector[rows]
    bulk = np.full(len(rows), float(np.quantile(chi2, UPPER)))
    for k in np.unique(kind):
        mine = kind == k
        if mine.sum() >= ENOUGH:
            bulk[mine] = np.quantile(chi2[mine], UPPER)
    bulk = np.maximum(bulk, quantile)
    out = chi2 > stats.chi2.isf(FALSE_ALARM / len(rows), 3) * bulk / quantile
    for k in np.flatnonzero(out & (chi2 <= GROSS**2 * bulk)).tolist():
        others = _peers(session, rows, k)
        out[k] = len(others) > 0 and chi2[k] > ALONE**2 * chi2[others].max()
    return np.asarray(out)


def _peers(session: Session, rows: Index, k: int) -> Index:
    """Residuals of other reflectors of the same link in the same state."""
    s, link = session.samples, np.array([r.link for r in session.reflectors])
    row = rows[k]
    same = (s.setup[rows] == s.setup[row]) & (s.state[rows] == s.state[row])
    same &= (link[s.reflector[rows]] == link[s.reflector[row]]) & (s.reflector[rows] != s.reflector[row])
    return np.flatnonzero(same)
