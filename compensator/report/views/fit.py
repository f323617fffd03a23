"""What the report of a fit shows: residuals before (rigid) and after, per reflector, per joint, and standardised."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.effects import BASE
from stiffness.identification import scores
from stiffness.identification.evaluate import predicted_rigid
from stiffness.identification.fit import Fit
from stiffness.identification.prediction import PredictedReadings
from stiffness.identification.scores import Score
from stiffness.identification.session_fit import SessionFit
from stiffness.robot.robot import STANDARD_GRAVITY, Robot
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Judge = Callable[[Session, PredictedReadings, Bools, Bools], Score | None]

KINDS: tuple[tuple[str, Judge], ...] = (("displacement", scores.displacement), ("absolute", scores.absolute))
FAINT = 0.02  # of the largest torque change: less says nothing of a joint


@dataclass(frozen=True, repr=False, eq=False)
class Seen:
    """One session as the fit left it, and as the rigid arm predicts it."""

    fit: SessionFit
    rigid: PredictedReadings


@dataclass(frozen=True)
class AtReflector:
    """Residuals of one reflector, RMS per axis, m; ``floor``: what noise alone leaves."""

    name: str
    link: int
    count: int
    rigid: float
    fitted: float
    floor: float


@dataclass(frozen=True, repr=False, eq=False)
class AtJoint:
    """Displacements that a joint takes part in.

    Attributes:
        torque: (K,) N*m, by how much the load's torque about the joint changes from the reference.
        rigid, fitted: (K,) m, residual along the way that the reflector goes when the joint gives in to a positive
            torque.
    """

    torque: Floats
    rigid: Floats
    fitted: Floats


def looked_at(fit: Fit) -> tuple[Seen, ...]:
    """Predictions of all sessions; the rigid arm is placed by the same readings that the fit has used."""
    return tuple(Seen(s, predicted_rigid(s.session, s.used).predicted) for s in fit.sessions)


def reflectors(seen: tuple[Seen, ...], judge: Judge) -> list[AtReflector]:
    """Residuals per reflector, sessions pooled where name and link are the same; in the order of the files."""
    found: dict[tuple[str, int], list[tuple[Score, Score]]] = {}
    for s in seen:
        session, used = s.fit.session, s.fit.used
        for k, r in enumerate(session.reflectors):
            rows = used & (session.samples.reflector == k)
            before, after = judge(session, s.rigid, rows, used), judge(session, s.fit.predicted, rows, used)
            if before is not None and after is not None:
                found.setdefault((r.name, r.link), []).append((before, after))
    out = []
    for (name, link), pairs in found.items():
        before, after = scores.pooled([b for b, _ in pairs]), scores.pooled([a for _, a in pairs])
        if before is not None and after is not None:
            out.append(AtReflector(name, link, after.count, before.rms, after.rms, after.noise_floor))
    return out


def joints(fit: Fit, seen: tuple[Seen, ...]) -> list[AtJoint]:
    """Residual displacements joint by joint, in the order of the sessions and of their rows."""
    n = fit.unknowns.joints
    column = {u.index: k for k, u in enumerate(fit.unknowns.free) if u.effect == BASE.name}
    parts: list[list[AtJoint]] = [[] for _ in range(n)]
    for s in seen:
        pairs, session, seen_by_fit = s.fit.session.pairs, s.fit.session, s.fit.predicted
        keep = s.fit.used[pairs.row] & s.fit.used[pairs.reference] & session.counts[pairs.row]
        row, reference = pairs.row[keep], pairs.reference[keep]
        torque = load_torque(session)
        torque = torque[row] - torque[reference]
        measured = pairs.displacement[keep]
        rigid = measured - (s.rigid.position[row] - s.rigid.position[reference])
        fitted = measured - (seen_by_fit.position[row] - seen_by_fit.position[reference])
        for j, p in column.items():
            way = seen_by_fit.by_parameter[row, :, p] - seen_by_fit.by_parameter[reference, :, p]
            parts[j].append(_along(torque[:, j], way, rigid, fitted))
    return [
        AtJoint(*(np.concatenate([getattr(a, name) for a in part] or [np.empty(0)]) for name in _CURVES))
        for part in parts
    ]


_CURVES = ("torque", "rigid", "fitted")


def _along(torque: Floats, way: Floats, rigid: Floats, fitted: Floats) -> AtJoint:
    """Components along ``way`` (K, 3), the displacement per compliance of the joint, where there is one."""
    length = np.linalg.norm(way, axis=1)
    strong = np.abs(torque) > FAINT * np.max(np.abs(torque), initial=0.0)
    told = strong & (length > FAINT * np.max(length, initial=0.0))
    unit = way[told] / length[told, None] * np.sign(torque[told])[:, None]
    return AtJoint(torque[told], (rigid[told] * unit).sum(axis=1), (fitted[told] * unit).sum(axis=1))


def load_torque(session: Session) -> Floats:
    """(N, n) N*m: torque of load and payload about each joint of the undeflected arm, z . ((p - o) x f + m)."""
    s = session.samples
    rotation, origin, axis, pivot = frames(session.robot, s.q)
    every = np.arange(len(s))
    tool = rotation[:, -1] @ session.tool.rotation
    turn = np.where(s.load.in_tool[:, None, None], tool, np.eye(3))
    force, moment = _turned(turn, s.load.wrench[:, :3]), _turned(turn, s.load.wrench[:, 3:])
    point = origin[every, s.load.point_link] + _turned(rotation[every, s.load.point_link], s.load.point)
    com = np.zeros(3) if session.tool.com is None else session.tool.com
    weight = s.payload[:, None] * np.array(STANDARD_GRAVITY)
    hung = origin[:, -1] + rotation[:, -1] @ com
    out = np.zeros((len(s), session.robot.n))
    for j in range(session.robot.n):
        pull = np.cross(point - pivot[:, j], force) + moment
        pull = np.where((s.load.link > j)[:, None], pull, 0.0) + np.cross(hung - pivot[:, j], weight)
        out[:, j] = np.einsum("ni,ni->n", axis[:, j], pull)
    return out


def frames(robot: Robot, q: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Links of the undeflected arm, base first: rotations (N, n+1, 3, 3), origins (N, n+1, 3); and of each joint
    its axis and a point on it, (N, n, 3) each, in the base."""
    turn, at = np.tile(np.eye(3), (len(q), 1, 1)), np.zeros((len(q), 3))
    rotation, origin, axis, pivot = [turn], [at], [], []
    for k in range(robot.n):
        at = at + turn @ robot.before[k, :3, 3]
        turn = turn @ robot.before[k, :3, :3]
        axis.append(turn @ robot.axis[k])
        pivot.append(at)
        turn = turn @ Rotation.from_rotvec(q[:, k, None] * robot.axis[k]).as_matrix()
        at = at + turn @ robot.after[k, :3, 3]
        turn = turn @ robot.after[k, :3, :3]
        rotation.append(turn)
        origin.append(at)
    return np.stack(rotation, 1), np.stack(origin, 1), np.stack(axis, 1), np.stack(pivot, 1)


def _turned(rotation: Floats, vector: Floats) -> Floats:
    return np.asarray(np.einsum("nij,nj->ni", rotation, vector))


def standardised(fit: Fit) -> Floats:
    """Residuals made independent and divided by the noise that the instruments state; normal where the model holds.

    The number that carries the free offset of a reflector in its set-up is no residual: it is left out.
    """
    out = []
    for s in fit.sessions:
        offset = s.observations.weighting.offset
        for block in s.blocks():
            out.append(block.residual[np.diag(block.factor) < 0.5 * offset] if offset else block.residual)
    return np.concatenate(out) if out else np.empty(0)
