"""Cutter size: a cutter that is smaller than it is taken to be leaves the same everywhere, whatever the force there.

    shown = deviation + r

r > 0 where the radius is too small. A steady normal force does the same; an uneven allowance tells the two apart.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, Parameter, Values


def _shown(deviation: ca.SX, p: Values) -> ca.SX:
    return deviation + p["radius_m"]


EFFECT = Effect(
    name="cutter-size",
    cause="the cutter is smaller or larger than it is taken to be: the same deviation along every normal",
    scope="process",
    site_kind="cutter",
    parameters=(
        Parameter(
            name="radius_m",
            unit="m",
            size=1,
            start=0.0,
            low=-1e-3,
            high=1e-3,
            scale=1e-5,
            meaning="by how much the radius is too small",
            neutral=0.0,
        ),
    ),
    surface_reading=_shown,
    missing_radius=lambda values: float(values["radius_m"][0]),
    unloaded=True,
)
