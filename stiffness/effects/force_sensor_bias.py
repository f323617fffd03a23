"""Force-sensor bias: zero shift, scale and misalignment of the wrench sensor.

    acting = (1 + s) R(e) shown - b

in the sensor's own axes: those that the session writes its wrench in, or those of the tool (``in_tool_axes`` = 1) where
the session turned them. R(e) = 1 + [e]x turns force and moment alike.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, Numbers, Parameter, ShownWrench, Values


def _acting(given: ShownWrench, p: Values) -> ca.SX:
    turned = p["in_tool_axes"]
    to_sensor = turned * given.to_tool + (1 - turned) * ca.SX.eye(3)
    f, m = ca.mtimes(to_sensor, given.wrench[:3]), ca.mtimes(to_sensor, given.wrench[3:])
    e = p["misalignment_rad"]
    shown = ca.vertcat(f + ca.cross(e, f), m + ca.cross(e, m))
    acting = (1 + p["scale"]) * shown - ca.vertcat(p["force_n"], p["moment_nm"])
    return ca.vertcat(ca.mtimes(to_sensor.T, acting[:3]), ca.mtimes(to_sensor.T, acting[3:]))


def _check(p: Numbers) -> str:
    value = float(p["in_tool_axes"][0])
    return "" if value in (0.0, 1.0) else f"in_tool_axes = {value:g}; expected 0 or 1: axes between the two are no axes"


EFFECT = Effect(
    name="force-sensor-bias",
    cause="the wrench sensor has a zero shift, a scale error or stands askew",
    scope="instruments",
    site_kind="force-sensor",
    parameters=(
        Parameter(
            name="force_n",
            unit="N",
            size=3,
            start=0.0,
            low=-1e5,
            high=1e5,
            scale=5.0,
            meaning="force shown without load",
            default=0.0,
            neutral=0.0,
        ),
        Parameter(
            name="moment_nm",
            unit="N*m",
            size=3,
            start=0.0,
            low=-1e5,
            high=1e5,
            scale=2.0,
            meaning="moment shown without load",
            default=0.0,
            neutral=0.0,
        ),
        Parameter(
            name="scale",
            unit="1",
            size=6,
            start=0.0,
            low=-0.5,
            high=0.5,
            scale=0.02,
            meaning="relative error of what is shown, per axis",
            default=0.0,
            neutral=0.0,
            extra=True,
        ),
        Parameter(
            name="misalignment_rad",
            unit="rad",
            size=3,
            start=0.0,
            low=-0.3,
            high=0.3,
            scale=0.02,
            meaning="small rotation from shown to true axes",
            default=0.0,
            neutral=0.0,
            extra=True,
        ),
        Parameter(
            name="in_tool_axes",
            unit="1",
            size=1,
            start=0.0,
            low=0.0,
            high=1.0,
            scale=1.0,
            meaning="1: its axes are those of the tool, 0: those of the session",
            default=0.0,
            fit="given",
            trials=(0.0, 1.0),
        ),
    ),
    wrench_reading=_acting,
    check=_check,
)
