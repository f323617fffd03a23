"""The sessions of a fit as measured, as a rigid arm predicts them, and as the fit does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffness.identification.evaluate import place, rigid_evidence
from stiffness.identification.fit import Fit
from stiffness.identification.session_fit import Evidence, Predicted


@dataclass(frozen=True, repr=False, eq=False)
class PredictedSession:
    """One session: ``evidence`` with the readings that the fit has ``fitted``, and against the ``bare`` rigid arm."""

    evidence: Evidence
    fitted: Predicted
    bare: Evidence
    rigid: Predicted


def predicted_sessions(fit: Fit) -> tuple[PredictedSession, ...]:
    """All sessions; the rigid arm is placed by the same readings that the fit has used."""
    out = []
    for k, e in enumerate(fit.evidence):
        bare = rigid_evidence(e.session)
        bare.used = e.used
        fitted = e.predict(fit.parameters, fit.station(k))
        out.append(PredictedSession(e, fitted, bare, bare.predict(np.zeros(0), place(bare))))
    return tuple(out)
