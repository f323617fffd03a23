"""Fitting: least squares of a problem, its prior weighed against what the model leaves unexplained."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.problem import Problem, States
from stiffness.numerics.least_squares import EXACT, GLANCE, ROUGH, Ending

Floats = npt.NDArray[np.float64]


def fitted(
    problem: Problem,
    states: States,
    start: Floats | None = None,
    *,
    notes: tuple[str, ...] = (),
    once: bool = False,
    widened: float = 1.0,
    ending: Ending = EXACT,
) -> Fit:
    """Least squares of a problem.

    Args:
        states: where the evaluations start. start: (V,) first vector; None: the mean of the prior.
        once: priors are too loose to be weighed anew. widened: factor on the noise that they are weighed against at
            first. ending: what ends the iteration.
    """
    # what the model does not explain is noise to its parameters: the prior weighs more against it, how much shows soon
    first = ROUGH if once else GLANCE
    begun = states
    solution, states = problem.solved(states, start, widened=widened, ending=first)
    if solution.misfit < CLEAR and ending != first:
        solution, states = problem.solved(states, solution.vector, widened=widened, ending=ending)
    if solution.misfit > widened and not once:
        begin: Floats | None = solution.vector
        if problem.surprise(solution.vector) * solution.misfit**2 > solution.chi2:
            # what the data hardly determine went far out to imitate what is missing: the way back is a narrow valley
            begin, states = start, begun
        solution, states = problem.solved(states, begin, widened=solution.misfit, ending=ending)
    return Fit(problem, solution, states, notes)
