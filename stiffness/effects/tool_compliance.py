"""Tool compliance: flange, bracket, spindle and tool shank as one six-dimensional spring.

    [d; phi] = C [f; m]        (spring.py)

in the axes of the flange, about its origin.
"""

from __future__ import annotations

from stiffness.effects.effect import Effect
from stiffness.effects.spring import PARAMETERS, check, nearest, yielded

EFFECT = Effect(
    name="tool-compliance",
    cause="flange, bracket, spindle and tool shank yield, the same in every posture",
    scope="tool",
    site_kind="tool",
    parameters=PARAMETERS,
    place=yielded,
    places=lambda n: (n,),
    nearest=nearest,
    check=check,
)
