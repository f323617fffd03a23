"""Registration: whether what a session declares of the tracker's frame is what its readings say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import stats

from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.observations import SessionObservations
from stiffness.identification.problem import Problem

# studied in tests/stiffness/identification/test_registration.py
CHANCE = 1e-6  # of so much less chi-square where a frame is as it was declared


def with_registration(fit: Fit) -> tuple[Fit, tuple[str, ...]]:
    """The fit with registered frames as they were declared where its readings allow that; else with a note of how far
    they are off. Where the model lacks something a frame may imitate it: it stays as it was fitted."""
    observations = fit.problem.observations
    problem = as_declared(fit.problem)
    exact = problem.observations
    moved = [k for k, (a, b) in enumerate(zip(observations, exact, strict=True)) if a is not b]
    if not moved:
        return fit, ()
    vector = fit.solution.vector.copy()
    poses = np.concatenate([_poses(fit, k) for k in moved])
    vector[poses] = 0.0
    solution, states = problem.solved(fit.states, vector, widened=fit.solution.misfit)
    rise = (solution.chi2 - fit.solution.chi2) / fit.solution.misfit**2
    if stats.chi2.sf(max(rise, 0.0), len(poses)) > CHANCE:
        return replace(fit, problem=problem, solution=solution, states=states), ()
    if fit.solution.misfit > CLEAR:
        return fit, ()
    off = fit.solution.vector[poses].reshape(-1, 2, 3)
    far, turned = 1e3 * np.linalg.norm(off, axis=2).max(axis=0)
    return fit, (
        f"registration: the readings find the declared frame {far:.2g} mm and {turned:.2g} mrad off the robot's base "
        f"(chi-square falls by {rise:.0f} for {len(poses)} numbers): positions of this model count from the robot's "
        "own base; register anew, or give registered = false",
    )


def as_declared(problem: Problem) -> Problem:
    """A problem whose registered frames are taken as they were declared."""
    every = (_exact(o) if isinstance(o, SessionObservations) else o for o in problem.observations)
    return replace(problem, observations=tuple(every))


def _exact(o: SessionObservations) -> SessionObservations:
    """With its frame as it was declared, where it was."""
    registered = o.session.registered and o.session.path is None and len(o.data.station.blocks)
    return replace(o, exact=True) if registered and not o.exact else o


def _poses(fit: Fit, k: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Where the numbers of a session's tracker poses stand."""
    o, at = fit.problem.observations[k], fit.problem.columns[k]
    count = 6 * len(o.data.station.blocks) if isinstance(o, SessionObservations) else 0
    return np.arange(at.start, at.start + count)
