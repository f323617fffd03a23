"""What the terminal shows of a model that did not come from a session."""

from __future__ import annotations

from typing import Any

from compensator.tasks.models import Made
from compensator.terminal.fit import stiffness_cells
from compensator.terminal.screen import print_written, screen, table

ARCMIN = 3437.746770784939  # in a rad


def show_made(done: Made) -> None:
    """A row per joint."""
    console, r = screen(), done.report
    if console is None:
        return
    heads = ("joint", "stiffness, N*m/rad", "standard deviation", "gap, arcmin", "standard deviation")
    joints = table(*heads, right=range(1, 5))
    for k, (value, sd) in enumerate(zip(r["stiffness_nm_per_rad"], r["stiffness_sd_nm_per_rad"], strict=True)):
        gap = [_arcmin(r, key, k) for key in ("gap_rad", "gap_sd_rad")]
        joints.add_row(str(k + 1), *stiffness_cells(value, sd), *gap)
    console.print(joints)
    print_written(console, done.files)


def _arcmin(report: dict[str, Any], key: str, joint: int) -> str:
    values = report.get(key)
    return "" if values is None or values[joint] is None else f"{values[joint] * ARCMIN:.3f}"
