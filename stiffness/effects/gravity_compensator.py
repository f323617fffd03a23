"""Gravity compensator: a spring or cylinder between link 1 and link 2 that helps joint 2 to carry the arm.

    tau_2 = -M sin(phi) (1 - l / sqrt(1 - e cos(phi)))        phi = q_2 - q_0

the torque of a linear spring between two pins at the distances a and b from the axis of joint 2: M = k a b, l its
free length over sqrt(a^2 + b^2), e = 2 a b / (a^2 + b^2), and q_0 the angle where both pins lie on one side. l = 0 is
a spring whose force grows from zero with its length, and e is then of no account. l < 0 is one that was wound with
initial tension, or a cylinder of gas, whose force is there from the start and rises by a part over its stroke.
"""

from __future__ import annotations

import math

import casadi as ca

from stiffness.effects.effect import Effect, Parameter, Values

JOINT = 1  # counted from 0


def _torque(angle: ca.SX, p: Values) -> ca.SX:
    phi = angle[JOINT] - p["angle_rad"]
    length = ca.sqrt(1 - p["eccentricity"] * ca.cos(phi))
    tau = -p["moment_nm"] * ca.sin(phi) * (1 - p["free_length"] / length)
    return ca.vertcat(*(tau if k == JOINT else ca.SX(0) for k in range(angle.numel())))


EFFECT = Effect(
    name="gravity-compensator",
    cause="a spring or cylinder between link 1 and link 2 loads joint 2, with and without process",
    scope="robot",
    site_kind="joint-2",
    parameters=(
        Parameter(
            name="moment_nm",
            unit="N*m",
            size=1,
            start=1000.0,
            low=0.0,
            high=1e6,
            scale=1000.0,
            meaning="spring rate times both lever arms",
            neutral=0.0,
        ),
        Parameter(
            name="angle_rad",
            unit="rad",
            size=1,
            start=0.0,
            low=-math.pi,
            high=math.pi,
            scale=1.0,
            meaning="angle of joint 2 where both pins lie on one side",
            trials=(-2.0944, 0.0, 2.0944),
        ),
        Parameter(
            name="free_length",
            unit="1",
            size=1,
            start=0.8,
            low=-20.0,
            high=3.0,
            scale=0.5,
            meaning="relaxed length over root of a^2 + b^2, below 0 with initial tension",
            default=0.0,
            trials=(0.0, -1.0),
        ),
        Parameter(
            name="eccentricity",
            unit="1",
            size=1,
            start=0.5,
            low=0.0,
            high=0.98,
            scale=0.3,
            meaning="2 a b / (a^2 + b^2)",
            default=0.5,
            trials=(0.2, 0.9),
        ),
    ),
    torque=_torque,
    unloaded=True,
    twins=("joint-angle-error",),  # both a function of the angle of joint 2 alone
)
