"""Posture stiffness: a joint's compliance varies smoothly with its own angle.

    dq = (a (1 - cos(q - q0)) / 2 + c cos(2 q) + s sin(2 q)) tau/K          (on top of joint-stiffness)

the first harmonic of the joint's angle: K is the stiffness at q0, where the joint is stiffest; half a turn away its
compliance is larger by the share a. c and s are the second harmonic. What was identified in several postures is
interpolated over the workspace (Berntsen, Bertheussen, Tyapin, section 6).
"""

from __future__ import annotations

import math

import casadi as ca

from stiffness.effects.effect import Effect, JointInput, Parameter, Values


def _law(given: JointInput, p: Values) -> ca.SX:
    first = p["softer"] * (1 - ca.cos(given.angle - p["stiffest_rad"])) / 2
    return given.elastic * (first + p["cos2"] * ca.cos(2 * given.angle) + p["sin2"] * ca.sin(2 * given.angle))


EFFECT = Effect(
    name="posture-stiffness",
    cause="the stiffness of a joint varies over the workspace with the joint's own angle",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="softer",
            unit="1",
            size="joint",
            start=0.1,
            low=0.0,
            high=10.0,
            scale=0.2,
            meaning="share of compliance added half a turn from stiffest",
            neutral=0.0,
        ),
        Parameter(
            name="stiffest_rad",
            unit="rad",
            size="joint",
            start=0.0,
            low=-math.pi,
            high=math.pi,
            scale=0.5,
            meaning="joint angle where it is stiffest",
            trials=(-2.0944, 0.0, 2.0944),
        ),
        Parameter(
            name="cos2",
            unit="1",
            size="joint",
            start=0.0,
            low=-0.7,
            high=0.7,
            scale=0.2,
            meaning="second harmonic of the compliance, share of 1/K",
            default=0.0,
            neutral=0.0,
            extra=True,
        ),
        Parameter(
            name="sin2",
            unit="1",
            size="joint",
            start=0.0,
            low=-0.7,
            high=0.7,
            scale=0.2,
            meaning="the same, a quarter of its period on",
            default=0.0,
            neutral=0.0,
            extra=True,
        ),
    ),
    joint=_law,
)
