"""A trial as a program: followed by the arm, with the rows that readings are taken at."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import Cell
from compensator.cell.job import Job, job_of
from compensator.cell.placement import placement_of
from compensator.errors import CellError
from compensator.process.constant import ConstantWrenchTable
from compensator.program.export import program_of
from compensator.solve.compensate import uncompensated
from compensator.solve.planned import planned
from compensator.trials.begin import beginning_at
from compensator.trials.trial_path import TrialMoves, toolpath_of
from toolpaths.writing.program import Program

Floats = npt.NDArray[np.float64]
HEADING = "Test program"
AIR = ConstantWrenchTable(kind="constant", frame="base", wrench=(0.0,) * 6)


@dataclass(frozen=True, repr=False)
class TrialProgram:
    """A program to be measured.

    Attributes:
        program: as the writers take it. rows: (M,) of it where readings are taken, as ``index`` counts them.
        position: (M, 3) m, work object, there. torque: (M, n) N*m of the joints there, of weight alone.
        columns: name -> (M,) of what is told beside the readings.
    """

    program: Program
    rows: npt.NDArray[np.intp]
    position: Floats
    torque: Floats
    columns: dict[str, Floats]

    def __repr__(self) -> str:
        return f"TrialProgram({len(self.rows)} readings)"


def trial_job(cell: Cell) -> Job:
    """The job of a cell in which nothing is cut.

    Raises:
        CellError: there are several tools, or the cell is refused.
    """
    job = job_of(load_arm(cell), placement_of(cell.model_copy(update={"process": AIR})))
    if len(job.placement.tools.by_number) > 1:
        raise CellError(f"{cell.source}: several tools; a plan is for one: give a cell with one [tool]")
    if free := [name for name, axis in cell.external.items() if axis.free]:
        what = f"{cell.source}: external.{free[0]}.free = true"
        raise CellError(f"{what}: a test program is for the arm where it stands: take free and its range away")
    return job


def trial_program(job: Job, trial: TrialMoves, name: str, begin: Floats) -> TrialProgram:
    """Follow a trial with the arm.

    Args:
        name: of the program, where the cell gives none; of the path in messages.
        begin: (n,) rad, a posture of the arm configuration that the trial was chosen in.

    Raises:
        PathError: the arm cannot follow it.
    """
    path = planned(replace(job, planner=beginning_at(job.planner, begin)), toolpath_of(trial, name))
    result = uncompensated(job, path)
    read = np.flatnonzero(trial.read)
    rows = np.searchsorted(path.toolpath.row, read)
    return TrialProgram(
        program=replace(program_of(result, corrected=False, name=name), heading=HEADING),
        rows=rows.astype(np.intp),
        position=trial.position[read],
        torque=result.command.torque[rows],
        columns={column: values[read] for column, values in trial.columns.items()},
    )
