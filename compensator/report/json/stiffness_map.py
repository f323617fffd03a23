"""The JSON report of ``stiffness-map``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.json.text import Report
from stiffness.statics.stiffness_map import LIMIT, NO_EQUILIBRIUM, OK, SINGULAR, StiffnessMap

Floats = npt.NDArray[np.float64]


def map_report(result: StiffnessMap, joints: tuple[int, int], left_out: tuple[str, ...], notes: list[str]) -> Report:
    """Where the extremes lie, and what is blank.

    Args:
        joints: the two that vary, counted from 0.
        left_out: effects of the model that are not applied.
    """
    low, high, direction = result.softest
    low_rigid, _, _ = result.softest_rigid

    def at(values: Floats, key: str, largest: bool) -> Report:
        k = int(np.nanargmax(values) if largest else np.nanargmin(values))
        return {key: float(values[k]), "q_deg": np.degrees(result.q[k]).round(9).tolist()}

    softest = at(low * 1e-6, "n_per_um", False)
    k = int(np.nanargmin(low))
    softest |= {"direction": direction[k].tolist(), "without_kc_n_per_um": float(low_rigid[k] * 1e-6)}
    return {
        "joints": [f"joint-{j + 1}" for j in joints],
        "n_postures": len(result.q),
        "n_ok": int(np.sum(result.status == OK)),
        "n_limit": int(np.sum(result.status == LIMIT)),
        "n_singular": int(np.sum(result.status == SINGULAR)),
        "n_no_equilibrium": int(np.sum(result.status == NO_EQUILIBRIUM)),
        "stiffness_min": softest,
        "stiffness_max": at(high * 1e-6, "n_per_um", True),
        "deflection_max": at(result.deflection * 1e3, "mm", True),
        "kc_shift_max": at(result.shift * 1e6, "um", True),
        "nu_p_max": at(result.nu_p, "ratio", True),
        "nu_r_max": at(result.nu_r * 1e6, "urad", True),
        "not_applied": list(left_out),
        "notes": notes,
    }
