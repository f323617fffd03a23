"""Registration: whether what a session declares of the tracker's frame is what its readings say.

A registration is a measurement: while effects are compared, what it misses by is estimated within ``REGISTERED_SD``, so
that no effect stands in for it. In the end the frame is taken as it was declared where the readings allow that.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import stats

from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.observations import SessionObservations
from stiffness.identification.placed_station import PlacedTracker, placed_trackers
from stiffness.identification.problem import Problem

# studied in tests/stiffness/identification/test_registration.py
CHANCE = 1e-6  # of so much less chi-square where a frame is as it was declared


def with_registration(fit: Fit) -> Fit:
    """The fit with registered frames as they were declared, where that raises chi-square no more than chance would."""
    problem = as_declared(fit.problem)
    pairs = zip(fit.problem.observations, problem.observations, strict=True)
    moved = [k for k, (fitted, declared) in enumerate(pairs) if fitted is not declared]
    if not moved:
        return fit
    poses = np.concatenate([_poses(fit, k) for k in moved])
    vector = fit.solution.vector.copy()
    vector[poses] = 0.0
    solution, states = problem.solved(fit.states, vector, widened=fit.solution.misfit)
    rise = (solution.chi2 - fit.solution.chi2) / fit.solution.misfit**2
    if stats.chi2.sf(max(rise, 0.0), len(poses)) < CHANCE:
        return fit
    return replace(fit, problem=problem, solution=solution, states=states)


def as_declared(problem: Problem) -> Problem:
    """A problem whose registered frames are taken as they were declared."""
    every = (_exact(o) if isinstance(o, SessionObservations) else o for o in problem.observations)
    return replace(problem, observations=tuple(every))


def missed_frames(fit: Fit) -> list[PlacedTracker]:
    """Registered frames that the readings contradict, after ``with_registration``; none of a model that lacks
    something, which a frame may imitate."""
    registered = {s.session.source for s in fit.sessions if s.session.registered}
    return [t for t in placed_trackers(fit) if t.session in registered] if fit.solution.misfit < CLEAR else []


def _exact(o: SessionObservations) -> SessionObservations:
    """With its frame as it was declared, where it was."""
    return replace(o, exact=True) if o.session.registered and len(o.data.station.blocks) and not o.exact else o


def _poses(fit: Fit, k: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Where the numbers of a session's tracker poses stand."""
    o, at = fit.problem.observations[k], fit.problem.columns[k]
    count = 6 * len(o.data.station.blocks) if isinstance(o, SessionObservations) else 0
    return np.arange(at.start, at.start + count)
