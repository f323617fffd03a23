"""The cut in words, and how sure the prediction is: the terminal and the page have the same lines."""

from __future__ import annotations

from typing import Any

from compensator.path.pose_text import place
from compensator.process.milling.milling_load import MillingLoad
from compensator.solve.compensation import Compensation


def cut_lines(c: Compensation, report: dict[str, Any]) -> list[str]:
    """Force, air, volume, the pose with the largest force and its line; none where nothing is milled."""
    if not isinstance(c.load, MillingLoad):
        return []
    cut, worst = report["cut"], c.load.worst
    lines = [
        f"cutting force: mean {cut['mean_n']:.0f} N, peak over a turn {cut['peak_n']:.0f} N; "
        f"{cut['air_share']:.0%} of the feed in the air; {cut['removed_mm3'] / 1e3:.4g} cm3 removed",
        f"largest mean force {c.load.size[worst]:.0f} N at {place(c.path.toolpath, worst)}",
        f"material {cut['material']}, grid {cut['grid_mm']:.3g} mm",
    ]
    return lines


def band_lines(report: dict[str, Any]) -> list[str]:
    """The band of the mean error, and what to measure first; none where no standard deviation is known."""
    band = report["predicted_error_mm"]["before"].get("band95")
    if band is None:
        return []
    low, high = band["mean"]
    shares = ", ".join(f"{name} {share:.0%}" for name, share in band["share"].items())
    lines = [f"95 % band of the mean error {low:.3f} to {high:.3f} mm; of its variance: {shares}"]
    if band["measure_first"]:
        first = ", ".join(f"{one['what']} ({one['share']:.0%})" for one in band["measure_first"])
        lines.append(f"measure first: {first}; set-ups for it: compensator plan")
    return lines
