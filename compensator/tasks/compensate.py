"""What the commands do, from files to files."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.cell_file import load_cell
from compensator.cell.external_axes import without_external
from compensator.cell.job import Job
from compensator.program.export import program_of
from compensator.program.filter import Filtered, filter_program, filtered_in_place, verify_filtered
from compensator.program.robot_program import completed, job_for
from compensator.report.json.path import as_json, summary
from compensator.solve.compensate import compensate, uncompensated
from compensator.solve.compensation import Compensation
from compensator.solve.planned import planned
from compensator.solve.verify import verify
from compensator.tasks.outputs import Outputs, refuse_clashes
from toolpaths.files import Written, language_of, read_toolpath, refuse_own, write_program
from toolpaths.toolpath import Toolpath
from toolpaths.writing.program import Finding

Floats = npt.NDArray[np.float64]
Say = Callable[[str], None]


@dataclass(frozen=True, repr=False)
class Done:
    """What a task made: the result, its JSON report, the files, and findings about the program."""

    result: Compensation
    report: dict[str, Any]
    files: tuple[Path, ...]
    findings: tuple[str, ...]


def quiet(_: str) -> None:
    return None


def compensate_file(
    toolpath: Path,
    cell: Path,
    program: Path,
    *,
    language: str | None = None,
    report: Path | None = None,
    json: Path | None = None,
    say: Say = quiet,
) -> Done:
    """The main job: a CAM file in, a compensated robot program out.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    began = time.monotonic()
    written_in = language_of(program, language, like=toolpath)
    refuse_clashes((toolpath, cell), (program, report, json))
    refuse_own(toolpath)
    job, path, source = _loaded(toolpath, cell, say)
    in_place = filtered_in_place(source, written_in, toolpath)
    say("solving")
    result = compensate(job, planned(job, path), rapids_stay=in_place)
    with Outputs() as outputs:
        say(f"writing {written_in.name}")
        with outputs.writing(program) as staged:
            written: Written | Filtered
            if in_place:
                written = filter_program(result, source.row, toolpath, staged, written_in)
                result = written.result
                say("verifying the written program")
                checked = verify_filtered(result, written, program)
            else:
                alone = without_external(program_of(result), job.placement, source, written_in.name)
                written = write_program(alone, staged, written_in.name)
                say("verifying the written program")
                checked = verify(result, staged, written_in.name)
        for file in written.files:
            outputs.add(file, program.parent / file.name)
        numbers = summary(result, checked.error, result.command.q, time.monotonic() - began)
        findings = written.changes if isinstance(written, Filtered) else written.findings
        if isinstance(written, Filtered):
            numbers["changes"] = [_change(f) for f in findings]
        if report:
            _report(outputs, report, result, numbers, say, checked.error)
        if json:
            outputs.text(json, as_json(numbers))
        outputs.commit()
    files = tuple(program.parent / f.name for f in written.files) + tuple(f for f in (report, json) if f)
    return Done(result, numbers, files, tuple(str(f) for f in findings))


def _change(finding: Finding) -> dict[str, object]:
    """A change of a filtered program for the JSON report, with every line of the source that it is about."""
    found = [re.search(r"\d+$", place) for place in finding.places or (finding.place,)]
    lines = sorted({int(m[0]) for m in found if m})
    return {"where": finding.place, "what": finding.what, "count": finding.count, "lines": lines}


def preview_file(
    toolpath: Path,
    cell: Path,
    *,
    csv: Path | None = None,
    report: Path | None = None,
    json: Path | None = None,
    say: Say = quiet,
) -> Done:
    """The deflection per pose when the nominal path is commanded.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    began = time.monotonic()
    refuse_clashes((toolpath, cell), (csv, report, json))
    job, path, _ = _loaded(toolpath, cell, say)
    say("predicting")
    result = uncompensated(job, planned(job, path))
    error = np.linalg.norm(result.error_before, axis=1)
    numbers = summary(result, error, result.path.q, time.monotonic() - began, corrected=False)
    with Outputs() as outputs:
        if csv:
            with outputs.writing(csv) as staged:
                written = write_program(program_of(result, corrected=False), staged, "csv")
            for file in written.files:
                outputs.add(file, csv.parent / file.name)
        if report:
            _report(outputs, report, result, numbers, say)
        if json:
            outputs.text(json, as_json(numbers))
        outputs.commit()
    return Done(result, numbers, tuple(f for f in (csv, report, json) if f), ())


def _loaded(toolpath: Path, cell: Path, say: Say) -> tuple[Job, Toolpath, Toolpath]:
    """The job, the path to solve, and what the reader gave."""
    say("reading the cell")
    table = load_cell(cell)
    say(f"reading {toolpath.name}")
    source = read_toolpath(toolpath, chord=table.sampling.chord / 1e3, machine=table.posted_for())
    job, path = job_for(table, source)
    return job, path, completed(job.placement, job.arm.robot, source)


def _report(
    outputs: Outputs,
    target: Path,
    result: Compensation,
    numbers: dict[str, Any],
    say: Say,
    after: Floats | None = None,
) -> None:
    from compensator.report.html.path import page

    say("drawing the report")
    outputs.text(target, page(result, numbers, after))
