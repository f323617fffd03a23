"""Evaluate: how well a model predicts a session that it may never have seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect, Numbers
from stiffness.errors import StiffnessError
from stiffness.identification import scores
from stiffness.identification.isolated import isolated_rows
from stiffness.identification.problem import Problem
from stiffness.identification.registration import as_declared
from stiffness.identification.session_data import SessionData
from stiffness.identification.session_fit import SessionFit
from stiffness.identification.unknowns import Unknowns, unknowns
from stiffness.identification.weighting import Weighting
from stiffness.model.model import ComplianceModel
from stiffness.session.far_readings import far_rows
from stiffness.session.processes import process_of
from stiffness.session.session import Session

Bools = npt.NDArray[np.bool_]

RIGID = 1e12  # N*m/rad
PLACINGS = 3  # of the tracker, without the wrong rows that the last placing showed
REGISTER = 25  # states per block that place the tracker of a session that is not registered


@dataclass(frozen=True)
class Evaluation:
    """Scores on every reading that did not help to place the tracker; None where a session cannot tell.

    Attributes:
        displacement, absolute, path: without wrong rows; ``with_wrong``: by kind, with them.
        registered_on: readings that placed the tracker.
        wrong: (N,) readings that were left out: gross errors, and single rows that nothing else of their state shares.
        seen: the session as predicted; the readings that are not wrong are in use.
    """

    displacement: scores.Score | None
    absolute: scores.Score | None
    path: scores.Score | None
    registered_on: int
    with_wrong: Mapping[str, scores.Score | None]
    wrong: Bools
    seen: SessionFit


def evaluate(session: Session, model: ComplianceModel, register: int | None = None) -> Evaluation:
    """Predict a session.

    Args:
        register: states per block, evenly by position in the file, that estimate what belongs to the set-up (tracker
            pose, roughly known reflectors, tracker drift where the model has one; centre and length of a ball-bar); all
            others are scored. Default 25 where there is anything of that kind to place (a third of the states where
            that would be all of them), else 0.

    Raises:
        StiffnessError: the tracker's pose is unknown and nothing may estimate it, or everything does.
    """
    path = session.path
    own = path is not None and (path.kind == "ballbar" or path.lagging or path.probe_sd > 0)
    placing = not session.registered or own
    count = register if register is not None else (REGISTER if placing else 0)
    if count < 0 or (count == 0 and placing):
        raise StiffnessError(
            f"{session.source}: --register {count}: the session is not registered, so some states have to place "
            f"the tracker{' (a ball-bar: its centre)' if session.path else ''}; give a number above 0 (default "
            f"{REGISTER})"
        )
    chosen = _evenly(session, count)
    states = len(np.unique(session.states.of))
    if register is None and chosen.all():  # a small session: a third of it places the tracker
        chosen = _evenly(session, max(states // (3 * len(np.unique(session.samples.block))), 1))
    if chosen.all():
        raise StiffnessError(
            f"{session.source}: --register {count}: all {states} states place the tracker and none is left to be "
            f"scored; give fewer, such as --register {max(states // 3, 1)}"
        )
    free = _drift(session, model) if count else None
    wrong = far = far_rows(session)
    for _ in range(PLACINGS):
        placed = predicted_by(model, session, chosen & ~wrong, free)
        before, wrong = wrong, far | isolated_rows(session, placed.predicted)
        if np.array_equal(before & chosen, wrong & chosen):
            break
    seen, rest, every = placed.predicted, ~chosen, np.ones(len(session.samples), dtype=bool)
    return Evaluation(
        displacement=scores.displacement(session, seen, rest, ~wrong),
        absolute=scores.absolute(session, seen, rest, ~wrong),
        path=scores.path(session, seen, rest, ~wrong),
        registered_on=int(chosen.sum()),
        with_wrong={kind: judge(session, seen, rest, every) for kind, judge in scores.KINDS.items()},
        wrong=wrong,
        seen=replace(placed, state=replace(placed.state, used=~wrong)),
    )


def _drift(session: Session, model: ComplianceModel) -> Effect | None:
    """The tracker's drift, where the model knows of one and this session can tell of its own."""
    timed = bool(np.isfinite(session.samples.time).any()) and float(np.nanstd(session.samples.time)) > 0
    drifts = [e for e in model.effects if e.position_reading]
    return drifts[0] if timed and drifts else None


def predicted_by(model: ComplianceModel, session: Session, used: Bools, free: Effect | None = None) -> SessionFit:
    """A session as a model without free numbers predicts it; tool effects only with the tool they were measured with.

    Args:
        used: (N,) readings that estimate what belongs to the set-up: tracker poses, roughly known reflectors.
        free: an effect of instruments that belongs to this session and is estimated with its station.
    """
    effects = shown_effects(model, session)
    layout = unknowns(effects, session.robot.n, [e.name for e in effects if e is not free])
    return _placed(session, layout, {e.name: model.values[e.name] for e in effects}, used)


def predicted_rigid(session: Session, used: Bools) -> SessionFit:
    """A session as the nominal, rigid arm predicts it, placed by the ``used`` (N,) readings."""
    base = [e for e in CATALOGUE if e.is_base]
    layout = unknowns(base, session.robot.n, [e.name for e in base])
    rigid = {e.name: {p.name: np.full(session.robot.n, RIGID) for p in e.parameters} for e in base}
    return _placed(session, layout, rigid, used)


def shown_effects(model: ComplianceModel, *sessions: Session) -> tuple[Effect, ...]:
    """Effects of a model that the readings of sessions show: the robot's, its tool's, the instruments', and those of
    the process that was traced."""
    applied, _ = model.applied(sessions[0].tool.name)
    process = process_of(sessions) if any(s.path is not None for s in sessions) else None
    shown = (*applied, *(e for e in model.effects if e.scope == "instruments" or model.of_process(e, process)))
    return tuple(e for e in model.effects if e in shown)


def _placed(session: Session, layout: Unknowns, fixed: Mapping[str, Numbers], used: Bools) -> SessionFit:
    """The session with its own numbers estimated from the readings in use: free effects of instruments, the station."""
    problem = as_declared(Problem.of_sessions([SessionData.of(session)], [Weighting(session, 0.0)], layout, fixed))
    states = tuple(replace(s, used=used) for s in problem.first_states())
    vector = problem.start
    if len(vector) and used.any():
        solution, states = problem.solved(states, bounded=False)
        vector = solution.vector
    (placed,) = problem.sessions(vector, states)
    return placed


def _evenly(session: Session, count: int) -> Bools:
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
