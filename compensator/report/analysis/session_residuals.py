"""The residuals of every session of a diagnosis in the base, with the model at hand and with the refined one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.undeflected import UndeflectedArm, undeflected
from stiffness.diagnosis.result import Diagnosis
from stiffness.identification.evaluate import predicted_by
from stiffness.identification.fit import Fit
from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, repr=False, eq=False)
class SessionResiduals:
    """One session.

    Attributes:
        fit, number: the refined fit, and which of its sessions this is.
        arm: the undeflected arm at every reading.
        reflector: (N, 3) m, where the reflector is on the undeflected arm, in the base.
        sound: (N,) readings that are no outliers.
        before, after: (N, 3) m, residuals in base axes: of the model at hand, and of the refined one.
        predicted: by the refined fit.
    """

    fit: Fit
    number: int
    arm: UndeflectedArm
    reflector: Floats
    sound: Bools
    before: Floats
    after: Floats
    predicted: PredictedReadings

    @property
    def session(self) -> Session:
        """The session as measured."""
        return self.fit.sessions[self.number].session

    @property
    def link(self) -> Ints:
        """(N,) the link that the reflector of each reading is fixed to."""
        return np.array([r.link for r in self.session.reflectors])[self.session.samples.reflector]


def session_residuals(d: Diagnosis, model: ComplianceModel) -> tuple[SessionResiduals, ...]:
    """All sessions; where nothing was found, before and after are the same."""
    return tuple(_residuals(d, model, k) for k in range(len(d.fit.sessions)))


def _residuals(d: Diagnosis, model: ComplianceModel, number: int) -> SessionResiduals:
    refined = d.fit.sessions[number]
    session, s = refined.session, refined.samples
    at_hand = predicted_by(model, session, refined.used)
    before = at_hand.predicted
    after = refined.predicted if d.added or d.changed else before
    outliers = set(d.outliers)
    arm = undeflected(session.robot, s.q)
    link = np.array([r.link for r in session.reflectors])[s.reflector]
    return SessionResiduals(
        fit=d.fit,
        number=number,
        arm=arm,
        reflector=arm.link_of_each(link).at(at_hand.reflectors[s.reflector]),
        sound=np.array([(session.source, int(line)) not in outliers for line in s.line]),
        before=in_base(s.position - before.position, before),
        after=in_base(s.position - after.position, after),
        predicted=after,
    )


def in_base(read: Floats, predicted: PredictedReadings) -> Floats:
    """Differences (N, 3) of readings, turned from the axes that they were read in to those of the base; of readings of
    one number, along the direction that they were read in."""
    if not predicted.back[:, 1:].any():
        return np.asarray(np.einsum("nji,nj->ni", predicted.back, read))
    return np.asarray(np.linalg.solve(predicted.back, read[:, :, None])[:, :, 0])
