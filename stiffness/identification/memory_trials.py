"""Memory trials: a fit with other values of numbers that only the rules of joint memories read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers
from stiffness.identification.observations import SessionObservations
from stiffness.identification.problem import Problem, States
from stiffness.numerics.least_squares import lowest
from stiffness.numerics.whitened import Whitened

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class MemoryTrials:
    """Arms at rest at one vector of a fit: what other joint states change there is of first order, so that a trial
    solves for no equilibrium.

    Attributes:
        vector: (V,). states: where the solution starts, one per observations.
    """

    problem: Problem
    vector: Floats
    states: States

    def __repr__(self) -> str:
        return f"MemoryTrials({self.problem!r})"

    @cached_property
    def _at_rest(self) -> States:
        """Where the arms rest at the vector."""
        return self.problem.blocks(self.vector, self.states)[1]

    def chi2(self, fixed: Mapping[str, Numbers]) -> float:
        """Chi-square, prior included, with the memory's numbers of ``fixed``, all free numbers refitted in the model
        linearised at the vector: a profile of the likelihood."""
        p, parts = self.problem, list[Whitened]()
        for o, at, state in zip(p.observations, p.columns, self._at_rest, strict=True):
            if isinstance(o, SessionObservations):
                parts += o.with_memory_values(fixed).blocks_near(state, self.vector, at)
            else:
                parts += o.blocks(state, self.vector, at)[0]
        low, high = p.bounds()
        return lowest(parts, self.vector, prior=p.start, prior_sd=p.sd, low=low, high=high)
