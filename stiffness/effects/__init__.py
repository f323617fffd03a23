"""The catalogue: every physical cause that the model can hold. One file each, listed here.

Other packages add their own through the entry point ``compensator.effects`` (docs/own-effect.md).
"""

from __future__ import annotations

from typing import Any

from stiffness.effects import (
    backlash,
    base_compliance,
    cutter_size,
    cutting_force,
    force_sensor_bias,
    gravity_compensator,
    joint_angle_error,
    joint_coupling,
    joint_friction,
    joint_hardening,
    joint_stiffness,
    kinematic_offset,
    link_compliance,
    payload,
    posture_stiffness,
    preload_softening,
    thermal_drift,
    tool_compliance,
    tracker_drift,
)
from stiffness.effects.effect import Effect
from stiffness.effects.plugins import with_plugins

BUILT_IN: tuple[Effect, ...] = (
    joint_stiffness.EFFECT,
    preload_softening.EFFECT,
    backlash.EFFECT,
    joint_hardening.EFFECT,
    joint_friction.EFFECT,
    joint_coupling.EFFECT,
    posture_stiffness.EFFECT,
    kinematic_offset.EFFECT,
    joint_angle_error.EFFECT,
    gravity_compensator.EFFECT,
    payload.EFFECT,
    base_compliance.EFFECT,
    link_compliance.EFFECT,
    tool_compliance.EFFECT,
    thermal_drift.EFFECT,
    tracker_drift.EFFECT,
    force_sensor_bias.EFFECT,
    cutting_force.EFFECT,
    cutter_size.EFFECT,
)
BASE = joint_stiffness.EFFECT  # every model has it
CATALOGUE: tuple[Effect, ...]
BY_NAME: dict[str, Effect]


def __getattr__(name: str) -> Any:
    """CATALOGUE and BY_NAME, made when first asked for: a plug-in imports ``effect.py``, and with it this package,
    before its own effect is there."""
    if name not in ("CATALOGUE", "BY_NAME"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    catalogue = with_plugins(BUILT_IN)
    globals().update(CATALOGUE=catalogue, BY_NAME={effect.name: effect for effect in catalogue})
    return globals()[name]
