"""Robust fit: all readings of all sessions at once, on the statics that prediction uses, without wrong rows.

The robot's parameters are shared, tracker poses and roughly known reflectors are each session's own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect, Numbers
from stiffness.errors import StiffnessError
from stiffness.identification.fit import Fit
from stiffness.identification.fitting import fitted
from stiffness.identification.outliers import cleaned
from stiffness.identification.problem import Problem
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import Unknown, can_be_richer, start_values, unknowns
from stiffness.identification.weighting import Weighting
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import ROUGH
from stiffness.session.session import Session, count_setups
from stiffness.session.twice import refuse_twice

Bools = npt.NDArray[np.bool_]


class Sited(Protocol):
    """An effect in some of its places: values of all its numbers, and which of them are free."""

    @property
    def effect(self) -> Effect: ...

    @property
    def values(self) -> Numbers: ...

    def numbers(self, joints: int) -> list[Unknown]: ...


# studied in tests/stiffness/identification/test_settling_drift.py
HELD = 1e-9  # prior standard deviations: a number that is held in a fit of the others
OFFSET = 0.02  # m; kinematics that are not fitted are not better known than this


def named_effects(names: Sequence[str]) -> tuple[Effect, ...]:
    """Effects of the catalogue, the joints' springs always among them.

    Raises:
        StiffnessError: there is no such effect.
    """
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


def robust_fit(
    sessions: Sequence[Session],
    effects: tuple[Effect, ...],
    prior: ComplianceModel | None,
    used: Sequence[Bools] | None = None,
    only: Sequence[Sited] = (),
) -> Fit:
    """Fit, look for rows that the others contradict, leave them out, fit again.

    Args:
        used: per session (N,), rows that it begins with.
        only: effects that are fitted in some of their places, with values to start from.

    Raises:
        StiffnessError: a session cannot be fitted.
    """
    joints = sessions[0].robot.n
    fixed = start_values(effects, joints)
    setups = count_setups(sessions)
    layout = unknowns(effects, joints, extras=lambda e, site: not e.as_table or can_be_richer(e, setups))
    for a in only:
        fixed[a.effect.name] = {k: np.array(v) for k, v in a.values.items()}
        free = [u for u in layout.free if u.effect != a.effect.name]
        layout = replace(layout, free=(*free, *a.numbers(joints)))
    if prior is not None:
        for name, numbers in prior.values.items():
            if name in fixed:
                fixed[name].update({k: np.array(v) for k, v in numbers.items()})
    offset = 0.0 if any(e.unloaded for e in effects) else OFFSET
    problem = Problem.of_sessions(
        data=[SessionData.of(s) for s in sessions],
        weightings=[Weighting(s, offset) for s in sessions],
        unknowns=layout,
        fixed=fixed,
        prior=prior,
    )
    states = problem.first_states()
    if used is not None:
        states = tuple(replace(state, used=rows) for state, rows in zip(states, used, strict=True))
    starts = [None, *(fitted(p, states, ending=ROUGH).solution.vector for p in _elsewhere(problem))]
    begun = [fitted(problem, states, start, ending=ROUGH) for start in starts]
    return cleaned(min(begun, key=lambda f: f.solution.chi2))


def _elsewhere(problem: Problem) -> Iterator[Problem]:
    """The problem with a number that starts at a bound held at one of its trials: what it shapes may start from
    nothing, so that no slope leads away from the bound."""
    low, high = problem.unknowns.bounds()
    for k, u in enumerate(problem.unknowns.free):
        if u.parameter.neutral is None and not low[k] < problem.start[k] < high[k]:
            for trial in u.parameter.trials:
                values = {e: {name: np.array(v) for name, v in numbers.items()} for e, numbers in problem.fixed.items()}
                values[u.effect][u.parameter.name][u.index] = trial
                sd = problem.parameter_sd.copy()
                sd[k] *= HELD
                yield replace(problem, fixed=values, parameter_sd=sd)
