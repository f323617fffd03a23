"""Joint hardening: a reducer that stiffens with torque, from a soft start to its final slope.

    dq = a tanh(tau / T) + b tanh(tau / 4T)        (on top of joint-stiffness)

a (rad) is the wind-up that is used up once the torque is well above T (N*m), b what more is used up above 4 T; the
slope at zero torque is 1/K + a/T + b/4T and falls to 1/K: the smooth form of the reducer makers' three pieces K1 < K2
< K3 with breaks T1, T2 (Harmonic Drive, engineering data CHA, p. 83). Odd in torque, no memory.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from stiffness.effects.effect import Effect, Floats, JointInput, Parameter, Values


def _law(given: JointInput, p: Values) -> ca.SX:
    x = given.torque / p["knee_nm"]
    return p["windup_rad"] * ca.tanh(x) + p["further_rad"] * ca.tanh(x / 4)


EFFECT = Effect(
    name="joint-hardening",
    cause="the reducer is softer at small torque and stiffens as more teeth or rollers carry",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="windup_rad",
            unit="rad",
            size="joint",
            start=5e-5,
            low=0.0,
            high=0.05,
            scale=1e-4,
            meaning="wind-up used up above the knee",
            neutral=0.0,
        ),
        Parameter(
            name="knee_nm",
            unit="N*m",
            size="joint",
            start=200.0,
            low=1e-3,
            high=1e7,
            scale=200.0,
            meaning="torque at which the soft part is used up",
            trials=(0.03, 0.1, 0.3, 0.8),
            trials_of="torque",
        ),
        Parameter(
            name="further_rad",
            unit="rad",
            size="joint",
            start=0.0,
            low=0.0,
            high=0.05,
            scale=1e-4,
            meaning="wind-up used up above four times the knee",
            default=0.0,
            neutral=0.0,
            extra=True,
        ),
    ),
    joint=_law,
    needs_torque_sign=True,
)


def values_of(windup: Floats, knee: Floats) -> dict[str, Floats]:
    """Values of the effect from wind-up (n,) rad and knee (n,) N*m of one soft part, with no second one above it."""
    return {"windup_rad": windup, "knee_nm": knee, "further_rad": np.zeros(len(knee))}
