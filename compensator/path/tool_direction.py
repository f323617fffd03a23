"""Which way the tool looks while it cuts: into the work, in base axes, and whether the spindle is below the work."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import place
from toolpaths.finding import WARNING, Finding
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]

UPWARD = np.radians(5.0)  # a tool that looks up by less may be that of a level spindle


@dataclass(frozen=True, repr=False)
class ToolDirection:
    """Where the tool looks at the cutting poses of a path.

    Attributes:
        mean: (3,) unit vector from the spindle into the work, base axes.
        spread: rad, the largest angle to it.
        upward: poses at which the tool looks up: the spindle is below the work.
        findings: that ask about them.
    """

    mean: Floats
    spread: float
    upward: int
    findings: tuple[Finding, ...]

    def __repr__(self) -> str:
        return f"ToolDirection({np.round(self.mean, 3).tolist()}, within {np.degrees(self.spread):.1f} deg)"


def tool_direction(path: PlannedPath, gravity: Sequence[float]) -> ToolDirection:
    """Where the tool of a path looks.

    Args:
        gravity: (3,) m/s2 in the base.
    """
    cut = np.flatnonzero(path.toolpath.kind == CUT)
    into = path.tcp.z[cut]
    mean = into.mean(axis=0)
    mean = mean / max(float(np.linalg.norm(mean)), 1e-12)
    spread = float(np.arccos(np.clip(into @ mean, -1.0, 1.0)).max())
    down = np.asarray(gravity, dtype=float)
    up = -down / max(float(np.linalg.norm(down)), 1e-12)
    rise = np.arcsin(np.clip(into @ up, -1.0, 1.0))
    bad = np.flatnonzero(rise > UPWARD)
    if not len(bad):
        return ToolDirection(mean, spread, 0, ())
    what = (
        f"the tool looks up at {len(bad):,} of {len(cut):,} cutting poses, by up to {np.degrees(rise.max()):.0f} deg: "
        "the spindle is below the work"
    )
    remedy = "Is it meant to be cut from below? Do [workobject] rpy and [mount] rpy hold for part and robot?"
    first = place(path.toolpath, int(cut[bad[0]]))
    return ToolDirection(mean, spread, len(bad), (Finding(WARNING, first, what, remedy, count=len(bad)),))
