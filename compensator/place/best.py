"""Best: the ranking of a study, and whether its first places hold along the whole path."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.arm import Arm
from compensator.cell.job import Job, job_of
from compensator.cell.placement import Placement
from compensator.cell.run_tables import SolveTable
from compensator.errors import CompensatorError
from compensator.place.candidates import COLUMNS, Candidates
from compensator.place.judge import GOOD
from compensator.scene.path_collisions import collisions_along
from compensator.solve.planned import planned
from stiffness.errors import StiffnessError
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Columns = dict[str, Any]
LISTED = 10


@dataclass(frozen=True)
class Place:
    """One of the best: ``row`` of the study, ``holds``: all poses were followed and nothing touches; else ``why``."""

    row: int
    holds: bool
    why: str = ""


def ranking(columns: Columns) -> npt.NDArray[np.intp]:
    """Rows of the good placements, the best first; of equals the earlier one."""
    good = np.flatnonzero(np.array(columns["status"]) == GOOD)
    score = np.array(columns["score_mm"], dtype=float)[good]
    return np.asarray(good[np.argsort(score, kind="stable")])


def first_places(arm: Arm, job: Job, toolpath: Toolpath, columns: Columns) -> Iterator[Place]:
    """The best ones, until one holds along the whole path.

    Args:
        columns: of the study, in the order of its candidates.
    """
    for row in ranking(columns)[:LISTED].tolist():
        placement = placed(job.placement, columns, row)
        try:
            there = job_of(arm, placement)
            path = planned(there, toolpath)
            collisions_along(there, path.toolpath, path.q).refuse_contacts()
        except (CompensatorError, StiffnessError) as e:
            yield Place(row, False, str(e))
            continue
        yield Place(row, True)
        return


def placed(placement: Placement, columns: Columns, row: int) -> Placement:
    """A placement with the work object, the turn and the configuration of a row: the start fixes both; where turn or
    lean are chosen along the path it fixes the configuration."""
    pose = np.array([[columns[name][row] for name in COLUMNS]])
    start = np.radians([columns[f"start_q{k + 1}_deg"][row] for k in range(6)])
    solve = placement.solve.model_copy(update={"free_tool_axis": placement.solve.along_path != ""})
    return replace(placement, workobject=Candidates(pose).frame(0), start=start, solve=solve)


def cell_table(raw: dict[str, Any], columns: Columns, row: int) -> dict[str, Any]:
    """The table of a cell file with the work object, turn and configuration of a row."""
    numbers = [round(float(columns[name][row]), 6) for name in COLUMNS]
    work = {**raw.get("workobject", {}), "xyz": numbers[:3], "rpy": numbers[3:]}
    start = {"joints": [round(float(columns[f"start_q{k + 1}_deg"][row]), 6) for k in range(6)]}
    solve = raw.get("solve", {})
    if not SolveTable(**solve).along_path:
        solve = {**solve, "free_tool_axis": False}
    return {**raw, "workobject": work, "start": start} | ({"solve": solve} if solve else {})


def seen_from(value: Any, folder: Path, target: Path) -> Any:
    """A table of a cell file in ``folder`` with its files named as seen from the folder ``target``."""
    if isinstance(value, dict):
        return {key: seen_from(inner, folder, target) for key, inner in value.items()}
    if isinstance(value, list):
        return [seen_from(inner, folder, target) for inner in value]
    if isinstance(value, str) and "." in value and "\n" not in value and not Path(value).is_absolute():
        file = folder / value
        if file.is_file():
            return Path(os.path.relpath(file.resolve(), target.resolve())).as_posix()
    return value
