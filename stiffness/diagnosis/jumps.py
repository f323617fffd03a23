"""Jumps: a reflector or a tracker that moved at one row, drifted, or follows a column; which, and from which row on.

The residual of one reflector in the axes of its link (it was moved on the link), and of all reflectors of a tracker
station together in the axes of the readings (the tracker was moved), averaged per set-up, in the order of the file, is
compared with a constant: two constants (a jump at any set-up) or a straight line over the row, the time or a column.
The measure is Hotelling's T-squared of the shift, with the scatter about the better explanation for its noise, so that
a model that lacks something widens the yardstick; neighbours that are alike for another reason count for fewer
(effective number of samples, Bayley & Hammersley 1946). Of all that stand out the one is named that takes most of
chi-square when every number of the fit is free to answer: the fit has spread what one reflector did over all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.change_test import line_test, step_test
from stiffness.diagnosis.refit_answer import RefitAnswer
from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.kernel import Kernel
from stiffness.statics.statics import Statics

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/diagnosis/test_jumps.py
CHANCE = 1e-3  # false-positive rate: of a clean session in which anything is found (Bonferroni over all that is tried)
ENOUGH = 12  # set-ups that tell of a change at all
RUN = 3  # readings of one reflector in a row that were left out: no single errors
MOST = 4  # changes that are looked for in one session
LEAST = 1.0  # noise of a single reading: a smaller change is in no need of a name
AHEAD = 8.0  # on twice the log-likelihood: a jump has a row for a number more than a line (BIC of 3,000 rows)


@dataclass(frozen=True)
class MeasurementChange:
    """Something in the measurement changed while it was made.

    Attributes:
        session, samples: session.toml and samples.csv, as the user named them.
        what: ``jump``, ``drift`` (over the order of rows or the time) or ``trend`` (over ``column``).
        who: the reflector, or ``tracker``; ``block``: its station.
        before, after: lines of samples.csv between which it jumped, or over which it went on.
        shift: (3,) m, in the axes of the reflector's link, or of the readings; over the whole range of a line.
        p: chance of it in a clean session, times all that was tried.
    """

    session: str
    samples: str
    what: Literal["jump", "drift", "trend"]
    who: str
    block: int
    before: int
    after: int
    shift: tuple[float, float, float]
    p: float
    column: str = ""

    @property
    def size(self) -> float:
        """m."""
        return float(np.linalg.norm(self.shift))

    @property
    def sentence(self) -> str:
        """For the report."""
        moved = "the tracker" if self.who == "tracker" else f"reflector {self.who}"
        size = f"{self.size * 1e3:.2g} mm"
        if self.what == "jump":
            why = (
                "all reflectors at once: was the tracker bumped? Give the rows from there on a block of their own"
                if self.who == "tracker"
                else "on its link: was it knocked or put on anew? Raise reseat of this reflector from there on"
            )
            return f"something jumped between rows {self.before} and {self.after}: {moved}, {size}, {why}"
        if self.what == "drift":
            return f"{moved} drifted by {size} from row {self.before} to row {self.after}, steadily and not in one jump"
        # what moves all readings alike may be the arm as well as the tracker
        moved = "what all reflectors read" if self.who == "tracker" else moved
        return (
            f"{moved} follows column {self.column}: {size} over its range (rows {self.before} to {self.after}), "
            "more than it follows the order of rows"
        )


@dataclass(frozen=True, eq=False)
class _Series:
    """Residuals of one moving thing by set-up: ``values`` (U, 3) m; ``rows`` of each; ``turn`` (N, 3, 3) from the axes
    of the readings to its own; ``noise`` of a single reading, m."""

    who: str
    block: int
    rows: tuple[Index, ...]
    turn: Floats | None
    noise: float


def measurement_changes(fit: SessionFit) -> tuple[MeasurementChange, ...]:
    """What changed in a session while it was measured, the largest first; () where nothing did, and of a trace, whose
    order is that of the path."""
    if fit.session.path is not None:
        return ()
    rows = _readings(fit)
    answer = RefitAnswer.of(fit, rows)
    series = list(_series(fit, rows))
    tried = sum(1 + len(_columns(fit)) for _ in series)
    residual = answer.without(fit.samples.position - fit.predicted.position)
    out: list[MeasurementChange] = []
    while series and len(out) < MOST:
        found = [(s, c) for s in series if (c := _candidate(fit, s, residual, tried)) is not None]
        if not found:
            break
        every = [(s, c) for s in series for _, c in found]
        gains = [answer.gain(_share(fit, s, c), s.turn, residual)[0] for s, c in every]
        s, c = every[int(np.argmax(gains))]
        c = _refined(fit, answer, s, c, residual=residual)
        _, shift, residual = answer.gain(_share(fit, s, c), s.turn, residual)
        out.append(_change(fit, s, c, shift))
    return tuple(out)


@dataclass(frozen=True)
class _Candidate:
    """A change as a scan found it: a jump ``at`` a row of samples (its index), or a line over a ``column``."""

    at: int
    column: str | None
    p: float


def _series(fit: SessionFit, rows: Bools) -> Iterator[_Series]:
    s, session = fit.samples, fit.session
    links = _link_rotations(fit)
    for block in np.unique(s.block):
        mine = rows & (s.block == block)
        if units := _by_setup(s.setup, mine):
            noise = float(np.median(s.sd[mine]))
            yield _Series(who="tracker", block=int(block), rows=units, turn=None, noise=noise)
    for k in sorted({int(k) for k in np.unique(s.reflector[rows])}):
        mine = rows & (s.reflector == k)
        link = session.reflectors[k].link
        turn = np.swapaxes(fit.predicted.back @ links[:, link], 1, 2)
        if units := _by_setup(s.setup, mine):
            noise = float(np.median(s.sd[mine]))
            yield _Series(who=session.reflectors[k].name, block=0, rows=units, turn=turn, noise=noise)


def _readings(fit: SessionFit) -> Bools:
    """(N,) readings to look at: those of the fit and those that took no part, without single wrong rows."""
    s = fit.samples
    out = fit.allowed & ~fit.used
    for k in np.unique(s.reflector):
        at = np.flatnonzero(s.reflector == k)
        wrong = out[at]
        edges = np.flatnonzero(np.diff(np.r_[False, wrong, False].astype(int)))
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            out[at[start:end]] = end - start < RUN
    return np.asarray(~out & fit.session.counts)


def _by_setup(setup: npt.NDArray[np.int64], mine: Bools) -> tuple[Index, ...]:
    """Rows of every set-up in the order of the file; () where there are too few."""
    at = np.flatnonzero(mine)
    if not len(at):
        return ()
    parts = np.split(at, np.flatnonzero(np.diff(setup[at])) + 1)
    return tuple(parts) if len(parts) >= ENOUGH else ()


def _link_rotations(fit: SessionFit) -> Floats:
    """(N, n + 1, 3, 3): the links of the rigid arm in the base."""
    robot = fit.session.robot
    statics, q = Statics(robot, ()), ca.SX.sym("q", robot.n)
    links = statics.posture(q, ca.SX.zeros(statics.n_x)).links
    out = ca.densify(ca.vertcat(*(ca.vec(link.rotation.T) for link in links)))
    (turned,) = Kernel(ca.Function("links", [q], [out])).run(fit.samples.q)
    return np.asarray(turned.reshape(len(fit.samples), len(links), 3, 3))


def _columns(fit: SessionFit) -> Mapping[str, Floats]:
    """What a steady change may follow: the order of rows, the time, and numeric columns that vary; "" is the order."""
    s = fit.samples
    every = {"": np.arange(len(s), dtype=float), "time": s.time, "temperature": s.temperature, **s.extra}
    return {name: v for name, v in every.items() if np.isfinite(v).all() and np.ptp(v) > 0}


def _candidate(fit: SessionFit, series: _Series, residual: Floats, tried: int) -> _Candidate | None:
    """The change that explains most of one series; None where noise explains it as well."""
    own = residual if series.turn is None else np.einsum("nij,nj->ni", series.turn, residual)
    y = np.array([own[rows].mean(axis=0) for rows in series.rows])
    jump = step_test(y)
    lines = {}
    for name, column in _columns(fit).items():
        x = np.array([column[rows].mean() for rows in series.rows])
        if np.ptp(x) > 0:
            lines[name] = line_test(y, x)
    name = max(lines, key=lambda n: lines[n].likelihood)
    steady = lines[name].likelihood > jump.likelihood - AHEAD
    test = lines[name] if steady else jump
    p = test.p * tried * (1 if steady else len(y))
    if p > CHANCE or np.linalg.norm(test.shift) < LEAST * series.noise:
        return None
    return _Candidate(int(series.rows[jump.at][0]), name if steady else None, p)


def _share(fit: SessionFit, series: _Series, c: _Candidate) -> Floats:
    """(N,) how much of a change every reading shows; zero for readings of others."""
    every = np.concatenate(series.rows)
    share = np.zeros(len(fit.samples))
    if c.column is None:
        share[every] = every >= c.at
    else:
        column = _columns(fit)[c.column]
        share[every] = (column[every] - column[every].mean()) / np.ptp(column)
    return share


def _refined(
    fit: SessionFit, answer: RefitAnswer, series: _Series, c: _Candidate, *, residual: Floats
) -> _Candidate:
    """A jump at the very row: in the set-up that it was found to begin with, the one before or the one after."""
    if c.column is not None:
        return c
    k = next((k for k, rows in enumerate(series.rows) if rows[-1] >= c.at), len(series.rows) - 1)
    near = np.concatenate(series.rows[max(k - 1, 0) : k + 2])
    near = near[near > series.rows[0][0]]
    tried = [replace(c, at=int(row)) for row in near]
    gains = [answer.gain(_share(fit, series, t), series.turn, residual)[0] for t in tried]
    return tried[int(np.argmax(gains))] if tried else c


def _change(fit: SessionFit, series: _Series, c: _Candidate, shift: Floats) -> MeasurementChange:
    every, line = np.sort(np.concatenate(series.rows)), fit.samples.line
    before, after = every[0], every[-1]
    what: Literal["jump", "drift", "trend"] = "drift" if c.column in ("", "time") else "trend"
    if c.column is None:
        what, before, after = "jump", every[every < c.at][-1], every[every >= c.at][0]
    return MeasurementChange(
        session=fit.session.source,
        samples=fit.session.samples_file,
        what=what,
        who=series.who,
        block=series.block,
        before=int(line[before]),
        after=int(line[after]),
        shift=(float(shift[0]), float(shift[1]), float(shift[2])),
        p=c.p,
        column=c.column or "",
    )
