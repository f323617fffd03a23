"""LiveCell: a cell and its toolpath, computed anew for every edit; what a page shows of them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from compensator.cell.arm import Arm, load_arm
from compensator.cell.cell_file import checked_cell
from compensator.cell.job import Job, job_of
from compensator.cell.placement import placement_of
from compensator.errors import CellError
from compensator.program.robot_program import job_for
from compensator.report.json.path import path_report
from compensator.report.scene.posture import posture_scene
from compensator.report.scene.scene import path_scene
from compensator.report.words.three_numbers import three_numbers
from compensator.solve.assessment import assessed
from compensator.solve.compensate import compensate
from compensator.solve.joint_state import equilibrium_along
from compensator.solve.planned import planned
from compensator.viewer.cell_edit import Edit, editable_tables, edited_text
from toolpaths.toolpath import Toolpath

Shown = dict[str, Any]


@dataclass(frozen=True, repr=False)
class LiveCell:
    """A cell with its toolpath.

    Attributes:
        path: the cell file; text: as it was read.
        source: the toolpath; None: only the arm is shown. texts: its lines.
    """

    path: Path
    text: str
    source: Toolpath | None
    texts: Mapping[int, str]

    def __repr__(self) -> str:
        return f"LiveCell({str(self.path)!r}, {self.source!r})"

    @property
    def editable(self) -> dict[str, dict[str, list[float]]]:
        """What can be edited, as the file has it; a robot program brings work object and tools of its own."""
        tables = editable_tables(tomllib.loads(self.text))
        return {} if self.source is not None and self.source.setting is not None else tables

    def edited(self, edit: Edit) -> str:
        """The text of the cell with an edit."""
        return edited_text(self.text, edit) if edit else self.text

    def shown(self, edit: Edit) -> Shown:
        """Scene, numbers and values of the cell with an edit.

        Raises:
            CompensatorError, StiffnessError, ToolpathError: the arm cannot do it; says why, with pose and line.
        """
        text = self.edited(edit)
        table = tomllib.loads(text)
        cell = checked_cell(table, str(self.path), self.path.parent)
        values = editable_tables(table) if self.editable else {}
        if self.source is None:
            job = job_of(self._arm, placement_of(cell))
            return {"scene": posture_scene(job), "numbers": [], "values": values}
        return {**_of_path(*job_for(cell, self.source, arm=self._arm), self.texts), "values": values}

    @cached_property
    def _arm(self) -> Arm:
        """No edit changes it; it keeps what was made for the tools that it had."""
        return load_arm(checked_cell(tomllib.loads(self.text), str(self.path), self.path.parent))


def _of_path(job: Job, path: Toolpath, texts: Mapping[int, str]) -> Shown:
    result = compensate(job, planned(job, path))
    left, _ = equilibrium_along(
        result.job.arm, job.placement.start, result.path.toolpath, q=result.command.q, wrench=result.wrench
    )
    after = np.linalg.norm(left.position - result.target.origin, axis=1)
    judged = assessed(result)
    report = path_report(judged, after, seconds=0.0)
    scene = path_scene(result, report, after, judged=judged, texts=texts)
    return {"scene": scene, "numbers": three_numbers(report, corrected=True)}


def live_cell(path: Path, source: Toolpath | None, texts: Mapping[int, str]) -> LiveCell:
    """The cell of a file.

    Raises:
        CellError: it cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as e:
        raise CellError(f"{path}: cannot be read: {e}") from e
    return LiveCell(path, text, source, texts)
