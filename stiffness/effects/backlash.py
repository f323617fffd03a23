"""Backlash: a gap between tooth flanks that the joint crosses at a reversal or under load.

    dq = u,   -b/2 <= u <= b/2        (b: total lost motion)

u follows a play operator: a commanded move d shifts it by side * d, a torque beyond breakaway puts it
on the side that the torque pushes to. side = +1 is the finding of Berntsen, Bertheussen, Tyapin
(section 5): after a rotation the link rests on the side it turned to; -1 is a link that lags behind.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from stiffness.effects.effect import Effect, Floats, JointInput, Numbers, Parameter, Values
from stiffness.effects.memory import Clamp, Memory, TargetClamp

AT_ONCE = 3e-7  # rad of travel: less than a micrometre at 2 m
_NO_TORQUE = 0.01  # N*m: no gear turns freely under less; a torque that is zero by symmetry chooses no flank


def _law(given: JointInput, p: Values) -> ca.SX:
    return given.state


def _rule(move: Floats, torque: Floats, p: Numbers, stiffness: Floats) -> Clamp:
    half = np.broadcast_to(p["gap_rad"] / 2, move.shape)
    held = np.abs(torque) > np.maximum(p["breakaway_nm"], _NO_TORQUE)
    side = np.copysign(half, torque)
    return Clamp(p["side"] * move, np.where(held, side, -half), np.where(held, side, half))


def _by_target(move: Floats, torque: Floats, p: Numbers, stiffness: Floats) -> TargetClamp:
    """move = target move - (u' - u), hence u' = clamp(u + side / (1 + side) * target move).

    A link that lags (side -1) crosses its gap at once; "at once" is a travel of AT_ONCE, so that rounding in a target
    does not count as a reversal.
    """
    half = np.maximum(p["gap_rad"] / 2, 1e-30)
    factor = 1 / np.maximum(1 + p["side"], 1 / np.maximum(2 * half / AT_ONCE, 1.0))
    clamp = _rule(move, torque, p, stiffness)
    within = Clamp(clamp.shift * factor / half, clamp.low / half, clamp.high / half)
    return TargetClamp(within, np.ones((len(half), 1, 1)))


EFFECT = Effect(
    name="backlash",
    cause="the joint crosses a gap between its tooth flanks when it reverses or its torque changes sign",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="gap_rad",
            unit="rad",
            size="joint",
            start=5e-5,
            low=0.0,
            high=0.05,
            scale=1e-4,
            meaning="total lost motion per joint",
            neutral=0.0,
        ),
        Parameter(
            name="breakaway_nm",
            unit="N*m",
            size="joint",
            start=0.0,
            low=0.0,
            high=1e9,
            scale=10.0,
            meaning="torque above which the load chooses the flank",
            default=0.0,
            fit="given",
            trials=(0.0, 0.03, 0.1, 0.3, 1e3),
            trials_of="torque",
        ),
        Parameter(
            name="side",
            unit="1",
            size="joint",
            start=1.0,
            low=-1.0,
            high=1.0,
            scale=1.0,
            meaning="+1: rests on the side it turned to, -1: lags behind",
            default=1.0,
            fit="given",
            trials=(1.0, -1.0),
        ),
    ),
    joint=_law,
    memory=Memory(
        unit="rad",
        rule=_rule,
        bounds=lambda p: p["gap_rad"] / 2,
        meaning="where the joint stands in its gap, from its lowest to its highest angle",
        deflection=lambda state, stiffness: state,
        by_target=_by_target,
    ),
    needs_torque_sign=True,
    fitted_where="approach",
)


def values_of(gap: Floats) -> dict[str, Floats]:
    """Values of the effect from gaps (n,) rad alone: every load chooses the flank."""
    return {"gap_rad": gap, "breakaway_nm": np.zeros(len(gap)), "side": np.ones(len(gap))}
