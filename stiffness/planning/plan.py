"""Plan: which set-ups to measure next, so that the parameters that matter are known best.

They are chosen greedily, then by exchange (Fedorov, Theory of Optimal Experiments, 1972): D-optimal, by the determinant
of the information; or V-optimal, by the mean variance of the predictions J Cov J' that the caller cares about.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stiffness.errors import StiffnessError
from stiffness.planning.design import Design, Loading, SetupPool
from stiffness.planning.postures import PosturePool

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

GUESS = 1.0  # a number that nothing is known of may be off by its own size
DETERMINED = 0.5  # as in identification
EXCHANGES = 4
ENOUGH = 1e-6  # gain in log det or log variance that is worth an exchange
SHORTLIST = 4000  # candidates that an exchange chooses from
BESIDES = 1e-4  # weight of a parameter that hardly matters to the toolpath: it still has to be determined


@dataclass(frozen=True, repr=False)
class Plan:
    """Chosen set-ups, and what is known with and without them.

    Attributes:
        design, candidates, loading: what was chosen from; ``chosen`` (K,) rows of the candidates.
        before: (P, P) information at hand, in units of ``design.scale``.
        matters: (P, P) of ``Design.of_path``; None: all parameters alike.
    """

    design: Design
    postures: PosturePool
    candidates: SetupPool
    loading: Loading
    chosen: Index
    before: Floats
    matters: Floats | None

    def __repr__(self) -> str:
        return f"Plan({len(self.chosen)} set-ups, {self.readings} readings)"

    @property
    def readings(self) -> int:
        """How many positions are to be read."""
        return len(self.chosen) * len(self.loading.steps)

    @cached_property
    def after(self) -> Floats:
        """(P, P) information with the plan measured."""
        return np.asarray(self.before + self.candidates.information[self.chosen].sum(axis=0))

    def sd(self, information: Floats) -> Floats:
        """(P,) standard deviations in units of ``design.scale``; near GUESS where nothing is known."""
        return np.asarray(np.sqrt(np.diag(_covariance(information))))

    def path_sd(self, information: Floats) -> float | None:
        """m, root of the mean variance of the deflection at the poses that matter."""
        return None if self.matters is None else float(np.sqrt(np.trace(self.matters @ _covariance(information))))

    def undetermined(self, information: Floats) -> list[str]:
        """Parameters that stay unknown, in the user's words."""
        names = []
        for u, sd in zip(self.design.layout.free, self.sd(information), strict=True):
            if sd >= DETERMINED * GUESS:
                names.append(f"{u.parameter.meaning} ({u.effect}) of joint {u.index + 1}")
        return names


def condition_number(information: Floats) -> float | None:
    """Largest over smallest singular value of a design; None where it leaves a direction open."""
    values = np.linalg.eigvalsh(information)
    return float(np.sqrt(values[-1] / values[0])) if values[0] > 1e-15 * values[-1] > 0 else None


def choose(
    design: Design, postures: PosturePool, loading: Loading, count: int, before: Floats, matters: Floats | None = None
) -> Plan:
    """The best ``count`` set-ups, each in a posture of its own.

    Raises:
        StiffnessError: more set-ups than postures.
    """
    if not 0 < count <= len(postures):
        raise StiffnessError(f"--count {count}: expected 1 ... {len(postures)}, one of the postures per set-up")
    pool = design.candidates(postures, loading)
    weight = None if matters is None else matters + BESIDES * np.trace(matters) / len(matters) * np.eye(len(matters))
    criterion = _Criterion(pool, before, weight)
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(criterion.best(np.arange(len(pool.posture)), chosen)[0])
    chosen = criterion.exchanged(criterion.shortlist(chosen), chosen)
    return Plan(
        design=design,
        postures=postures,
        candidates=pool,
        loading=loading,
        chosen=np.array(chosen),
        before=before,
        matters=matters,
    )


@dataclass(frozen=True, repr=False, eq=False)
class _Criterion:
    """The criterion of a choice of set-ups, with the information ``before`` (P, P): its log determinant, or with
    ``weight`` (P, P) less the logarithm of the weighted variance."""

    pool: SetupPool
    before: Floats
    weight: Floats | None

    def best(self, rows: Index, others: Sequence[int]) -> tuple[int, float]:
        """The candidate among ``rows``, in a new posture, that goes best with others, and the score with it."""
        score = self._score(self._sum(others) + self.pool.information[rows])
        score[np.isin(self.pool.posture[rows], self.pool.posture[list(others)])] = -np.inf
        best = int(np.argmax(score))
        return int(rows[best]), float(score[best])

    def shortlist(self, chosen: Sequence[int]) -> Index:
        """The candidates that would add most to what is chosen, and what is chosen."""
        score = self._score(self._sum(chosen) + self.pool.information)
        good = np.argsort(-score, kind="stable")[:SHORTLIST]
        return np.unique(np.concatenate([good, np.array(chosen, dtype=np.intp)]))

    def exchanged(self, rows: Index, chosen: Sequence[int]) -> list[int]:
        """The choice with set-ups replaced one by one, as long as that helps."""
        out = list(chosen)
        for _ in range(EXCHANGES):
            gained = False
            for k in range(len(out)):
                now = float(self._score(self._sum(out)[None])[0])
                best, score = self.best(rows, out[:k] + out[k + 1 :])
                if score > now + ENOUGH:
                    out[k], gained = best, True
            if not gained:
                break
        return out

    def _sum(self, chosen: Sequence[int]) -> Floats:
        return np.asarray(self.before + self.pool.information[list(chosen)].sum(axis=0))

    def _score(self, information: Floats) -> Floats:
        """(C,) the larger the better."""
        full = information + np.eye(information.shape[-1]) / GUESS**2
        if self.weight is None:
            return np.asarray(np.linalg.slogdet(full)[1])
        return np.asarray(-np.log(np.einsum("cpq,qp->c", np.linalg.inv(full), self.weight)))


def _covariance(information: Floats) -> Floats:
    return np.asarray(np.linalg.inv(information + np.eye(len(information)) / GUESS**2), dtype=float)
