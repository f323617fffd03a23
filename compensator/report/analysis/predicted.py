"""The sessions of a fit: as the fit left them, and as a rigid arm predicts them."""

from __future__ import annotations

from dataclasses import dataclass

from stiffness.identification.evaluate import predicted_rigid
from stiffness.identification.fit import Fit
from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.identification.session_fit import SessionFit


@dataclass(frozen=True, repr=False, eq=False)
class PredictedSession:
    """One session: ``fit`` has its readings and what the fit predicts of them, ``rigid`` what a rigid arm does."""

    fit: SessionFit
    rigid: PredictedReadings


def predicted_sessions(fit: Fit) -> tuple[PredictedSession, ...]:
    """All sessions; the rigid arm is placed by the same readings that the fit has used."""
    return tuple(PredictedSession(s, predicted_rigid(s.session, s.used).predicted) for s in fit.sessions)
