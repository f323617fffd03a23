"""Joint angle error: a joint turns by an error that is a function of its own angle, whatever the load.

    dq_j = sum_k a_jk hat((q_j - q_k) / h)        hat(x) = max(0, 1 - |x|),  q_k every 3 deg of the whole turn

a table with straight lines between its knots, whatever its cause (transmission error of the gear, eccentricity or
scale of an encoder). Found in laser-tracker data of a real UR10 (docs/real-ur10.md): 0.4 mrad RMS per joint, with
waves of 15 to 25 deg, alike in July and November. A knot without readings is zero.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from stiffness.effects.effect import Effect, Floats, Numbers, Parameter, Values

KNOTS = 120
STEP = 2 * math.pi / KNOTS
SPREAD = 5e-4  # rad: standard deviation of the error at an angle that was not measured


def _law(angle: ca.SX, p: Values) -> ca.SX:
    out = []
    for j in range(angle.numel()):
        turns = (angle[j] + math.pi) / (2 * math.pi)
        u = KNOTS * (turns - ca.floor(turns))  # 0 ... KNOTS
        table = p["error_rad"][j * KNOTS : (j + 1) * KNOTS]
        hats = [ca.fmax(0, 1 - ca.fabs(u - k)) for k in range(KNOTS)]
        hats[0] = hats[0] + ca.fmax(0, u - (KNOTS - 1))
        out.append(ca.dot(ca.vertcat(*hats), table))
    return ca.vertcat(*out)


def _angle_sd(angle: Floats, p: Numbers, sd: Numbers) -> Floats:
    """(N, n) rad: standard deviation of the table at angles (N, n); SPREAD at knots without readings."""
    spread = sd.get("error_rad")
    n = angle.shape[1]
    table = np.zeros(n * KNOTS) if spread is None else np.asarray(spread)
    table = np.where(p["error_rad"] == 0, SPREAD, table).reshape(n, KNOTS)
    u = (angle / STEP + KNOTS / 2) % KNOTS
    low = np.floor(u).astype(int) % KNOTS
    share = u - np.floor(u)
    joint = np.arange(n)
    return np.asarray((1 - share) * table[joint, low] + share * table[joint, (low + 1) % KNOTS])


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
            each=KNOTS,
            prior_sd=SPREAD,
        ),
    ),
    angle=_law,
    angle_sd=_angle_sd,
    unloaded=True,
)
