"""An axis map as CSV."""

from __future__ import annotations

import numpy as np

from compensator.turn.axis_map import AxisMap
from compensator.turn.turn_grid import BEYOND_LIMIT, COLLIDING, FREE, OUT_OF_REACH, SINGULAR

STATUS = {
    FREE: "free",
    OUT_OF_REACH: "out of reach",
    BEYOND_LIMIT: "limit",
    SINGULAR: "singular",
    COLLIDING: "collision",
}
HEADER = (
    "pose,source_line,kind,position_mm,turn_deg,status,margin,deflection_um,deflection_sd_um,reversing_joints,chosen"
)
_BLOCK = 200  # poses that are printed at once


def axis_map_csv(m: AxisMap) -> str:
    """A row per pose and turn, the turn running fastest; cells are empty where nothing can be said."""
    parts = [HEADER + "\n"]
    for begin in range(0, len(m.grid.rows), _BLOCK):
        parts.append(_printed(m, slice(begin, begin + _BLOCK)))
    return "".join(parts)


def _printed(m: AxisMap, part: slice) -> str:
    rows, turns = m.grid.rows[part], np.degrees(m.grid.turns)
    path, shape = m.path.toolpath, m.grid.status[part].shape
    nearest = np.round(m.chosen[part] / m.grid.step).astype(int) % shape[1]
    words = [STATUS[np.uint8(k)] for k in range(len(STATUS))]
    lines = []
    per_pose = zip(
        rows.tolist(), path.line[rows].tolist(), path.kind[rows].tolist(), (m.position[part] * 1e3).tolist(),
        m.grid.status[part].tolist(), m.grid.margin[part].tolist(), (m.reliance.deflection[part] * 1e6).tolist(),
        (m.reliance.sd[part] * 1e6).tolist(), m.reversing[part].tolist(), nearest.tolist(), strict=True,
    )  # fmt: skip
    for pose, line, kind, position, status, margin, deflection, sd, reversing, chosen in per_pose:
        head = f"{pose},{line},{'cut' if kind else 'rapid'},{position:.3f}"
        for k, turn in enumerate(turns.tolist()):
            if status[k]:
                room = "" if margin[k] == -np.inf else f"{margin[k]:.4g}"
                lines.append(f"{head},{turn:g},{words[status[k]]},{room},,,,{int(k == chosen)}\n")
            else:
                numbers = f"{margin[k]:.4g},{deflection[k]:.3f},{sd[k]:.3f},{reversing[k]}"
                lines.append(f"{head},{turn:g},free,{numbers},{int(k == chosen)}\n")
    return "".join(lines)
