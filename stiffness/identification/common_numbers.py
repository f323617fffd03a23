"""Common numbers: of numbers that one cause would make alike, one for all where the readings do not tell them apart.

The numbers v with covariance C are one where the least

    W = (v - c)' C^-1 (v - c)

over c is below the price of the numbers that it saves (log N each, Schwarz 1978). All numbers of the fit follow by
the linear constraint; nothing is fitted anew, the prediction changes within its noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stiffness.identification.fit import Fit
from stiffness.numerics.least_squares import inverse

Floats = npt.NDArray[np.float64]


def with_common_numbers(fit: Fit) -> tuple[Fit, tuple[str, ...]]:
    """The fit with one number where the readings cannot split them, and notes that say so."""
    notes = []
    for e in fit.unknowns.effects:
        for p in (p for p in e.parameters if p.common):
            at = [k for k, u in enumerate(fit.unknowns.free) if u.effect == e.name and u.parameter.name == p.name]
            if len(at) > 1:
                one = _one(fit, np.array(at))
                if one is not None:
                    fit = one
                    told = f"these readings do not tell its {len(at)} numbers apart"
                    notes.append(f"{e.name}: one common {p.name}: {told}")
    return fit, tuple(notes)


def _one(fit: Fit, at: npt.NDArray[np.intp]) -> Fit | None:
    solution = fit.solution
    covariance, vector = solution.covariance, solution.vector
    precision = inverse(covariance[np.ix_(at, at)])
    weight = precision.sum(axis=1)
    common = float(weight @ vector[at]) / float(weight.sum())
    off = common - vector[at]
    worse = float(off @ precision @ off) / solution.misfit**2
    if worse > (len(at) - 1) * np.log(max(solution.count, 8)):
        return None
    tied = precision - np.outer(weight, weight) / weight.sum()
    follow = covariance[:, at]
    moved = replace(
        solution,
        vector=vector + follow @ precision @ off,
        covariance=covariance - follow @ tied @ follow.T,
    )
    return replace(fit, solution=moved)
