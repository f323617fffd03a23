"""Payload: a mass on the flange that nobody declared.

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
        Parameter("mass_kg", "kg", 1, 1.0, 0.0, 2000.0, 5.0, "mass", neutral=0.0),
        Parameter(
            "com_m", "m", 3, 0.0, -3.0, 3.0, 0.2, "its centre in the frame of the flange", 0.0, trials=(0.3, -0.3)
        ),
    ),
    mass=_mass,
    unloaded=True,
)
