"""Joint stiffness: gears, bearings and servo loop of each joint as one linear spring.

dq = tau / K        (base model; Dumas et al., RCIM 27 (2011) 881)
"""

from __future__ import annotations

from stiffness.effects.effect import Effect, Parameter

EFFECT = Effect(
    name="joint-stiffness",
    cause="gears, bearings and servo loop of each joint yield in proportion to its torque",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            "k_nm_per_rad", "N*m/rad", "joint", 1e6, 1e2, 1e12, 1e6, "torsional stiffness per joint", fit="inverse"
        ),
    ),
    joint=lambda given, p: given.torque / p["k_nm_per_rad"],
)
