"""Joint hardening: a reducer that stiffens with torque, from a soft start to its final slope.

    dq = a S(tau / T) + b S(tau / rT)        S = (1 - h) tanh + h clip        (on top of joint-stiffness)

a (rad) is the wind-up that is used up above the first knee T (N*m), b what more is used up above the second, r T.
h = 1 is the law of the makers: three pieces K1 < K2 < K3 with breaks T1, T2 (Harmonic Drive, engineering data CHA, p.
83; Nabtesco RV the same), where

    1/K3 = 1/K    1/K2 = 1/K + b/T2    1/K1 = 1/K2 + a/T1        T1 = T, T2 = r T

and h = 0 its smooth form. clip is x between -1 and 1 with its corners rounded over CORNER of the knee, so that
solvers keep a derivative: it is off by half of that at the corner, and by less than its square farther away. Odd in
torque, rising, no memory. A file without ``knee_ratio`` and ``sharpness`` is smooth with its second knee at 4 T.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import casadi as ca
import numpy as np

from stiffness.effects.effect import Effect, Floats, JointInput, Numbers, Parameter, Values

_RATIO = (1.1, 30.0)  # of the second knee over the first
CORNER = 0.04  # of a knee: an error of 2 % of the wind-up at the corner alone; makers draw no sharper lines


def _clip(x: ca.SX) -> ca.SX:
    """x between -1 and 1, its corners rounded."""
    return (ca.sqrt((x + 1) ** 2 + CORNER**2) - ca.sqrt((x - 1) ** 2 + CORNER**2)) / 2


def _law(given: JointInput, p: Values) -> ca.SX:
    def used_up(x: ca.SX) -> ca.SX:
        return ca.tanh(x) + p["sharpness"] * (_clip(x) - ca.tanh(x))

    x = given.torque / p["knee_nm"]
    return p["windup_rad"] * used_up(x) + p["further_rad"] * used_up(x / p["knee_ratio"])


def _restarts(p: Numbers) -> tuple[dict[str, Floats], ...]:
    """Two equal parts, sharp and smooth, with the sum and the mean knee of the present ones."""
    whole, some = p["windup_rad"] + p["further_rad"], 1e-30
    second = p["knee_ratio"] * p["knee_nm"]
    mean = (p["windup_rad"] * p["knee_nm"] + p["further_rad"] * second + some * p["knee_nm"]) / (whole + some)
    shapes = ((1.0, 2.5), (0.0, 4.0))
    return tuple(
        {
            "windup_rad": whole / 2,
            "knee_nm": mean / (0.5 + 0.5 * ratio),
            "further_rad": whole / 2,
            "knee_ratio": np.full_like(mean, ratio),
            "sharpness": np.full_like(mean, sharp),
        }
        for sharp, ratio in shapes
    )


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
            meaning="wind-up used up above the second knee",
            default=0.0,
            neutral=0.0,
            extra=True,
        ),
        Parameter(
            name="knee_ratio",
            unit="1",
            size="joint",
            start=4.0,
            low=_RATIO[0],
            high=_RATIO[1],
            scale=1.0,
            meaning="second knee over the first",
            default=4.0,
            extra=True,
        ),
        Parameter(
            name="sharpness",
            unit="1",
            size="joint",
            start=0.0,
            low=0.0,
            high=1.0,
            scale=0.3,
            meaning="0: knees are smooth, 1: sharp pieces as makers draw them",
            default=0.0,
            trials=(1.0,),
            extra=True,
        ),
    ),
    joint=_law,
    restarts=_restarts,
    needs_torque_sign=True,
)


def values_of_pieces(rigidity: Sequence[float], breaks: Sequence[float]) -> dict[str, float]:
    """Values of one joint from the pieces of a data sheet, N*m/rad and N*m, on top of the last piece.

    Two or three pieces are met as they are; of more, the first break and the last, the slope at zero torque and the
    asymptote. One piece: no wind-up.
    """
    values = {p.name: p.start for p in EFFECT.parameters} | {"windup_rad": 0.0}
    steps = [1 / a - 1 / b for a, b in pairwise(rigidity)]
    slope, whole = sum(steps), sum(step * at for step, at in zip(steps, breaks, strict=True))
    if slope <= 0:
        return values
    first, last = breaks[0], breaks[-1]
    further = (whole - slope * first) / (1 - first / last) if last > first else 0.0
    ratio = last / first if last > first else values["knee_ratio"]
    return values | {
        "windup_rad": whole - further,
        "knee_nm": first,
        "further_rad": further,
        "knee_ratio": float(np.clip(ratio, *_RATIO)),
        "sharpness": 1.0,
    }
