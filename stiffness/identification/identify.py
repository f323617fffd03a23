"""Global identification: all readings of all sessions at once, on the statics that prediction uses.

The robot's parameters are shared, tracker poses and roughly known reflectors are each session's own. Wrong rows are
found and left out; what the data do not determine is reported as such.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect
from stiffness.errors import StiffnessError
from stiffness.identification.fit import Fit, fitted
from stiffness.identification.outliers import cleaned, reconsidered
from stiffness.identification.plausibility import doubts
from stiffness.identification.problem import Problem
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import start_values, unknowns
from stiffness.identification.weighting import Weighting
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session
from stiffness.session.twice import refuse_twice

Bools = npt.NDArray[np.bool_]

CHANCE = 1e-3  # false-positive rate of backlash and preload softening together
OFFSET = 0.02  # m; kinematics that are not fitted are not better known than this


def identify(
    sessions: Sequence[Session], effects: Sequence[str] | None = None, prior: ComplianceModel | None = None
) -> Fit:
    """Fit a model to sessions of one robot.

    Args:
        effects: names that fix the set; None: joint stiffness, kinematic offsets where absolute positions tell
            of them, and backlash or preload softening where the data ask for it.
        prior: values to start from; its standard deviations are prior knowledge.

    Raises:
        StiffnessError: the sessions are not of one robot, or nothing in them can be fitted.
    """
    one_robot(sessions)
    if effects is not None:
        return _robust(sessions, _named(effects), prior)
    there = {
        "load": any(s.has_displacement for s in sessions) or _sag(sessions),
        "position": any(s.has_absolute for s in sessions),
    }
    names = [e.name for e in CATALOGUE if there.get(e.fitted_where, False)]
    if prior is not None:  # what is known of the robot stays in its model
        names += [e.name for e in prior.effects if e.name not in names and e.scope != "instruments"]
    if not names:
        raise StiffnessError(
            f"{sessions[0].source}: nothing to identify: no loaded state beside an unloaded one, and the positions "
            "only place the tracker and its reflectors"
        )
    fit = _robust(sessions, _named(names), prior)
    return _with_memory(sessions, names, fit, prior)


def _sag(sessions: Sequence[Session]) -> bool:
    return any(s.gravity == "uncompensated" and s.has_absolute for s in sessions)


def _named(names: Sequence[str]) -> tuple[Effect, ...]:
    unknown = [n for n in names if n not in BY_NAME]
    if unknown:
        raise StiffnessError(f"unknown effect {', '.join(unknown)}; known are {', '.join(BY_NAME)}")
    return tuple(e for e in CATALOGUE if e.is_base or e.name in names)


def one_robot(sessions: Sequence[Session]) -> None:
    """Refuse sessions of different robots, and the same readings given twice."""
    first = sessions[0]
    refuse_twice(sessions)
    for s in sessions[1:]:
        if not s.robot.same_kinematics(first.robot) or s.gravity != first.gravity:
            raise StiffnessError(
                f"{s.source}: robot {s.robot.name} with gravity {s.gravity!r} is not that of {first.source} "
                f"({first.robot.name}, {first.gravity!r}); identify takes several sessions of one robot"
            )


def _with_memory(sessions: Sequence[Session], names: list[str], fit: Fit, prior: ComplianceModel | None) -> Fit:
    """Add backlash or preload softening where approach and two load levels are there and the data ask for it."""
    if not any(np.any(s.samples.approach != 0) for s in sessions):
        return fit
    if not any(_load_levels(s) > 1 for s in sessions):
        note = "one load level: a gap between flanks and a softer flank cannot be told apart; neither is fitted"
        return replace(fit, notes=(*fit.notes, note))
    best, gain = fit, 0.0
    candidates = [e.name for e in CATALOGUE if e.fitted_where == "approach"]
    for name in candidates:
        trial = _robust(sessions, _named([*names, name]), prior, [s.used for s in fit.sessions])
        free = sum(u.effect == name for u in trial.unknowns.free)
        scale = max(fit.solution.misfit, 1.0) ** 2
        drop = (fit.solution.chi2 - trial.solution.chi2) / scale
        if stats.chi2.sf(max(drop, 0.0), free) < CHANCE / len(candidates) and drop > gain:
            note = f"{name}: chi-square falls by {drop:.0f} for {free} numbers"
            best, gain = replace(trial, notes=(*trial.notes, note)), drop
    return best if best is fit else reconsidered(best)


def _load_levels(session: Session) -> int:
    """How many sizes of wrench a session has, apart by a third at least."""
    size = np.linalg.norm(session.samples.load.wrench[:, :3], axis=1)
    loaded = np.sort(size[size > 0.1 * size.max()]) if size.any() else np.empty(0)
    return 0 if not len(loaded) else 1 + int(loaded[-1] > 1.3 * loaded[0])


def _robust(
    sessions: Sequence[Session],
    effects: tuple[Effect, ...],
    prior: ComplianceModel | None,
    used: Sequence[Bools] | None = None,
) -> Fit:
    """Fit, look for rows that the others contradict, leave them out, fit again."""
    joints = sessions[0].robot.n
    fixed = start_values(effects, joints)
    if prior is not None:
        for name, numbers in prior.values.items():
            if name in fixed:
                fixed[name].update({k: np.array(v) for k, v in numbers.items()})
    offset = 0.0 if any(e.unloaded for e in effects) else OFFSET
    problem = Problem.of_sessions(
        data=[SessionData.of(s) for s in sessions],
        weightings=[Weighting(s, offset) for s in sessions],
        unknowns=unknowns(effects, joints, extras=True),
        fixed=fixed,
        prior=prior,
    )
    states = problem.first_states()
    if used is not None:
        states = tuple(replace(state, used=rows) for state, rows in zip(states, used, strict=True))
    fit = cleaned(fitted(problem, states))
    return replace(fit, notes=tuple(doubts(fit)))
