"""Tracker drift: the measuring frame moves and turns while the session goes on.

    shown = x + g(t) (v + w x x)        g(t) = T (1 - exp(-t / T)), t for a long T

v and w in the axes of the tracker (of the base where the session is registered). A tracker that warms up drifts by
tenths of a millimetre in about two hours (Leica AT960; anchors.md, 6). It moves fixed targets as well, which no arm
does.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, Parameter, Values

_STEADY = 1e7  # s: a drift that does not settle


def _shown(position: ca.SX, time: ca.SX, p: Values) -> ca.SX:
    constant = p["settling_s"]
    share = time / constant
    # 1 - exp(-s) loses its digits near zero; its series does not
    series = time * (1 - share / 2 * (1 - share / 3 * (1 - share / 4)))
    g = ca.if_else(share > 1e-3, constant * (1 - ca.exp(-share)), series)
    return position + g * (p["linear_m_per_s"] + ca.cross(p["angular_rad_per_s"], position))


EFFECT = Effect(
    name="tracker-drift",
    cause="the measuring frame moves while the session goes on: fixed targets move as well",
    scope="instruments",
    site_kind="tracker",
    parameters=(
        Parameter(
            name="linear_m_per_s",
            unit="m/s",
            size=3,
            start=0.0,
            low=-1e-4,
            high=1e-4,
            scale=1e-8,
            meaning="velocity of what is shown, at the start",
            neutral=0.0,
        ),
        Parameter(
            name="angular_rad_per_s",
            unit="rad/s",
            size=3,
            start=0.0,
            low=-1e-4,
            high=1e-4,
            scale=1e-8,
            meaning="its rate of turn",
            neutral=0.0,
        ),
        Parameter(
            name="settling_s",
            unit="s",
            size=1,
            start=_STEADY,
            low=10.0,
            high=_STEADY,
            scale=1e4,
            meaning="time constant after which it settles",
            default=_STEADY,
            fit="inverse",
            extra=True,
            trials=(600.0, 3600.0),
        ),
    ),
    position_reading=_shown,
    unloaded=True,
)
