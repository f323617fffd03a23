"""Joint friction: a torque that the drive train holds without moving, so that wind-up stays.

    dq = f / K        f' = min(max(f - b d tau, -T), T)        (on top of joint-stiffness)

f is the friction torque on the link: it takes up the share b of every change of load until it slips at T (a stop
operator: Visintin, Differential Models of Hysteresis, 1994; b = 1 sticks without yielding, less is a spring with a
slider beside that of the joint). Loading and unloading differ by up to 2 T/K at the same command. A commanded move
leaves the link behind the motor, f = -lag T in the direction of the move, within a travel of REVERSAL.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from stiffness.effects.effect import (
    REVERSAL,
    Clamp,
    Effect,
    Floats,
    JointInput,
    Memory,
    Numbers,
    Parameter,
    Values,
)


def _law(given: JointInput, p: Values) -> ca.SX:
    return given.state * given.compliance


def _rule(move: Floats, torque: Floats, p: Numbers) -> Clamp:
    most = np.broadcast_to(p["friction_nm"], move.shape)
    change = p["held"] * np.diff(torque, axis=0, prepend=torque[:1])
    share = np.minimum(np.abs(move) / (0.5 * REVERSAL), 1.0)  # of the way to the state that a long move leaves
    left = -np.sign(move) * p["lag"] * most
    # the interval that f may be in shrinks about what the move leaves behind
    centre, half = share * left, (1 - share) * most
    return Clamp(-change, np.maximum(centre - half, -most), np.minimum(centre + half, most))


EFFECT = Effect(
    name="joint-friction",
    cause="dry friction in the drive train holds part of the load: wind-up stays, loading and unloading differ",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="friction_nm",
            unit="N*m",
            size="joint",
            start=10.0,
            low=0.0,
            high=1e5,
            scale=20.0,
            meaning="torque that friction holds",
            neutral=0.0,
            trials=(0.02, 0.08, 0.25),
            trials_of="torque",
        ),
        Parameter(
            name="held",
            unit="1",
            size="joint",
            start=0.8,
            low=0.05,
            high=1.0,
            scale=0.3,
            meaning="share of a change of load that sticking holds",
            default=1.0,
        ),
        Parameter(
            name="lag",
            unit="1",
            size="joint",
            start=1.0,
            low=0.0,
            high=1.0,
            scale=1.0,
            meaning="after a move the link lags behind: 1, is free of wind-up: 0",
            default=1.0,
            fit="given",
            trials=(1.0, 0.0),
        ),
    ),
    joint=_law,
    memory=Memory("N*m", _rule, lambda p: p["friction_nm"], lambda p: 0 * p["friction_nm"]),
    needs_torque_sign=True,
)
