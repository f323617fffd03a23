"""Base compliance: floor, pedestal and bolts as one six-dimensional spring under the arm.

    [d; phi] = C [f; m]        (spring.py)

in the axes of the base, about its origin: the whole arm moves as one body, mostly with the overturning moment. A
pedestal that tilts about a point below shows in the coupling of force and rotation.
"""

from __future__ import annotations

from stiffness.effects.effect import Effect
from stiffness.effects.spring import PARAMETERS, check, nearest, yielded

EFFECT = Effect(
    name="base-compliance",
    cause="floor, pedestal or bolts yield: the whole arm moves as one body with the overturning moment",
    scope="robot",
    site_kind="base",
    parameters=PARAMETERS,
    place=yielded,
    places=lambda n: (0,),
    nearest=nearest,
    check=check,
)
