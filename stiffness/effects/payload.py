"""Payload: a mass on the flange that is not declared to the controller.

    a weight m g at c, in the frame of the flange

It loads every joint and every place inward of it. Declared masses (tool.mass, column payload) are no part of it.
"""

from __future__ import annotations

from stiffness.effects.effect import Effect, Parameter, PointMass, Values


def _mass(joints: int, p: Values) -> tuple[PointMass, ...]:
    return (PointMass(joints, p["mass_kg"], p["com_m"]),)


EFFECT = Effect(
    name="payload",
    cause="a mass on the flange that was not declared: the arm sags with gravity, not with the process",
    scope="tool",
    site_kind="tool",
    parameters=(
        Parameter(
            name="mass_kg", unit="kg", size=1, start=1.0, low=0.0, high=2000.0, scale=5.0, meaning="mass", neutral=0.0
        ),
        Parameter(
            name="com_m",
            unit="m",
            size=3,
            start=0.0,
            low=-3.0,
            high=3.0,
            scale=0.2,
            meaning="its centre in the frame of the flange",
            default=0.0,
            trials=(0.3, -0.3),
        ),
    ),
    mass=_mass,
    unloaded=True,
)
