"""The numbers of docs/path-turn.md: python -m docs.make_path_turn, in minutes; ust_a.cls is beside the checkout."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from compensator.tasks.compensate import compensate_file, preview_file
from docs.make_axis_map import CELL

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "path-turn.md"
BEGIN, END = "<!-- numbers: python -m docs.make_path_turn -->", "<!-- end of numbers -->"
LEANING = "<!-- numbers of leaning: python -m docs.make_path_turn -->"
UPSIDE = ('xyz = [1500.0, -100.0, 800.0]', 'xyz = [1700.0, 0.0, 700.0]\nrpy = [180.0, 0.0, 0.0]')
PATHS = (
    (ROOT / "examples" / "wave.nc", False),
    (ROOT / "examples" / "pocket.nc", False),
    (ROOT / "examples" / "contour.nc", False),
    (ROOT.parent / "shared" / "data" / "cam" / "clsf_nx" / "ust_a.cls", True),
)
HEAD = (
    "| path | standard deviation, µm, constant | chosen | reversals in the cut, constant | chosen "
    "| cost, µm², constant | chosen |\n"
    "| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n"
)
LEANING_HEAD = (
    "| path | standard deviation, µm, upright | leaning | reversals in the cut, upright | leaning "
    "| cost, µm², upright | leaning | mean lean, ° | largest |\n"
    "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n"
)
RAILS = "<!-- numbers of rails: python -m docs.make_path_turn -->"
RAILS_HEAD = (
    "| path | standard deviation, µm, E1 near 0 | chosen | reversals in the cut, E1 near 0 | chosen "
    "| cost, µm², E1 near 0 | chosen | E1, mm |\n"
    "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n"
)
NEAR, WIDE = (-10.0, 10.0), (-1000.0, 1000.0)


def report_of(toolpath: Path, upside: bool, *solve: str) -> dict[str, Any]:
    """The JSON report of a path with a chosen turn."""
    with tempfile.TemporaryDirectory() as folder:
        text = CELL.replace(*UPSIDE) if upside else CELL
        cell = Path(folder) / "cell.toml"
        cell.write_text(text + "\n".join(["\n[solve]", 'turn = "path"', *solve, ""]))
        return compensate_file(toolpath, cell, Path(folder) / "out.csv").report


def row(toolpath: Path, upside: bool) -> str:
    """A line of the table of turns."""
    turn = report_of(toolpath, upside)["turn"]
    return _row(toolpath, turn["constant"], turn["chosen"])


def leaning_row(toolpath: Path, upside: bool) -> str:
    """A line of the table of leans: without and with."""
    turn = report_of(toolpath, upside, "lean = 5.0")["turn"]
    lean = turn.get("lean", {"upright": turn["chosen"], "mean_deg": 0.0, "max_deg": 0.0})
    angles = tuple(f"{lean[key]:.1f}" for key in ("mean_deg", "max_deg"))
    return _row(toolpath, lean["upright"], turn["chosen"], *angles)


def rail_row(toolpath: Path, upside: bool) -> str:
    """A line of the table of rails: near where the path was placed, and within a metre of it."""
    near, wide = (_on_a_rail(toolpath, upside, span) for span in (NEAR, WIDE))
    use = wide["axes"]["E1"]
    places = f"{use['least_mm']:.0f}" + (f" to {use['greatest_mm']:.0f}" if use["moves"] else "")
    return _row(toolpath, near["chosen"], wide["chosen"], places)


def _on_a_rail(toolpath: Path, upside: bool, span: tuple[float, float]) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        text = CELL.replace(*UPSIDE) if upside else CELL
        rail = f'[external.E1]\ncarries = "robot"\ndirection = [0.0, 1.0, 0.0]\nfree = true\nrange = {list(span)}\n'
        cell = Path(folder) / "cell.toml"
        cell.write_text(f"{text}\n{rail}")
        found: dict[str, Any] = preview_file(toolpath, cell).report["external"]
        return found


def _row(toolpath: Path, one: dict[str, Any], other: dict[str, Any], *more: str) -> str:
    cells = [f"`{toolpath.name}`"]
    for key, digits in (("deflection_sd_um", 1), ("reversals_in_cut", 0)):
        cells += [f"{of[key]:.{digits}f}" for of in (one, other)]
    cells += [f"{of['cost_um2']['sum']:.0f}" for of in (one, other)]
    return f"| {' | '.join([*cells, *more])} |\n"


def main() -> None:
    """Fill the tables of the page."""
    text = PAGE.read_text(encoding="utf-8")
    paths = [path for path in PATHS if path[0].exists()]
    for begin, head, line in (
        (BEGIN, HEAD, row), (LEANING, LEANING_HEAD, leaning_row), (RAILS, RAILS_HEAD, rail_row)
    ):  # fmt: skip
        before, rest = text.split(begin)
        _, after = rest.split(END, 1)
        text = f"{before}{begin}\n\n{head}{''.join(line(*path) for path in paths)}\n{END}{after}"
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
