"""Uncertainty of a predicted deflection: what standard deviations of material and model make of it along the path.

Each uncertain number is moved by one standard deviation and the equilibrium found again; to first order the variances
of what that does to the error add up. The feedback of a coupled preview is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.process.milling.milling_load import MilledForce
from compensator.solve.compensation import Compensation
from compensator.solve.unlearned_angles import AngleUncertainty
from stiffness.effects.effect import Numbers

Floats = npt.NDArray[np.float64]

MOST_POSES = 400  # cutting poses that it is found at, evenly along the path
QUANTILE = 1.959964  # of the normal distribution: 95 % lie within


@dataclass(frozen=True, repr=False)
class ErrorBand:
    """How sure the size of the predicted error is.

    Attributes:
        size: (K,) m, of the error at some cutting poses; the last two are of the 95 % size and the largest.
        shift: input, such as ``material`` or an effect -> (P, K) m: change of the size with each of its numbers.
        meant: input -> what each of the P numbers is, in words.
    """

    size: Floats
    shift: Mapping[str, Floats]
    meant: Mapping[str, tuple[str, ...]]

    def __repr__(self) -> str:
        return f"ErrorBand({len(self.size)} poses, {', '.join(self.shift)})"

    @property
    def evenly(self) -> Floats:
        """(K,) weights of the mean along the path."""
        n = len(self.size) - 2
        return np.array([1.0 / n] * n + [0.0, 0.0])

    @property
    def sd(self) -> Floats:
        """(K,) m at each pose."""
        return np.asarray(np.sqrt(sum(np.sum(s**2, axis=0) for s in self.shift.values())))

    def of(self, weights: Floats) -> float:
        """m: half of the 95 % band of a weighted mean (K,) of the sizes; an input moves all poses together."""
        return QUANTILE * float(np.sqrt(sum(np.sum((s @ weights) ** 2) for s in self.shift.values())))

    @property
    def first(self) -> dict[str, float]:
        """What should be measured first: words -> share of the variance of the mean error, the largest first."""
        weights = self.evenly
        parts: dict[str, float] = {}
        for name, shifts in self.shift.items():
            for words, s in zip(self.meant[name], shifts, strict=True):
                parts[words] = parts.get(words, 0.0) + float((s @ weights) ** 2)
        total = sum(parts.values())
        found = sorted(parts.items(), key=lambda item: -item[1])
        return {words: part / total for words, part in found if part > 0.0}

    @property
    def shares(self) -> dict[str, float]:
        """Of the variance of the mean error, by input."""
        weights = self.evenly
        parts = {name: float(np.sum((s @ weights) ** 2)) for name, s in self.shift.items()}
        total = sum(parts.values())
        return {name: part / total if total else 0.0 for name, part in parts.items()}


def error_band(c: Compensation) -> ErrorBand | None:
    """The band of the uncompensated error of a path; None where no standard deviation is known."""
    rows = band_rows(c)
    if not len(rows):
        return None
    error = c.error_before[rows]
    size = np.linalg.norm(error, axis=1)
    along = error / np.maximum(size, 1e-12)[:, None]
    found = list(_shifts(c, rows, along=along))
    names = dict.fromkeys(name for name, _, _ in found)
    shift = {name: np.array([s for n, _, s in found if n == name]) for name in names}
    meant = {name: tuple(words for n, words, _ in found if n == name) for name in names}
    return ErrorBand(size, shift, meant) if shift else None


def band_rows(c: Compensation) -> npt.NDArray[np.intp]:
    """(K,) cutting poses that the band is found at: some evenly along the path, the one at 95 % and the largest."""
    rows = np.flatnonzero(c.cutting)
    if not len(rows):
        return rows
    whole = np.linalg.norm(c.error_before[rows], axis=1)
    some = np.unique(np.linspace(0, len(rows) - 1, MOST_POSES).astype(int))
    order = np.argsort(whole, kind="stable")
    return np.asarray(rows[np.concatenate([some, order[[round(0.95 * (len(order) - 1)), -1]]])])


def _shifts(
    c: Compensation, rows: npt.NDArray[np.intp], *, along: Floats
) -> Iterator[tuple[str, str, Floats]]:
    """Input, the number of it that is moved, in words, and what that does to the size (K,) m."""
    here, load = _positions(c, rows), c.load
    if isinstance(load, MilledForce) and load.shares is not None and load.material.covariance is not None:
        variance, ways = np.linalg.eigh(load.material.covariance)
        shares = load.shares.at(rows)
        for value, way in zip(variance, ways.T, strict=True):
            if value > 1e-12 * variance[-1]:
                more = c.wrench[rows] + shares @ (way * np.sqrt(value))
                yield "material", load.material.name, np.sum((_positions(c, rows, wrench=more) - here) * along, axis=1)
    for name, words, values in _moved(c):
        there = _positions(c, rows, values={name: values})
        yield name, words, np.sum((there - here) * along, axis=1)
    for name, words, q in _turned(c, rows):
        there = _positions(c, rows, q=q)
        yield name, words, np.sum((there - here) * along, axis=1)


def _turned(c: Compensation, rows: npt.NDArray[np.intp]) -> Iterator[tuple[str, str, Floats]]:
    """Effects that are tables over joint angles, of hundreds of numbers: angles (K, n) rad with one joint off by their
    standard deviation there, to the same side all along, which is the most that its numbers can do together."""
    arm, q = c.job.arm, c.path.q[rows]
    unsure = AngleUncertainty(arm.robot, arm.effects, arm.values, arm.model.sd)
    for effect in (e for e in unsure.effects if e.name in arm.model.sd):
        sd = unsure.angles(effect, q)
        for j in np.flatnonzero(sd.any(axis=0)).tolist():
            turned = q.copy()
            turned[:, j] += sd[:, j]
            yield effect.name, f"{effect.name} of joint {j + 1}", turned


def _moved(c: Compensation) -> Iterator[tuple[str, str, Numbers]]:
    """Every effect with one of its numbers moved by its standard deviation, and which one that is; but for tables."""
    arm = c.job.arm
    for effect, values in ((e, arm.values[e.name]) for e in arm.effects if not e.angle_sd):
        name = effect.name
        for parameter, sd in arm.model.sd.get(name, {}).items():
            for k in np.flatnonzero(np.nan_to_num(np.atleast_1d(sd), posinf=0.0) > 0).tolist():
                changed = np.atleast_1d(np.array(values[parameter], dtype=float))
                changed[k] += np.atleast_1d(sd)[k]
                words = f"{name} of joint {k + 1}" if len(changed) == arm.robot.n else f"{name}: {parameter}"
                yield name, words, {**values, parameter: changed.reshape(np.shape(values[parameter]))}


def _positions(
    c: Compensation,
    rows: npt.NDArray[np.intp],
    *,
    wrench: Floats | None = None,
    values: Mapping[str, Numbers] | None = None,
    q: Floats | None = None,
) -> Floats:
    """(K, 3) m where the TCP stands, with another ``wrench``, some ``values`` of the model or commands ``q``."""
    out = np.empty((len(rows), 3))
    q = c.path.q[rows] if q is None else q
    wrench = c.wrench[rows] if wrench is None else wrench
    part = c.path.toolpath.take(rows)
    for number, r in c.job.arm.tools.rows(part):
        predictor = c.job.arm.predictors[number]
        predictor = predictor.with_values(values) if values else predictor
        out[r] = predictor.forward(q[r], wrench[r], c.state.take(rows).middle[r]).position
    return out
