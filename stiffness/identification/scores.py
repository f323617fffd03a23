"""Scores: how far predicted readings are from measured ones, beside what noise alone would leave."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Score:
    """Residuals of one kind of comparison: of displacements, of absolute positions, of readings along a path; m.

    Attributes:
        rms: per axis, root of the mean of all squared components.
        p95, largest: of vector norms.
        noise_floor: what data sheets leave for a perfect model, per axis.
        by_reflector: name -> rms.
        count: residual vectors.
    """

    rms: float
    p95: float
    largest: float
    noise_floor: float
    by_reflector: dict[str, float]
    count: int


Judge = Callable[[Session, PredictedReadings, Bools, Bools], Score | None]


def displacement(session: Session, seen: PredictedReadings, rows: Bools, used: Bools) -> Score | None:
    """Score of displacements whose loaded reading is one of ``rows`` (N,); both readings are among the ``used``."""
    pairs = session.pairs
    keep = rows[pairs.row] & used[pairs.row] & used[pairs.reference] & session.counts[pairs.row]
    if not keep.any():
        return None
    row, reference = pairs.row[keep], pairs.reference[keep]
    residual = pairs.displacement[keep] - (seen.position[row] - seen.position[reference])
    variance = pairs.sd[keep] ** 2 + sensor_variance(session, seen, row) + sensor_variance(session, seen, reference)
    return _score(session, residual, variance, row)


def absolute(session: Session, seen: PredictedReadings, rows: Bools, used: Bools) -> Score | None:
    """Score of absolute positions at ``rows`` (N,) that are among the ``used``."""
    at = np.flatnonzero(rows & used & session.counts)
    if session.path is not None or not session.has_absolute or not len(at):
        return None
    residual = session.samples.position[at] - seen.position[at]
    return _score(session, residual, session.samples.sd[at] ** 2 + sensor_variance(session, seen, at), at)


def path(session: Session, seen: PredictedReadings, rows: Bools, used: Bools) -> Score | None:
    """Score of the readings of a trace at ``rows`` (N,) that are among the ``used``: per axis where they are points."""
    at = np.flatnonzero(rows & used)
    if session.path is None or not session.has_absolute or not len(at):
        return None
    numbers = slice(session.numbers_each)
    residual = (session.samples.position[at] - seen.position[at])[:, numbers]
    return _score(session, residual, session.samples.sd[at, numbers] ** 2, at)


KINDS: dict[str, Judge] = {"displacement": displacement, "absolute": absolute, "path": path}  # of evidence


def sensor_variance(session: Session, seen: PredictedReadings, rows: Index) -> Floats:
    """(K, 3) m^2: variance that the noise of the wrench sensor puts into predicted positions."""
    if not session.has_wrench:
        return np.zeros((len(rows), 3))
    sd = np.array([session.instruments.force] * 3 + [session.instruments.torque] * 3)
    return np.asarray(((seen.by_wrench[rows] * sd) ** 2).sum(axis=2))


def _score(session: Session, residual: Floats, variance: Floats, rows: Index) -> Score:
    length = np.linalg.norm(residual, axis=1)
    reflector = session.samples.reflector[rows]
    names = {int(k): session.reflectors[int(k)].name for k in np.unique(reflector)}
    return Score(
        rms=rms(residual),
        p95=float(np.percentile(length, 95)),
        largest=float(length.max()),
        noise_floor=float(np.sqrt(variance.mean())),
        by_reflector={name: rms(residual[reflector == k]) for k, name in names.items()},
        count=len(rows),
    )


def rms(residual: Floats) -> float:
    """Root of the mean of all squared components."""
    return float(np.sqrt(np.mean(residual**2))) if residual.size else 0.0


def pooled(scores: Sequence[Score | None]) -> Score | None:
    """Scores of several sessions as one."""
    there = [s for s in scores if s is not None]
    if not there:
        return None
    weight = np.array([s.count for s in there], dtype=float)

    def mean(values: Sequence[float]) -> float:
        return float(np.sqrt(np.average(np.square(values), weights=weight)))

    names = {name for s in there for name in s.by_reflector}
    return Score(
        rms=mean([s.rms for s in there]),
        p95=max(s.p95 for s in there),
        largest=max(s.largest for s in there),
        noise_floor=mean([s.noise_floor for s in there]),
        by_reflector={n: max(s.by_reflector.get(n, 0.0) for s in there) for n in sorted(names)},
        count=int(weight.sum()),
    )
