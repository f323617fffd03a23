"""The numbers of tables that turn in docs/path-turn.md: python -m docs.make_turning_table, in a minute."""

from __future__ import annotations

import csv
import math
import tempfile
from pathlib import Path
from typing import Any

from compensator.errors import CompensatorError
from compensator.tasks.compensate import preview_file
from docs.make_axis_map import CELL
from docs.make_path_turn import END, PAGE

BEGIN = "<!-- numbers of tables: python -m docs.make_turning_table -->"
HEAD = (
    "| ring, ° | standard deviation, µm, set once | turning | reversals in the cut, set once | turning "
    "| cost, µm², set once | turning | E2 turning, ° |\n"
    "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n"
)
PLACE = ("xyz = [1500.0, -100.0, 800.0]", "xyz = [1800.0, 0.0, 800.0]")
TABLE = """
[external.E2]
carries = "part"
direction = [0.0, 0.0, 1.0]
center = [1800.0, 0.0, 800.0]
free = true
range = [-350.0, 350.0]
"""
NONE = "\N{EN DASH}"
LIMITS = "speed = 10.0\nacceleration = 10.0\n"
RINGS, RADIUS, STEP = (60, 120, 180, 300), 600.0, 0.5


def ring(path: Path, span: int) -> None:
    """Around the table at half height, the tool level from outside, 1200 mm/min."""
    angles = [math.radians(k * STEP) for k in range(int(span / STEP) + 1)]
    rows: list[list[Any]] = []
    away = RADIUS + 50.0
    for radius, some, feed, kind in (
        (away, angles[:1], "", "rapid"), (RADIUS, angles, 1200.0, "cut"), (away, angles[-1:], "", "rapid")
    ):  # fmt: skip
        for x, y in ((math.cos(a), math.sin(a)) for a in some):
            rows.append([radius * x, radius * y, 0.0, x, y, 0.0, feed, kind])
    with open(path, "w", newline="", encoding="ascii") as stream:
        csv.writer(stream).writerows([("x_mm", "y_mm", "z_mm", "i", "j", "k", "feed_mm_min", "kind"), *rows])


def chosen(span: int, limits: str) -> dict[str, Any] | None:
    """``external`` of the report; None: nothing serves."""
    with tempfile.TemporaryDirectory() as folder:
        cell, path = Path(folder) / "cell.toml", Path(folder) / "ring.csv"
        cell.write_text(CELL.replace(*PLACE) + TABLE + limits)
        ring(path, span)
        try:
            return dict(preview_file(path, cell).report["external"])
        except CompensatorError:
            return None


def row(span: int) -> str:
    """A line of the table."""
    still, turning = chosen(span, ""), chosen(span, LIMITS)
    found = [None if one is None else one["chosen"] for one in (still, turning)]
    cells = [str(span)]
    for key, digits in (("deflection_sd_um", 1), ("reversals_in_cut", 0)):
        cells += [NONE if one is None else f"{one[key]:.{digits}f}" for one in found]
    cells += [NONE if one is None else f"{one['cost_um2']['sum']:.0f}" for one in found]
    use = None if turning is None else turning["axes"]["E2"]
    places = NONE if use is None else f"{use['least_deg']:.0f}"
    cells.append(places if use is None or not use["moves"] else f"{places} to {use['greatest_deg']:.0f}")
    return f"| {' | '.join(cells)} |\n"


def main() -> None:
    """Fill the table of the page."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    _, after = rest.split(END, 1)
    PAGE.write_text(f"{before}{BEGIN}\n\n{HEAD}{''.join(map(row, RINGS))}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
