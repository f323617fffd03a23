"""`check`: all that is wrong with a cell and a toolpath, or assumed of them, at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from compensator.cell.arm import Arm, load_arm
from compensator.cell.cell_file import Cell, load_cell
from compensator.cell.job import job_of
from compensator.cell.placement import placement_of
from compensator.errors import CellError, CompensatorError, OutputError
from compensator.program.maker import refuse_study_frame
from compensator.program.robot_program import job_for
from compensator.report.json.check import check_report
from compensator.report.json.text import as_json
from compensator.solve.assessment import assessed
from compensator.solve.compensate import compensate, uncompensated
from compensator.solve.planned import planned
from compensator.solve.worth import Worth, worths
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from stiffness.errors import StiffnessError
from stiffness.model.model import load_model
from stiffness.robot.load import load_robot
from stiffness.text_file import toml_table
from toolpaths.errors import ToolpathError
from toolpaths.files import read_program
from toolpaths.finding import ERROR, Finding, of_kind
from toolpaths.program_files import program_files
from toolpaths.toolpath import Toolpath

T = TypeVar("T")
REFUSALS = (CompensatorError, StiffnessError, ToolpathError)


@dataclass(frozen=True, repr=False)
class Checked:
    """What was found: the JSON report, the files that were written."""

    report: dict[str, Any]
    files: tuple[Path, ...]

    def refuse_errors(self) -> None:
        """End with exit status 1 where there are errors.

        Raises:
            CompensatorError: counts them.
        """
        if count := self.report["n_errors"]:
            raise CompensatorError(f"{count} error{'s' if count > 1 else ''} to be mended first")


class _Collected:
    """What the steps of a check found so far; a refusal becomes an error, and what needs the step is left out."""

    def __init__(self) -> None:
        self.findings: list[Finding] = []

    def step(self, kind: str, do: Callable[[], T]) -> T | None:
        """What ``do`` gives; None where it is refused."""
        try:
            return do()
        except OutputError:
            raise
        except REFUSALS as e:
            self.error(kind, str(e))
            return None

    def error(self, kind: str, what: str) -> None:
        """One error; the same words once."""
        if what not in [f.what for f in self.findings]:
            self.findings.append(Finding(ERROR, "", what, kind=kind))

    def add(self, kind: str, findings: Iterable[Finding]) -> None:
        """What a stage found."""
        self.findings.extend(of_kind(kind, findings))


@writes("json")
def check_files(
    cell: Path,
    toolpath: Sequence[Path] = (),
    *,
    read_as: str | None = None,
    json: Path | None = None,
    say: Say = quiet,
) -> Checked:
    """Check a cell, and the toolpath that it is for.

    Args:
        toolpath: the file, or those of a program; empty: the cell alone, without what assumptions are worth.

    Raises:
        CompensatorError: the JSON cannot be written. What is wrong with cell and toolpath is in the report.
    """
    found = _Collected()
    say("reading the cell")
    table = found.step("cell", lambda: load_cell(cell))
    arm = _arm(cell, table, found)
    say("reading the toolpath" if toolpath else "looking at the cell")
    source = _source(toolpath, table, read_as, found)
    worth: tuple[Worth, ...] = ()
    if table is not None and arm is not None:
        if source is None:
            _alone(table, arm, bool(toolpath), found)
        else:
            worth = _path(table, source, found, say)
    elif table is not None:
        found.step("cell", lambda: placement_of(table))
    report = check_report(found.findings, worth)
    if json:
        with Outputs() as outputs:
            outputs.text(json, as_json(report))
            outputs.commit()
    return Checked(report, (json,) if json else ())


def _arm(cell: Path, table: Cell | None, found: _Collected) -> Arm | None:
    """Robot and model; where they or the cell are refused, each is looked at by itself."""
    if table is not None:
        arm = found.step("model", lambda: load_arm(table))
        if arm is not None:
            return arm
    named = _named(cell) if table is None else {"robot": table.robot, "model": table.model}
    if "robot" in named and table is None:
        found.step("model", lambda: load_robot(named["robot"], folder=cell.parent))
    if "model" in named:
        found.step("model", lambda: load_model(named["model"], folder=cell.parent))
    return None


def _named(cell: Path) -> dict[str, str]:
    """Robot and model of a cell that is refused, as far as they stand in it."""
    try:
        raw = toml_table(str(cell), cell, CellError, schema="cell/1")
    except CellError:
        return {}
    return {key: raw[key] for key in ("robot", "model") if isinstance(raw.get(key), str)}


def _source(
    toolpath: Sequence[Path], table: Cell | None, read_as: str | None, found: _Collected
) -> Toolpath | None:
    if not toolpath:
        return None
    if table is None:
        return found.step("toolpath", lambda: read_program(program_files(toolpath, read_as)))
    chord, machine = table.sampling.chord / 1e3, table.posted_for()
    return found.step(
        "toolpath", lambda: read_program(program_files(toolpath, read_as), chord=chord, machine=machine)
    )


def _alone(table: Cell, arm: Arm, asked: bool, found: _Collected) -> None:
    """The cell without a path; a robot program may bring its own tool and work object."""
    placement = found.step("cell", lambda: placement_of(table))
    if placement is not None:
        job = found.step("cell", lambda: job_of(arm, placement))
        found.add("cell", () if job is None else job.findings)
        if job is not None and not asked:
            found.step("cell", lambda: refuse_study_frame(job))


def _path(table: Cell, source: Toolpath, found: _Collected, say: Say) -> tuple[Worth, ...]:
    """The whole run without its program, and what is assumed in it."""
    made = found.step("cell", lambda: job_for(table, source, with_rapids=True))
    if made is None:
        return ()
    job, path = made
    found.step("cell", lambda: refuse_study_frame(job))
    say("following the path")
    plan = found.step("path", lambda: planned(job, path))
    if plan is None:
        found.add("toolpath", source.findings)
        found.add("cell", job.findings)
        return ()
    say("predicting")
    plain = found.step("solve", lambda: uncompensated(job, plan))
    if plain is None:
        return ()
    judged = found.step("solve", lambda: assessed(plain, corrected=False))
    found.add("cell", () if judged is None else judged.findings)
    say("solving")
    found.step("solve", lambda: compensate(job, plan, load=plain.load))
    say("looking at what is assumed")
    return found.step("solve", lambda: worths(plain)) or ()


