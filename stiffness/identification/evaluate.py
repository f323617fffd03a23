"""Evaluate: how well a model predicts a session that it may never have seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.effects import BY_NAME
from stiffness.effects.effect import Effect
from stiffness.errors import StiffnessError
from stiffness.identification import scores
from stiffness.identification.fit import loose_sd
from stiffness.identification.session_fit import Evidence
from stiffness.identification.unknowns import unknowns
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import solve
from stiffness.session.session import Session

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
            pose, roughly known reflectors, tracker drift where the model has one); all others are scored. Default 25
            where the session is not registered, else 0.

    Raises:
        StiffnessError: the tracker's pose is unknown and nothing may estimate it.
    """
    count = register if register is not None else (0 if session.registered else REGISTER)
    if count < 0 or (count == 0 and not session.registered):
        raise StiffnessError(
            f"{session.source}: --register {count}: the session is not registered, so some states have to place "
            f"the tracker; give a number above 0 (default {REGISTER})"
        )
    chosen = _evenly(session, count)
    drift = _drift(session, model) if count else None
    evidence = evidence_of(session, model, drift)
    evidence.used = chosen
    size = len(evidence.unknowns)
    own = place(evidence) if count else np.zeros(size + evidence.station.size)
    seen = evidence.predict(own[:size], own[size:])
    evidence.used = np.ones(len(session.samples), dtype=bool)
    rest = ~chosen
    return Evaluation(
        scores.displacement(evidence, seen, rest), scores.absolute(evidence, seen, rest), int(chosen.sum())
    )


def _drift(session: Session, model: ComplianceModel) -> Effect | None:
    """The tracker's drift, where the model knows of one and this session can tell of its own."""
    timed = bool(np.isfinite(session.samples.time).any()) and float(np.nanstd(session.samples.time)) > 0
    drifts = [e for e in model.effects if e.position_reading]
    return drifts[0] if timed and drifts else None


def evidence_of(session: Session, model: ComplianceModel, free: Effect | None = None) -> Evidence:
    """The session against a model without free numbers; tool effects only with the tool they were measured with.

    Args:
        free: an effect of instruments that belongs to this session and is estimated with its station.
    """
    effects = shown_effects(model, session)
    layout = unknowns(effects, session.robot.n, [e.name for e in effects if e is not free])
    return Evidence(session, layout, {e.name: model.values[e.name] for e in effects})


def shown_effects(model: ComplianceModel, session: Session) -> tuple[Effect, ...]:
    """Effects of a model that the readings of a session show: the robot's, its tool's, and the instruments'."""
    applied, _ = model.applied(session.tool.name)
    return tuple(e for e in model.effects if e in applied or e.scope == "instruments")


def rigid_evidence(session: Session) -> Evidence:
    """The session against the nominal, rigid arm."""
    effect = BY_NAME["joint-stiffness"]
    layout = unknowns([effect], session.robot.n, [effect.name])
    return Evidence(session, layout, {effect.name: {"k_nm_per_rad": np.full(session.robot.n, 1e12)}})


def place(evidence: Evidence) -> Floats:
    """The session's own numbers (P + S,) from the readings in use: free effects of instruments, then the station."""
    shared, size = len(evidence.unknowns), len(evidence.unknowns) + evidence.station.size
    if not size:
        return np.zeros(0)
    begin = np.concatenate([evidence.unknowns.start(evidence.fixed), np.zeros(size - shared)])
    prior = np.concatenate([loose_sd(evidence.unknowns), evidence.station.prior_sd()])
    infinite = np.full(size, np.inf)
    at = slice(shared, size)
    solution = solve(
        lambda v: evidence.blocks(v[:shared], v[shared:], 0.0, at, size), begin, begin, prior, -infinite, infinite
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
