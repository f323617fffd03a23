"""Thermal drift: the links grow with temperature, and joint zeros may move with it.

    d_k = a_k dT (outer - inner)        dq_j = z_j dT

dT is the temperature above the model's reference; inner and outer are where link k begins and ends (its joint, and
the next). Steel grows by 12e-6 per kelvin, aluminium by 23e-6 (textbook).
"""

from __future__ import annotations

import casadi as ca

from stiffness.effects.effect import Effect, JointInput, Parameter, PlaceInput, Values


def _displacement(given: PlaceInput, p: Values) -> ca.SX:
    along = ca.SX(ca.DM(given.outer - given.inner))
    return ca.vertcat(p["expansion_per_k"][given.place] * given.temperature * along, ca.SX.zeros(3))


def _law(given: JointInput, p: Values) -> ca.SX:
    return p["zero_rad_per_k"] * given.temperature


EFFECT = Effect(
    name="thermal-drift",
    cause="the arm grows with temperature: what moves follows the temperature and not the load",
    scope="robot",
    site_kind="place|joint",
    parameters=(
        Parameter(
            name="expansion_per_k",
            unit="1/K",
            size="place",
            start=0.0,
            low=-1e-3,
            high=1e-3,
            scale=1e-5,
            meaning="growth of each link along its length, 0 the base",
            site="place",
            neutral=0.0,
        ),
        Parameter(
            name="zero_rad_per_k",
            unit="rad/K",
            size="joint",
            start=0.0,
            low=-1e-2,
            high=1e-2,
            scale=1e-5,
            meaning="drift of each joint's zero",
            default=0.0,
            neutral=0.0,
            site="joint",
        ),
    ),
    joint=_law,
    place=_displacement,
    places=lambda n: tuple(range(n + 1)),
    unloaded=True,
    thermal=True,
)
