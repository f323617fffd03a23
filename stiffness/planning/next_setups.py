"""Next set-ups: what to measure so that two explanations predict different readings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.arm_loads import ArmLoads, LoadKind
from stiffness.identification.fit import Fit
from stiffness.planning.postures import reachable_postures
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]

POOL = 60  # postures
WANTED = 3
SEED = 4
ROUNDS = 2  # of equilibrium
_WAYS = np.concatenate([np.eye(3), -np.eye(3)])


@dataclass(frozen=True)
class NextSetup:
    """``q`` (n,) rad, ``wrench`` (6,) N and N*m on the robot, base axes, about the TCP; reflectors that show most.

    ``why``: one sentence; ``apart``: m, how far the readings of the two explanations are from each other.
    """

    q: Floats
    wrench: Floats
    reflectors: tuple[str, ...]
    why: str
    apart: float


def splitting(first: Fit, second: Fit, why: str) -> list[NextSetup]:
    """Set-ups where two fits of the same sessions predict readings that are farthest apart."""
    session = first.sessions[0].session
    tool = session.tool.tool()
    pool = reachable_postures(session.robot, tool, POOL, SEED)
    force = largest_force(session)
    loads = np.concatenate([np.zeros((1, 3)), _WAYS * force]) if force > 0 else np.zeros((1, 3))
    q = np.repeat(pool.q, len(loads), axis=0)
    wrench = np.hstack([np.tile(loads, (len(pool), 1)), np.zeros((len(q), 3))])
    difference = np.stack([_readings(first, q, wrench) - _readings(second, q, wrench)])[0]  # (K, R, 3)
    apart = np.linalg.norm(difference, axis=2).reshape(len(pool), len(loads), -1)
    out: list[NextSetup] = []
    score = apart.max(axis=(1, 2))
    for _ in range(min(WANTED, len(pool))):
        k = int(np.argmax(score))
        load = int(np.argmax(apart[k].max(axis=1)))
        order = np.argsort(-apart[k, load])
        names = tuple(session.reflectors[int(r)].name for r in order[: max(1, min(2, len(order)))])
        pulled = wrench[k * len(loads) + load]
        out.append(NextSetup(q=pool.q[k], wrench=pulled, reflectors=names, why=why, apart=float(score[k])))
        near = np.linalg.norm(pool.q - pool.q[k], axis=1) < 1.0  # the next one elsewhere
        score = np.where(near, -1.0, score)
        if score.max() <= 0:
            break
    return out


def spread(session: Session, joint: int | None, why: str) -> list[NextSetup]:
    """Set-ups over the whole range of one joint, or of all, with the largest load of the session across the arm; no
    posture twice."""
    robot, tool = session.robot, session.tool.tool()
    pool = reachable_postures(robot, tool, POOL, SEED)
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    force = largest_force(session)
    out: list[NextSetup] = []
    left = np.arange(len(pool))
    for k in range(min(WANTED, len(pool))):
        if joint is None:
            near = np.abs(left - k * len(pool) / WANTED)
        else:
            near = np.abs(pool.q[left, joint] - (low[joint] + (high[joint] - low[joint]) * (k + 0.5) / WANTED))
        q = pool.q[left[int(np.argmin(near))]]
        left = np.delete(left, int(np.argmin(near)))
        wrench = np.concatenate([_WAYS[k] * force, np.zeros(3)])
        names = tuple(r.name for r in session.reflectors)
        out.append(NextSetup(q=q, wrench=wrench, reflectors=names, why=why, apart=0.0))
    return out


def largest_force(session: Session) -> float:
    """N, of all loads of a session."""
    return float(np.linalg.norm(session.samples.load.wrench[:, :3], axis=1).max(initial=0.0))


def _readings(fit: Fit, q: Floats, wrench: Floats) -> Floats:
    """(K, R, 3) m: every reflector of the first session in the base, flanks in the middle of their gaps."""
    first = fit.sessions[0]
    model, session, n = first.observations.predictor.model, first.session, first.session.robot.n
    count = len(q)
    loads = ArmLoads(
        q=q,
        wrench=wrench,
        point=np.tile(session.tool.tool().position, (count, 1)),
        state=np.zeros((count, model.statics.n_state)),
        payload=np.zeros((count, 1)),
        warm=np.zeros((count, 1)),
    )
    x = np.zeros((count, model.n_x))
    for _ in range(ROUNDS):
        arms = model.equilibria(LoadKind(n, n, False), fit.parameters, loads, x)
        x = arms.x
    links = [r.link for r in session.reflectors]
    seen = [
        model.positions(arms, k, np.tile(at, (count, 1))).position
        for k, at in zip(links, first.reflectors, strict=True)
    ]
    return np.stack(seen, axis=1)
