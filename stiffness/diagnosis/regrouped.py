"""Regrouped numbers: those of an added effect that the readings know only together with another.

A link that twists about the axis of a joint and the spring of that joint move the arm alike: only the sum of the two is
told. Calibration regroups such numbers (base parameters; Khalil & Dombre, Modeling, Identification and Control of
Robots, ch. 9): one stays near nothing, the other stands for both. With the information A of data and priors, the
station eliminated, the others answer a step d_u of one number by d_o = -A_oo^-1 A_ou d_u.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import Unknown
from stiffness.numerics.least_squares import inverse

# studied in tests/stiffness/diagnosis/test_regrouped.py
OPEN = 0.95  # of the prior standard deviation: the readings say next to nothing about a number
VISIBLE = 10.0  # standard deviations by which another number answers to one that is as large as its fellows


@dataclass(frozen=True)
class Regrouped:
    """``number``: not told by the readings. ``holders``: those that stand for it as well. ``shares``: by how much each
    of them changes per change of the number, both as the solver sees them, so that the readings stay the same."""

    number: Unknown
    holders: tuple[Unknown, ...]
    shares: tuple[float, ...]

    def __str__(self) -> str:
        u = self.number
        others = " and ".join(f"{_short(h)} of {h.effect}" for h in self.holders)
        return (
            f"{u.effect}: the readings know {_short(u)} together with {others} only, which stands for both: true for "
            "this tool and these frames, not a number of one part by itself"
        )


def regrouped(fit: Fit, effects: Collection[str]) -> list[Regrouped]:
    """The numbers of ``effects`` that a fit does not tell, and those that hold what they do."""
    untold = (fit.sd > OPEN * fit.gauge.unit) | fit.gauge.chosen
    mine = [
        k
        for k, u in enumerate(fit.unknowns.free)
        if u.effect in effects and u.parameter.each == 1 and untold[k]
    ]
    found = (_regrouped(fit, k) for k in mine)
    return [r for r in found if r.holders]


def _regrouped(fit: Fit, number: int) -> Regrouped:
    """With what answers visibly when a number becomes as large as the largest of its effect in the same unit."""
    free, prior = fit.unknowns.free, fit.gauge.unit
    own = free[number]
    fellows = [
        k for k, u in enumerate(free) if (u.effect, u.parameter.unit) == (own.effect, own.parameter.unit)
    ]
    size = max(float(prior[number]), float(np.abs(fit.parameters[fellows]).max()))
    rest = np.delete(np.arange(len(free)), number)
    information = fit.gauge.information + np.diag(prior**-2.0)
    covariance = inverse(information[np.ix_(rest, rest)])
    share: npt.NDArray[np.float64] = -covariance @ information[rest, number]
    visible = np.abs(share) * size > VISIBLE * np.sqrt(np.diag(covariance))
    at = np.flatnonzero(visible & fit.determined()[rest])
    return Regrouped(own, tuple(free[k] for k in rest[at]), tuple(share[at].tolist()))


def _short(u: Unknown) -> str:
    return f"{u.parameter.name}[{u.index + 1}]"
