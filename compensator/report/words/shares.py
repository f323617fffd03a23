"""Shares of a deflection, and where the tool looks, in words: the terminal and the page have the same ones."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Key of the JSON report -> what it is.
SHARES = {
    "gravity": "weight of arm and tool",
    "process": "process",
    "joint_state": "state of the joints (gaps, flanks, windup)",
    "offsets": "kinematic offsets",
    "temperature": "temperature",
    "touched_off": "taken off: the work object was touched off",
    "interaction": "interaction of these",
}


def direction_words(report: dict[str, Any]) -> str:
    """Where the tool looks, from the spindle into the work."""
    tool = report["tool_direction"]
    x, y, z = (f"{v + 0.0:.2f}" for v in np.round(tool["mean_xyz"], 2))
    spread = f", within {tool['spread_deg']:.1f} deg" if tool["spread_deg"] >= 0.05 else ""
    return f"({x}, {y}, {z}){spread}"
