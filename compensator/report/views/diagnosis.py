"""What the report of a diagnosis draws: every session's residuals in the base, with the model at hand and refined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.report.views.fit import frames
from stiffness.diagnosis.result import Diagnosis
from stiffness.identification.evaluate import predicted_by
from stiffness.identification.fit import Fit
from stiffness.identification.prediction import PredictedReadings
from stiffness.identification.session_fit import SessionFit
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, repr=False, eq=False)
class Geometry:
    """The undeflected arm at every reading, in the base: rotations (N, n+1, 3, 3) and origins (N, n+1, 3) of its
    links, axes (N, n, 3) and points on them of its joints, and where the reflector is (N, 3); m."""

    rotation: Floats
    origin: Floats
    axis: Floats
    pivot: Floats
    point: Floats


@dataclass(frozen=True, repr=False, eq=False)
class Looked:
    """One session.

    Attributes:
        fit, number: the refined fit, and which of its sessions this is.
        sound: (N,) readings that are no outliers.
        before, after: (N, 3) m, residuals in base axes: of the model at hand, and of the refined one.
        seen: what the refined fit predicts.
    """

    fit: Fit
    number: int
    geometry: Geometry
    sound: Bools
    before: Floats
    after: Floats
    seen: PredictedReadings

    @property
    def session_fit(self) -> SessionFit:
        """What the refined fit makes of the session."""
        return self.fit.sessions[self.number]

    @property
    def session(self) -> Session:
        """What was measured."""
        return self.session_fit.session


def looked_at(d: Diagnosis, model: ComplianceModel) -> tuple[Looked, ...]:
    """All sessions; where nothing was found, before and after are the same."""
    moved = bool(d.added or d.changed)
    wrong = set(d.outliers)
    out = []
    for k, fit in enumerate(d.fit.sessions):
        s = fit.samples
        sound = np.array([(fit.session.source, int(line)) not in wrong for line in s.line])
        at_hand = predicted_by(model, fit.session, fit.used)
        known = at_hand.predicted
        before = in_base(s.position - known.position, known)
        seen = fit.predicted if moved else known
        after = in_base(s.position - seen.position, seen)
        geometry = _geometry(fit.session, at_hand.reflectors)
        out.append(Looked(d.fit, k, geometry, sound, before, after, seen))
    return tuple(out)


def in_base(read: Floats, seen: PredictedReadings) -> Floats:
    """Differences (N, 3) of readings, turned from the axes that they were read in to those of the base."""
    return np.asarray(np.linalg.solve(seen.back, read[:, :, None])[:, :, 0])


def _geometry(session: Session, places: Floats) -> Geometry:
    s = session.samples
    rotation, origin, axis, pivot = frames(session.robot, s.q)
    every = np.arange(len(s))
    link = np.array([r.link for r in session.reflectors])[s.reflector]
    point = origin[every, link] + np.einsum("nij,nj->ni", rotation[every, link], places[s.reflector])
    return Geometry(rotation, origin, axis, pivot, point)


@dataclass(frozen=True, repr=False, eq=False)
class Posture:
    """One set-up of the residual map; m, in the base.

    Attributes:
        skeleton: (K, 3) base, joints and flange in order.
        link: (M, 3) for every reflector the point of the skeleton that it is fixed to.
        root: (R, 3) where readings are; before, after: (R, 3) their residuals.
        reflector: (R,) number of the reflector, from 1.
        size: RMS of ``before``, which postures are ordered by.
    """

    session: int
    setup: int
    skeleton: Floats
    link: Floats
    at: Floats
    root: Floats
    before: Floats
    after: Floats
    reflector: Ints
    size: float


def postures(looked: tuple[Looked, ...], limit: int) -> list[Posture]:
    """The set-ups with the largest residuals before, largest first."""
    out = []
    for k, seen in enumerate(looked):
        s = seen.session.samples
        for setup in np.unique(s.setup):
            rows = np.flatnonzero((s.setup == setup) & seen.sound)
            if len(rows):
                out.append(_posture(seen, k, int(setup), rows))
    return sorted(out, key=lambda p: (-round(p.size, 9), p.session, p.setup))[:limit]


def _posture(seen: Looked, session: int, setup: int, rows: npt.NDArray[np.intp]) -> Posture:
    g, s = seen.geometry, seen.session.samples
    first = rows[0]
    links, pivots = g.origin[first], g.pivot[first]
    skeleton = [links[0]]
    for k in range(len(pivots)):
        skeleton += [pivots[k], links[k + 1]]
    numbers = np.unique(s.reflector[rows])
    where = np.array([rows[s.reflector[rows] == r][0] for r in numbers])
    link = links[[seen.session.reflectors[int(r)].link for r in numbers]]
    return Posture(
        session, setup, np.array(skeleton), link, g.point[where], g.point[rows], seen.before[rows], seen.after[rows],
        s.reflector[rows] + 1, float(np.sqrt(np.mean(seen.before[rows] ** 2))),
    )  # fmt: skip
