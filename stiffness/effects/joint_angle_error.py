"""Joint angle error: a joint turns by an error that is a function of its own angle, whatever the load.

    dq_j = c1_j cos(q_j) + s1_j sin(q_j) + c2_j cos(2 q_j) + s2_j sin(2 q_j) + sum_k a_jk hat((q_j - q_k) / h)

The harmonics are what an encoder makes whose disc sits off its axis (once per turn) or whose heads read it from two
sides (twice). Where they do not hold and there are readings enough, a table stands in their place: straight lines
between knots q_k every 3 deg of the whole turn, hat(x) = max(0, 1 - |x|), whatever the cause (transmission error of the
gear, scale of an encoder). Found in laser-tracker data of a real UR10 (docs/real-ur10.md): 0.4 mrad RMS per joint, with
waves of 15 to 25 deg, alike in July and November. A knot without readings is zero.
"""

from __future__ import annotations

import math
from functools import cache

import casadi as ca
import numpy as np

from stiffness.effects.effect import Effect, Floats, Numbers, Parameter, Values

KNOTS = 120
STEP = 2 * math.pi / KNOTS
WORST = 2e-3  # rad: of an encoder, 40 um off its axis at a radius of 20 mm; what turns a joint farther is a spring
SPREAD = 5e-4  # rad: standard deviation of the error at an angle that was not measured
# name of the number of a joint -> its function of the angle
HARMONICS = {
    f"{name}{order}_rad": (order, function)
    for order in (1, 2)
    for name, function in (("cos", np.cos), ("sin", np.sin))
}
_SYMBOLIC = {np.cos: ca.cos, np.sin: ca.sin}


def _law(angle: ca.SX, p: Values) -> ca.SX:
    out = []
    for j in range(angle.numel()):
        turns = (angle[j] + math.pi) / (2 * math.pi)
        u = KNOTS * (turns - ca.floor(turns))  # 0 ... KNOTS
        table = p["error_rad"][j * KNOTS : (j + 1) * KNOTS]
        hats = [ca.fmax(0, 1 - ca.fabs(u - k)) for k in range(KNOTS)]
        hats[0] = hats[0] + ca.fmax(0, u - (KNOTS - 1))
        waves = sum(p[name][j] * _SYMBOLIC[f](order * angle[j]) for name, (order, f) in HARMONICS.items())
        out.append(waves + ca.dot(ca.vertcat(*hats), table))
    return ca.vertcat(*out)


@cache
def _as_table() -> Floats:
    """(KNOTS, 4): the harmonics at the knots."""
    knots = -math.pi + STEP * np.arange(KNOTS)
    return np.column_stack([f(order * knots) for order, f in HARMONICS.values()])


def _angle_sd(angle: Floats, p: Numbers, sd: Numbers) -> Floats:
    """(N, n) rad: standard deviation at angles (N, n). Of tables, SPREAD at knots without readings, also in joints that
    have none; of harmonics, where a joint has no table, at all angles."""
    n = angle.shape[1]
    spread = np.reshape(sd.get("error_rad", np.zeros(n * KNOTS)), (n, KNOTS))
    knots = np.reshape(p["error_rad"], (n, KNOTS))
    tables = bool(np.any(knots) or np.any(spread))
    table = np.where(knots == 0, SPREAD if tables else 0.0, spread)
    u = (angle / STEP + KNOTS / 2) % KNOTS
    low = np.floor(u).astype(int) % KNOTS
    share = u - np.floor(u)
    joint = np.arange(n)
    own = (1 - share) * table[joint, low] + share * table[joint, (low + 1) % KNOTS]
    waves = np.sqrt(sum((sd.get(k, np.zeros(n)) * f(order * angle)) ** 2 for k, (order, f) in HARMONICS.items()))
    waving = np.any([p[name] != 0 for name in HARMONICS], axis=0) & ~np.any(knots, axis=1)
    return np.asarray(np.where(waving, waves, np.hypot(own, waves)))


def _harmonic(name: str, order: int) -> Parameter:
    return Parameter(
        name=name,
        unit="rad",
        size="joint",
        start=0.0,
        low=-WORST,
        high=WORST,
        scale=1e-4,
        meaning=f"part of the error that goes with the {'cosine' if name.startswith('cos') else 'sine'} of "
        f"{'the angle' if order == 1 else 'twice the angle'}",
        default=0.0,
        neutral=0.0,
        prior_sd=SPREAD,
    )


EFFECT = Effect(
    name="joint-angle-error",
    cause="the joint turns by an error that depends on its own angle alone, as of a gear or an encoder",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="error_rad",
            unit="rad",
            size="joint",
            start=0.0,
            low=-0.02,
            high=0.02,
            scale=1e-4,
            meaning="actual minus commanded, every 3 deg from -180",
            default=0.0,
            neutral=0.0,
            extra=True,
            each=KNOTS,
            prior_sd=SPREAD,
        ),
        *(_harmonic(name, order) for name, (order, _) in HARMONICS.items()),
    ),
    angle=_law,
    angle_sd=_angle_sd,
    as_table=_as_table,
    unloaded=True,
    twins=("gravity-compensator",),  # at joint 2 both are a function of its angle alone
)
