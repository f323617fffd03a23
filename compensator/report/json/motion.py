"""Joint speeds and accelerations of a path in the JSON report, and the feeds that were lowered."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.path.planned_path import PlannedPath
from compensator.report.json.text import Report
from compensator.solve.added_acceleration import AddedAcceleration
from compensator.solve.motion_limits import MotionCheck, limits_by_name, lowered_feeds

Floats = npt.NDArray[np.float64]


def motion_report(check: MotionCheck, path: PlannedPath, added: AddedAcceleration | None) -> Report:
    """Largest speed and acceleration of each joint in the cuts, the limits (null: not known), what corrections add to
    the accelerations (null: nothing is corrected), and lowered feeds."""
    limits = limits_by_name(check.robot)
    return {
        "speed_deg_per_s": _largest(check.speed.value, limits["speed"]),
        "acceleration_deg_per_s2": _largest(check.acceleration.value, limits["acceleration"]),
        "added_acceleration_deg_per_s2": None if added is None else {
            "elsewhere": np.degrees(added.elsewhere).tolist(),
            "at_flank_changes": np.degrees(added.at_flanks).tolist(),
        },
        "lowered": [
            {
                "poses": list(f.pose),
                "source_lines": list(f.line),
                "programmed_mm_per_min": f.programmed * 60e3,
                "lowest_mm_per_min": f.lowest * 60e3,
            }
            for f in lowered_feeds(path)
        ],
    }


def _largest(value: Floats, limit: Floats) -> Report:
    known = [None if np.isnan(v) else float(v) for v in np.degrees(limit)]
    return {"max": np.degrees(value).tolist(), "limit": known}
