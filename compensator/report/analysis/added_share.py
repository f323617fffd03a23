"""What one addition explains of the residuals of a session: the prediction with it minus that without it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator.report.analysis.session_residuals import Floats, Index, SessionResiduals, in_base
from compensator.report.analysis.state_motion import lever_of
from stiffness.identification.predicted_readings import PredictedReadings


@dataclass(frozen=True, repr=False, eq=False)
class AddedShare:
    """One session.

    Attributes:
        rows: (M,) readings that are no outliers.
        explained: (M, 3) m, what the addition explains of each, in the base; after: (M, 3) m, what is left with it.
        rotation: (S, n) rad, what it explains of every joint's rotation in every load state.
    """

    one: SessionResiduals
    rows: Index
    explained: Floats
    after: Floats
    rotation: Floats

    def torque(self, j: int) -> Floats:
        """(S,) N*m of a joint in every load state."""
        return np.asarray(self.one.predicted.torque[self.one.session.states.first, j])


def added_share(one: SessionResiduals, without: PredictedReadings) -> AddedShare:
    """Of one session; ``without``: predicted by the refined fit without the addition, all other numbers as they are."""
    rows = np.flatnonzero(one.sound)
    first, n = one.session.states.first, one.session.robot.n
    return AddedShare(
        one=one,
        rows=rows,
        explained=in_base(one.predicted.position - without.position, one.predicted)[rows],
        after=one.after[rows],
        rotation=one.predicted.x[first, :n] - without.x[first, :n],
    )


def share_of_joint(shares: list[AddedShare], j: int) -> float:
    """How much of what an addition explains, as motion of the reflectors, is rotation of one joint."""
    whole = own = 0.0
    for s in shares:
        angle = s.rotation[s.one.session.states.of[s.rows], j]
        own += float(((lever_of(s.one, s.rows, j) * angle[:, None]) ** 2).sum())
        whole += float((s.explained**2).sum())
    return own / whole if whole > 0 else 0.0
