"""Kinematic offset: joint zeros, link lengths and axis directions that are not the nominal ones.

    dq = zero                      [d; phi]_k = [x, y, z, rx, ry, rz]_k,   k = 1 ... n

constant, in the axes of place k: there without load, and gone from displacements to first order. A joint zero and
the turn about its axis at the place before it are one and the same motion: data determine their sum, and
identification shares it out with the smallest offsets.
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, Parameter, PlaceInput, Values

_AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


def _displacement(given: PlaceInput, p: Values) -> ca.SX:
    return ca.vertcat(*(p[axis][given.place - 1] for axis in _AXES))


def _parameter(name: str, unit: str, meaning: str) -> Parameter:
    most = 0.1 if unit == "m" else 0.2
    return Parameter(
        name=name,
        unit=unit,
        size="joint",
        start=0.0,
        low=-most,
        high=most,
        scale=1e-3,
        prior_sd=1e-3,
        meaning=meaning,
        default=0.0,
        neutral=0.0,
        site="joint" if name == "zero_rad" else "link",
    )


EFFECT = Effect(
    name="kinematic-offset",
    cause="joint zeros, link lengths and axis directions differ from the nominal ones",
    scope="robot",
    site_kind="joint|link",
    parameters=(
        _parameter("zero_rad", "rad", "joint zero"),
        *(_parameter(a, a.rsplit("_")[-1], f"{a.split('_')[0]} of each link's end, in its own axes") for a in _AXES),
    ),
    joint=lambda given, p: p["zero_rad"],
    place=_displacement,
    places=lambda n: tuple(range(1, n + 1)),
    unloaded=True,
    fitted_where="position",
)
