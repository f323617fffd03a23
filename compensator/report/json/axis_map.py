"""The JSON report of ``axis-map``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.csv.axis_map import STATUS
from compensator.report.json.text import MM, Report
from compensator.turn.axis_map import AxisMap
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]


def axis_map_report(m: AxisMap) -> Report:
    """Shares of the map by what forbids a turn, the turns that serve all along, and the chosen one beside the best."""
    grid = m.grid
    whole = np.flatnonzero(grid.free.all(axis=0))
    return {
        "schema": "axis-map/1",
        "n_poses": len(grid.rows),
        "n_turns": len(grid.turns),
        "share": {word.replace(" ", "_"): float(np.mean(grid.status == code)) for code, word in STATUS.items()},
        "turns_all_along_deg": np.degrees(grid.turns[whole]).round(6).tolist(),
        "deflection_mm": _beside(m, m.reliance.deflection),
        "deflection_sd_mm": _beside(m, m.reliance.sd),
        "reversals_in_cut": {
            "chosen": int(_along(m, m.reversing.astype(float)).sum()),
            "fewest_of_constant": int(m.reversing[:, whole].sum(axis=0).min()) if len(whole) else None,
        },
    }


def _beside(m: AxisMap, values: Floats) -> Report:
    """Means over the cutting poses: of the chosen turn, of the best turn at each pose, of the best constant one; mm."""
    cut = m.path.toolpath.kind[m.grid.rows] == CUT
    free = m.grid.free[cut].any(axis=1)
    best = np.nanmin(values[cut][free], axis=1) if free.any() else np.empty(0)
    whole = np.flatnonzero(m.grid.free.all(axis=0))
    constant = values[cut][:, whole].mean(axis=0)
    return {
        "chosen": _mean(_along(m, values)[cut]),
        "best_at_each_pose": _mean(best),
        "best_constant": float(constant.min() * MM) if len(whole) else None,
        "best_constant_deg": float(np.degrees(m.grid.turns[whole[np.argmin(constant)]])) if len(whole) else None,
    }


def _along(m: AxisMap, values: Floats) -> Floats:
    """(M,) of the column nearest to the chosen turn."""
    nearest = np.round(m.chosen / m.grid.step).astype(int) % len(m.grid.turns)
    return np.asarray(values[np.arange(len(nearest)), nearest])


def _mean(values: Floats) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean() * MM) if len(known) else None
