"""Posture stiffness: a joint's compliance varies smoothly with its own angle.

    dq = (a (1 - cos(q - q0)) / 2 + c2 cos(2 q) + s2 sin(2 q) + c3 cos(3 q) + s3 sin(3 q)) tau/K    (on joint-stiffness)

the first harmonic of the joint's angle: K is the stiffness at q0, where the joint is stiffest; half a turn away its
compliance is larger by the share a. The second and the third harmonic are there where data ask for them; whatever they
are, the compliance stays positive at every angle. What was identified in several postures is interpolated over the
workspace (Berntsen, Bertheussen, Tyapin, section 6).
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from stiffness.effects.effect import Effect, Floats, JointInput, Numbers, Parameter, Values

LEAST = 1e-3  # share of 1/K that is left of the compliance at any angle
_ANGLES = np.radians(np.arange(360))  # the shortest wave is 120 deg long
_WAVES = (("cos2", np.cos, 2), ("sin2", np.sin, 2), ("cos3", np.cos, 3), ("sin3", np.sin, 3))


def _law(given: JointInput, p: Values) -> ca.SX:
    q = given.angle
    share = p["softer"] * (1 - ca.cos(q - p["stiffest_rad"])) / 2
    for k in (2, 3):
        share += p[f"cos{k}"] * ca.cos(k * q) + p[f"sin{k}"] * ca.sin(k * q)
    return given.elastic * share


def _parts(p: Numbers) -> tuple[Floats, Floats]:
    """(n, 360) of the compliance as a share of 1/K: with the first harmonic, and what the others add."""
    first = p["softer"][:, None] * (1 - np.cos(_ANGLES - p["stiffest_rad"][:, None])) / 2
    waves = sum((p[name][:, None] * f(k * _ANGLES) for name, f, k in _WAVES), np.zeros_like(first))
    return 1 + first, waves


def _check(p: Numbers) -> str:
    first, waves = _parts(p)
    low = (first + waves).min(axis=1)
    bad = np.flatnonzero(low < LEAST)
    if not len(bad):
        return ""
    k = int(bad[0])
    return (
        f"joint {k + 1} would have {low[k]:.2g} times its compliance 1/K at some angle: the harmonics cos2 ... sin3 "
        f"may not take it below {LEAST:g}; make them smaller"
    )


def _nearest(p: Numbers) -> dict[str, Floats]:
    """The harmonics of a joint made smaller together, as far as its compliance needs."""
    first, waves = _parts(p)
    room = np.where(waves < 0, (first - 1.01 * LEAST) / np.maximum(-waves, 1e-300), np.inf).min(axis=1)
    kept = np.minimum(room, 1.0)
    return {k: v * kept if k in {name for name, _, _ in _WAVES} else np.array(v) for k, v in p.items()}


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
        *(
            Parameter(
                name=name,
                unit="1",
                size="joint",
                start=0.0,
                low=-0.7,
                high=0.7,
                scale=0.2,
                meaning=f"{'sine' if f is np.sin else 'cosine'} of {k} times the angle in the compliance, share of 1/K",
                default=0.0,
                neutral=0.0,
                extra=True,
            )
            for name, f, k in _WAVES
        ),
    ),
    joint=_law,
    check=_check,
    nearest=_nearest,
)
