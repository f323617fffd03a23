"""The catalogue: every physical cause that the model can hold. One file each, listed here."""

from __future__ import annotations

from stiffness.effects import (
    backlash,
    joint_hardening,
    joint_stiffness,
    kinematic_offset,
    posture_stiffness,
    preload_softening,
    tool_compliance,
)
from stiffness.effects.effect import Effect

CATALOGUE: tuple[Effect, ...] = (
    joint_stiffness.EFFECT,
    preload_softening.EFFECT,
    backlash.EFFECT,
    joint_hardening.EFFECT,
    posture_stiffness.EFFECT,
    kinematic_offset.EFFECT,
    tool_compliance.EFFECT,
)
BY_NAME = {effect.name: effect for effect in CATALOGUE}
