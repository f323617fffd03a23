"""Agreement: whether readings of one state miss the model alike. A wrong reading is alone; what a model lacks moves
all reflectors of a state, and none of them is wrong."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.identification.session_fit import SessionFit

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Index = npt.NDArray[np.intp]

# studied in tests/stiffness/identification/test_good_rows.py
SHARE = 0.5  # of a residual that another reading of the state shows, along it
SPREAD = 0.95  # quantile of motions and of residuals that tells how far a state may be off
KEPT = 4.0  # standard deviations of the distance of two reflectors of a link
ALIKE = 3.0  # times the residuals of its reflector: as structure has them
GROSS = 10.0  # times the residuals of its reflector, or
ASIDE = 0.01  # m: what no elastic arm is off by, however far its loads move it
NAMED = 6  # states that a sentence has room for


def agreeing(fit: SessionFit, out: Bools, limit: Floats) -> Bools:
    """(N,) which of the readings ``out`` (N,) another one of their state confirms.

    It does where it misses the model along the same direction, by half as much at least, and their difference is no
    outlier. A reading of a reflector alone on its link is confirmed by those of other links that move.

    Args:
        limit: (N,) chi-square that a reading's residual exceeds where it is wrong.
    """
    rows = np.flatnonzero(out)
    back = np.zeros(len(out), dtype=bool)
    if not len(rows) or fit.session.path is not None:
        return back
    off = _residual(fit) / fit.samples.sd
    of, reading = states(fit), _reading(fit)
    for row in rows.tolist():
        others = off[_witnesses(fit, row, of, reading)]
        along = others @ off[row] >= SHARE * (off[row] @ off[row])
        apart = ((others - off[row]) ** 2).sum(axis=1) / 2  # the noise of two
        back[row] = bool(np.any(along & (apart <= limit[row])))
    return _whole_readings(back, out, of, reading)


def rigid(fit: SessionFit, out: Bools) -> Bools:
    """(N,) which of the readings ``out`` (N,) a motion of their link as a whole explains: distances from half of the
    other readings of link and state at least are kept. All readings of that state are ``out``, or it is not much
    farther off than its reflector is elsewhere."""
    rows = np.flatnonzero(out)
    back = np.zeros(len(out), dtype=bool)
    if not len(rows) or fit.session.path is not None:
        return back
    off, sd, at = _residual(fit), fit.samples.sd, fit.predicted.position
    near = _within(fit, ALIKE)
    of, reading = states(fit), _reading(fit)
    for row in rows.tolist():
        others = _witnesses(fit, row, of, reading, beside=False)
        if len(others) and (near[row] or out[others].all()):
            way = at[others] - at[row]
            way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
            noise = np.sqrt(((way * sd[others]) ** 2 + (way * sd[row]) ** 2).sum(axis=1))
            back[row] = np.mean(np.abs(((off[others] - off[row]) * way).sum(axis=1)) <= KEPT * noise) >= 0.5
    return _whole_readings(back, out, of, reading)


def within_reach(fit: SessionFit) -> Bools:
    """(N,) readings no farther from the prediction than what a model lacks can move them: as far as the session's own
    loads move their reflector (10 mm at most), or ten times as far as the model misses it elsewhere."""
    s = fit.samples
    moved = np.linalg.norm(_about_mean(fit, fit.predicted.position, fit.allowed), axis=1)
    off = np.linalg.norm(_residual(fit), axis=1)
    out = _within(fit, GROSS)
    for k in np.unique(s.reflector):
        mine = s.reflector == k
        out[mine] |= off[mine] <= min(_quantile(moved[mine]), ASIDE)
    return out


def _within(fit: SessionFit, times: float) -> Bools:
    """(N,) readings that are off by so many times the residuals of their reflector at most."""
    off, out = np.linalg.norm(_residual(fit), axis=1), np.zeros(len(fit.samples), dtype=bool)
    for k in np.unique(fit.samples.reflector):
        mine = fit.samples.reflector == k
        known = mine & fit.used if np.any(mine & fit.used) else fit.used
        out[mine] = off[mine] <= times * _quantile(off[known])
    return out


def states(fit: SessionFit) -> Index:
    """(N,) number of the state of every reading."""
    s = fit.samples
    key = np.column_stack([s.setup, s.state, s.repeat])
    return np.asarray(np.unique(key, axis=0, return_inverse=True)[1].reshape(-1))


def said_of_states(fit: SessionFit, rows: Bools) -> str:
    """In one line how many states hold ``rows`` (N,), and the first row of some."""
    first = np.flatnonzero(rows)[np.unique(states(fit)[rows], return_index=True)[1]]
    lines = [str(k) for k in sorted(fit.samples.line[first].tolist())]
    more = f" and {len(lines) - NAMED} more" if len(lines) > NAMED else ""
    what = "1 state does not fit the model and stays" if len(lines) == 1 else (
        f"{len(lines)} states do not fit the model and stay"
    )
    return f"{what}, several reflectors agree: rows {', '.join(lines[:NAMED])}{more} of {fit.session.samples_file}"


def _witnesses(fit: SessionFit, row: int, of: Index, reading: Index, *, beside: bool = True) -> Index:
    """Other readings of a row's state: of its link, or, where it has none, those ``beside``: of other links that
    move."""
    link = fit.observations.data.link
    there = fit.allowed & (of == of[row]) & (reading != reading[row])
    own = there & (link == link[row])
    return np.flatnonzero(there & (link > 0) if beside and link[row] > 0 and not own.any() else own)


def _whole_readings(back: Bools, out: Bools, of: Index, reading: Index) -> Bools:
    """``back`` (N,) without parts of a probe's reading: its points come back together, or not at all."""
    split = np.unique(np.column_stack([of, reading])[out & ~back], axis=0)
    for state, probe in split[split[:, 1] >= 0].tolist():
        back = back & ~((of == state) & (reading == probe))
    return back


def _reading(fit: SessionFit) -> Index:
    """(N,) which reading of its state a row is in: the probe's number, below zero a single reflector's."""
    reflector = fit.samples.reflector
    probe = fit.session.group[reflector]
    return np.asarray(np.where(probe < 0, -1 - reflector, probe))


def _residual(fit: SessionFit) -> Floats:
    """(N, 3) m, read minus predicted; where positions are not trusted, from the mean of a reflector in its set-up."""
    off = np.asarray(fit.samples.position - fit.predicted.position)
    return _about_mean(fit, off, fit.used) if fit.observations.weighting.offset > 0 else off


def _about_mean(fit: SessionFit, value: Floats, known: Bools) -> Floats:
    """``value`` (N, 3) from its mean over those ``known`` (N,) of the same reflector, set-up and block; over all of
    them where none is known."""
    s = fit.samples
    of = np.unique(np.column_stack([s.setup, s.block, s.reflector]), axis=0, return_inverse=True)[1].reshape(-1)
    count = np.bincount(of, known)
    weight = np.where(count[of] > 0, known, True).astype(float)
    total = np.bincount(of, weight)
    mean = np.stack([np.bincount(of, weight * v) for v in value.T], axis=1) / total[:, None]
    return np.asarray(value - mean[of])


def _quantile(size: Floats) -> float:
    return float(np.quantile(size, SPREAD)) if len(size) else 0.0
