"""Preload softening: a joint is softer while its torque acts against its last rotation.

    dq = (1/r - 1) tau/K   where tau * d < 0,   0 where tau * d > 0      (on top of joint-stiffness)

d is the direction of the last rotation, r the ratio of non-loaded to pre-loaded stiffness
(Berntsen, Bertheussen, Tyapin, Table 4: joint 1, 0.758 / 1.015 = 0.747). The deflection is continuous
in torque, and in d, which passes from -1 to 1 within a travel of REVERSAL: rounding in a command is no
reversal. An unknown direction, d = 0, gets the mean of both.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from stiffness.effects.effect import REVERSAL, Effect, Floats, JointInput, Numbers, Parameter, Values
from stiffness.effects.memory import Clamp, Memory


def _law(given: JointInput, p: Values) -> ca.SX:
    against = 0.5 * (given.elastic - given.state * ca.fabs(given.elastic))  # 0 with d, elastic against it
    return (1 / p["ratio"] - 1) * against


def _rule(move: Floats, torque: Floats, p: Numbers, stiffness: Floats) -> Clamp:
    one = np.ones_like(move)
    return Clamp(move / (0.5 * REVERSAL), -one, one)


EFFECT = Effect(
    name="preload-softening",
    cause="the flank that carries the load is softer when the joint was not pre-loaded against it",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="ratio",
            unit="1",
            size="joint",
            start=0.85,
            low=0.05,
            high=1.0,
            scale=0.1,
            meaning="non-loaded over pre-loaded stiffness",
            fit="inverse",
            neutral=1.0,
        ),
    ),
    joint=_law,
    memory=Memory(
        unit="1",
        rule=_rule,
        bounds=lambda p: 1 + 0 * p["ratio"],
        meaning="the direction of the last rotation, up is positive",
    ),
    needs_torque_sign=True,
    fitted_where="approach",
)


def values_of(ratio: Floats) -> dict[str, Floats]:
    """Values of the effect from ratios (n,) of non-loaded to pre-loaded stiffness."""
    return {"ratio": ratio}
