"""Evaluate: how well a model predicts a session that it may never have seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness import scores
from stiffness.effects import BY_NAME
from stiffness.errors import StiffnessError
from stiffness.evidence import Evidence
from stiffness.least_squares import solve
from stiffness.model import ComplianceModel
from stiffness.session import Session
from stiffness.unknowns import unknowns

Floats = npt.NDArray[np.float64]

REGISTER = 25  # states per block that place the tracker of a session that is not registered


@dataclass(frozen=True)
class Evaluation:
    """Scores on every reading that did not help to place the tracker; None where a session has no such evidence."""

    displacement: scores.Score | None
    absolute: scores.Score | None
    registered_on: int


def evaluate(session: Session, model: ComplianceModel, register: int | None = None) -> Evaluation:
    """Predict a session.

    Args:
        register: states per block, evenly by position in the file, that estimate what belongs to the set-up (tracker
            pose, roughly known reflectors); all others are scored. Default 25 where the session is not
            registered, else 0.

    Raises:
        StiffnessError: the tracker's pose is unknown and nothing may estimate it.
    """
    count = register if register is not None else (0 if session.registered else REGISTER)
    if count < 0 or (count == 0 and not session.registered):
        raise StiffnessError(
            f"{session.source}: --register {count}: the session is not registered, so some states have to place "
            f"the tracker; give a number above 0 (default {REGISTER})"
        )
    evidence = evidence_of(session, model)
    chosen = _evenly(session, count)
    evidence.used = chosen
    station = place(evidence) if count else np.zeros(evidence.station.size)
    seen = evidence.predict(np.zeros(0), station)
    evidence.used = np.ones(len(session.samples), dtype=bool)
    rest = ~chosen
    return Evaluation(
        scores.displacement(evidence, seen, rest), scores.absolute(evidence, seen, rest), int(chosen.sum())
    )


def evidence_of(session: Session, model: ComplianceModel) -> Evidence:
    """The session against a model without free numbers; tool effects only with the tool they were measured with."""
    effects, _ = model.applied(session.tool.name)
    nothing_free = unknowns(effects, session.robot.n, [e.name for e in effects])
    return Evidence(session, nothing_free, {e.name: model.values[e.name] for e in effects})


def rigid_evidence(session: Session) -> Evidence:
    """The session against the nominal, rigid arm."""
    effect = BY_NAME["joint-stiffness"]
    layout = unknowns([effect], session.robot.n, [effect.name])
    return Evidence(session, layout, {effect.name: {"k_nm_per_rad": np.full(session.robot.n, 1e12)}})


def place(evidence: Evidence) -> Floats:
    """The session's own numbers (S,) from the readings in use."""
    size = evidence.station.size
    if not size:
        return np.zeros(0)
    prior = evidence.station.prior_sd()
    none, infinite = np.zeros(size), np.full(size, np.inf)
    at = slice(0, size)
    solution = solve(
        lambda v: evidence.blocks(np.zeros(0), v, 0.0, at, size), none, none, prior, -infinite, infinite
    )
    return solution.vector


def _evenly(session: Session, count: int) -> npt.NDArray[np.bool_]:
    """(N,) readings of ``count`` states per block, evenly by position in the file."""
    chosen = np.zeros(len(session.samples), dtype=bool)
    of = session.states.of
    for block in np.unique(session.samples.block) if count else ():
        rows = np.flatnonzero(session.samples.block == block)
        _, first = np.unique(of[rows], return_index=True)
        states = of[rows[np.sort(first)]]
        picked = states[np.round(np.linspace(0, len(states) - 1, min(count, len(states)))).astype(int)]
        chosen[rows] |= np.isin(of[rows], picked)
    return chosen
