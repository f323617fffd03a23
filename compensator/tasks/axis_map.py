"""What `axis-map` does, from a toolpath and a cell to a table, a picture and a page."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.errors import CompensatorError
from compensator.report.csv.axis_map import axis_map_csv
from compensator.report.json.axes import axes_report
from compensator.report.json.axis_map import axis_map_report
from compensator.report.json.findings import findings_report
from compensator.report.json.text import as_json
from compensator.scene.clearance import clearance
from compensator.solve.load_along import load_along
from compensator.solve.planned import planned
from compensator.solve.touching_off import touched_off
from compensator.tasks.compensate import files_of, read_input
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from compensator.turn.axis_map import AxisMap, axis_map, map_findings
from compensator.turn.turn_grid import TURNS, refuse_without_closed_form
from toolpaths.finding import of_kind

POSES = 2000  # along the path, where nothing else is asked for
FEWEST, MOST = 8, 720  # turns


@dataclass(frozen=True, repr=False)
class AxisMapped:
    """What the task made: the map, its JSON report, the files."""

    result: AxisMap
    report: dict[str, Any]
    files: tuple[Path, ...]


@writes("csv", "png", "report", "json")
def axis_map_file(
    toolpath: Path | Sequence[Path],
    cell: Path,
    *,
    read_as: str | None = None,
    poses: int = POSES,
    turns: int = TURNS,
    csv: Path | None = None,
    png: Path | None = None,
    report: Path | None = None,
    json: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> AxisMapped:
    """Map the turns about the tool axis along a toolpath.

    Args:
        poses: at most so many, evenly along the path. turns: at each of them.
        report: HTML.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    if poses < 2:
        raise CompensatorError(f"--poses {poses}: at least 2 are needed")
    if not FEWEST <= turns <= MOST:
        raise CompensatorError(f"--turns {turns}: expected {FEWEST} to {MOST}; 72 are 5 deg apart")
    began = time.monotonic()
    given = read_input(files_of(toolpath, read_as), cell, say)
    refuse_without_closed_form(given.job.planner.inverse)
    say("following the path")
    path = planned(given.job, given.path)
    job = touched_off(given.job, path)
    wrench = load_along(job, path).wrench
    say(f"mapping {min(poses, len(path)):,} poses x {turns} turns")
    clear = clearance(job, path.toolpath) if job.placement.surroundings.scene else None
    found = axis_map(job, path, wrench, poses=poses, turns=turns, clear=clear)
    numbers = axis_map_report(found)
    chosen = () if path.axes is None else of_kind("path", path.axes.findings)
    numbers |= {} if path.axes is None else {"external": axes_report(path.axes)}
    numbers["findings"] = findings_report((*of_kind("cell", job.findings), *chosen, *map_findings(job, found)))
    numbers["provenance"] = given.provenance.as_dict()
    numbers["seconds"] = round(time.monotonic() - began, 3)
    refuse_warnings(numbers, strict)
    with Outputs() as outputs:
        if csv:
            say("writing the table")
            outputs.text(csv, axis_map_csv(found))
        if png:
            _draw(outputs, png, found, job.arm.robot.name)
        if report:
            from compensator.report.html.axis_map import axis_map_page

            outputs.text(report, axis_map_page(found, numbers, job.arm.robot.name))
        if json:
            outputs.text(json, as_json(numbers))
        outputs.commit()
    return AxisMapped(found, numbers, tuple(f for f in (csv, png, report, json) if f))


def _draw(outputs: Outputs, png: Path, found: AxisMap, robot: str) -> None:
    from compensator.report.figures.axis_map import draw

    with outputs.writing(png) as staged:
        draw(found, f"{Path(found.path.toolpath.source).name} on {robot}: turns about the tool axis", staged)
    outputs.add(staged, png)
