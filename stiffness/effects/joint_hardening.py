"""Joint hardening: a reducer that stiffens with torque, from a soft start to its final slope.

    dq = a tanh(tau / T)        (on top of joint-stiffness)

a (rad) is the wind-up that is used up once the torque is well above T (N*m); the slope at zero torque is
1/K + a/T and falls to 1/K: the smooth form of the reducer makers' three pieces K1 < K2 < K3 with
breaks T1, T2 (Harmonic Drive, engineering data CHA, p. 83). Odd in torque, no memory.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, JointInput, Parameter, Values


def _law(given: JointInput, p: Values) -> ca.SX:
    return p["windup_rad"] * ca.tanh(given.torque / p["knee_nm"])


EFFECT = Effect(
    name="joint-hardening",
    cause="the reducer is softer at small torque and stiffens as more teeth or rollers carry",
    scope="robot",
    parameters=(
        Parameter("windup_rad", "rad", "joint", 5e-5, 0.0, 0.05, 1e-4, "wind-up used up above the knee"),
        Parameter("knee_nm", "N*m", "joint", 200.0, 1e-3, 1e7, 200.0, "torque at which the soft part is used up"),
    ),
    joint=_law,
    needs_torque_sign=True,
)
