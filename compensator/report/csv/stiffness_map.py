"""A stiffness map as CSV."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stiffness.statics.stiffness_map import StiffnessMap

Floats = npt.NDArray[np.float64]


def map_csv(result: StiffnessMap) -> str:
    """A row per posture, the second joint running fastest; cells are empty where nothing can be said."""
    n = result.q.shape[1]
    low, high, direction = result.softest
    low_rigid, high_rigid, _ = result.softest_rigid
    d = result.displacement
    columns: list[tuple[str, Floats]] = [(f"q{k + 1}_deg", np.degrees(result.q[:, k])) for k in range(n)]
    columns += [(f"{a}_mm", result.position[:, k] * 1e3) for k, a in enumerate("xyz")]
    columns += [("stiffness_min_n_per_um", low * 1e-6), ("stiffness_max_n_per_um", high * 1e-6)]
    columns += [(f"softest_{a}", direction[:, k]) for k, a in enumerate("xyz")]
    columns += [("stiffness_min_without_kc_n_per_um", low_rigid * 1e-6)]
    columns += [("stiffness_max_without_kc_n_per_um", high_rigid * 1e-6)]
    columns += [(f"d{a}_mm", d[:, k] * 1e3) for k, a in enumerate("xyz")]
    columns += [(f"r{a}_urad", d[:, 3 + k] * 1e6) for k, a in enumerate("xyz")]
    columns += [("deflection_mm", result.deflection * 1e3)]
    columns += [("deflection_without_kc_mm", result.deflection_rigid * 1e3)]
    columns += [("kc_shift_um", result.shift * 1e6), ("nu_p", result.nu_p), ("nu_r_urad", result.nu_r * 1e6)]
    head = [*(name for name, _ in columns), "status"]
    rows = zip(*(_cells(values) for _, values in columns), result.status.tolist(), strict=True)
    return "\n".join([",".join(head), *(",".join(row) for row in rows)]) + "\n"


def _cells(values: Floats) -> Sequence[str]:
    return ["" if np.isnan(v) else f"{v + 0.0:.8g}" for v in values.tolist()]
