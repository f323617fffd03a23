"""Joint stiffness: gears, bearings and servo loop of each joint as one linear spring.

dq = tau / K        (base model; Dumas et al., RCIM 27 (2011) 881)
"""

from __future__ import annotations

from stiffness.effects.effect import Effect, Floats, Parameter

EFFECT = Effect(
    name="joint-stiffness",
    cause="gears, bearings and servo loop of each joint yield in proportion to its torque",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="k_nm_per_rad",
            unit="N*m/rad",
            size="joint",
            start=1e6,
            low=1e2,
            high=1e12,
            scale=1e6,
            meaning="torsional stiffness per joint",
            fit="inverse",
        ),
    ),
    joint=lambda given, p: given.torque / p["k_nm_per_rad"],
    is_base=True,
    stiffness=lambda p: p["k_nm_per_rad"],
    fitted_where="load",
)


def values_of(stiffness: Floats) -> dict[str, Floats]:
    """Values of the effect from stiffnesses (n,) N*m/rad."""
    return {"k_nm_per_rad": stiffness}
