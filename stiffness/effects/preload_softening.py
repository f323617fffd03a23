"""Preload softening: a joint is softer while its torque acts against its last rotation.

    dq = (1/r - 1) tau/K   where tau * d < 0,   else 0        (on top of joint-stiffness)

d is the direction of the last rotation, r the ratio of non-loaded to pre-loaded stiffness
(Berntsen, Bertheussen, Tyapin, Table 4: joint 1, 0.758 / 1.015 = 0.747). The deflection is continuous
in torque; d is a play operator of very small width, so that rounding in a command is no reversal.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from stiffness.effects.effect import REVERSAL, Clamp, Effect, Floats, JointInput, Memory, Numbers, Parameter, Values


def _law(given: JointInput, p: Values) -> ca.SX:
    against = ca.fmin(given.elastic * ca.sign(given.state), 0) * ca.sign(given.state)
    return (1 / p["ratio"] - 1) * against


def _rule(move: Floats, torque: Floats, p: Numbers) -> Clamp:
    one = np.ones_like(move)
    return Clamp(move / (0.5 * REVERSAL), -one, one)


EFFECT = Effect(
    name="preload-softening",
    cause="the flank that carries the load is softer when the joint was not pre-loaded against it",
    scope="robot",
    parameters=(
        Parameter("ratio", "1", "joint", 0.85, 0.05, 1.0, 0.1, "non-loaded over pre-loaded stiffness"),
    ),
    joint=_law,
    memory=Memory("1", _rule, lambda p: np.ones_like(p["ratio"]), lambda p: np.zeros_like(p["ratio"])),
    needs_torque_sign=True,
)
