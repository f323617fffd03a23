"""Residual displacements of a fit joint by joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.loads import load_torque
from compensator.report.analysis.predicted import PredictedSession
from compensator.report.analysis.undeflected import undeflected
from stiffness.effects import BASE
from stiffness.identification.fit import Fit

Floats = npt.NDArray[np.float64]

FAINT = 0.02  # of the largest torque change, and of the largest motion: below, noise dominates


@dataclass(frozen=True, repr=False, eq=False)
class JointResiduals:
    """Displacements that a joint takes part in.

    Attributes:
        torque: (K,) N*m, by how much the load's torque about the joint changes from the reference.
        rigid, fitted: (K,) m, residual along the way that the reflector goes when the joint gives in to a positive
            torque.
    """

    torque: Floats
    rigid: Floats
    fitted: Floats


def joint_residuals(fit: Fit, sessions: tuple[PredictedSession, ...]) -> list[JointResiduals]:
    """Of every joint, in the order of the sessions and of their rows."""
    column = {u.index: k for k, u in enumerate(fit.unknowns.free) if u.effect == BASE.name}
    parts: list[list[JointResiduals]] = [[] for _ in range(fit.unknowns.joints)]
    for s in sessions:
        for j, found in _of_session(s, column).items():
            parts[j].append(found)
    return [JointResiduals(*(_joined([getattr(p, name) for p in part]) for name in _CURVES)) for part in parts]


_CURVES = ("torque", "rigid", "fitted")


def _joined(columns: list[Floats]) -> Floats:
    return np.concatenate(columns or [np.empty(0)])


def _of_session(s: PredictedSession, column: dict[int, int]) -> dict[int, JointResiduals]:
    """By joint; ``column``: where the derivative by the stiffness of a joint stands."""
    session, used, seen = s.fit.session, s.fit.used, s.fit.predicted
    pairs = session.pairs
    keep = used[pairs.row] & used[pairs.reference] & session.counts[pairs.row]
    row, reference = pairs.row[keep], pairs.reference[keep]
    torque = load_torque(session, undeflected(session.robot, session.samples.q))
    torque = torque[row] - torque[reference]
    measured = pairs.displacement[keep]
    rigid = measured - (s.rigid.position[row] - s.rigid.position[reference])
    fitted = measured - (seen.position[row] - seen.position[reference])
    way = seen.by_parameter[row] - seen.by_parameter[reference]
    return {j: _along(torque[:, j], way[:, :, p], rigid, fitted) for j, p in column.items()}


def _along(torque: Floats, way: Floats, rigid: Floats, fitted: Floats) -> JointResiduals:
    """Components along ``way`` (K, 3), the displacement per compliance of the joint, where there is one."""
    length = np.linalg.norm(way, axis=1)
    strong = np.abs(torque) > FAINT * np.max(np.abs(torque), initial=0.0)
    clear = strong & (length > FAINT * np.max(length, initial=0.0))
    unit = way[clear] / length[clear, None] * np.sign(torque[clear])[:, None]
    return JointResiduals(torque[clear], (rigid[clear] * unit).sum(axis=1), (fitted[clear] * unit).sum(axis=1))
