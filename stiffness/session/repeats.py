"""Repeats: the noise as repeated readings show it, compared with the data sheet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from stiffness.session.session import Session

ENOUGH = 30  # degrees of freedom from which repeats are believed
APART = 1e-3  # chance below which repeats and data sheet disagree


@dataclass(frozen=True)
class Repeats:
    """Scatter of repeated readings over that of the data sheet.

    Attributes:
        ratio: of standard deviations; 1 where there are no repeats.
        freedom: degrees of freedom behind it.
        disagree: whether the two cannot both be right.
    """

    ratio: float
    freedom: int
    disagree: bool

    @property
    def sentence(self) -> str:
        """For the report; "" without repeats."""
        if not self.freedom:
            return ""
        said = f"{self.freedom} repeated numbers scatter {self.ratio:.2f} times as much as the data sheet says"
        return f"{said}: the repeats are believed" if self.disagree and self.freedom >= ENOUGH else said


def repeats(session: Session) -> Repeats:
    """Compare readings of one state and reflector with each other: positions are all that is compared."""
    s = session.samples
    key = np.column_stack([s.setup, s.state, s.reflector, s.block])
    _, of, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    of = of.reshape(-1)
    scaled = s.position / s.sd
    mean = np.stack([np.bincount(of, scaled[:, k]) for k in range(3)], axis=1) / count[:, None]
    freedom = 3 * int((count - 1).sum())
    if freedom == 0:
        return Repeats(1.0, 0, False)
    chi2 = float(((scaled - mean[of]) ** 2).sum())
    chance = min(stats.chi2.sf(chi2, freedom), stats.chi2.cdf(chi2, freedom))
    return Repeats(float(np.sqrt(chi2 / freedom)), freedom, bool(chance < APART))


def with_repeats(session: Session) -> tuple[Session, Repeats]:
    """The session with the noise that is believed: repeats where they are many and disagree with the data sheet."""
    found = repeats(session)
    if not (found.disagree and found.freedom >= ENOUGH):
        return session, found
    return replace(session, samples=replace(session.samples, sd=session.samples.sd * found.ratio)), found
