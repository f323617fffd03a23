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

from compensator.cell.cell import load_cell
from compensator.cell.external_axes import without_external
from compensator.cell.job import Job
from compensator.path.planner import Planner
from compensator.program.export import program_of
from compensator.program.filter import Filtered, filter_for, filter_program, verify_filtered
from compensator.program.robot_program import completed, job_for
from compensator.report.json.path import path_report
from compensator.report.json.text import as_json
from compensator.solve.compensation import Compensation
from compensator.solve.solve import compensate, sampled, uncompensated
from compensator.solve.verify import verify
from compensator.tasks.outputs import Outputs, refuse_clashes
from toolpaths.languages.read import READERS, read_toolpath
from toolpaths.languages.write import Written, format_of, write_program
from toolpaths.rewriting.filters import refuse_compensated
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
    if language is None and program.suffix.lower() == toolpath.suffix.lower():
        language = READERS.get(program.suffix.lower())  # part.ngc becomes part_c.ngc
    language = format_of(program, language)
    refuse_clashes((toolpath, cell), (program, report, json))
    _refuse_compensated(toolpath)
    job, path, source = _loaded(toolpath, cell, say)
    in_place = filter_for(source, language, toolpath)
    say("solving")
    result = compensate(job, path, rapids_stay=in_place is not None)
    with Outputs() as outputs:
        say(f"writing {language}")
        with outputs.writing(program) as staged:
            written: Written | Filtered
            if in_place is not None:
                written = filter_program(result, source.row, toolpath, staged, in_place)
                result = written.result
                say("verifying the written program")
                checked = verify_filtered(result, written, program)
            else:
                alone = without_external(program_of(result), job.cell, source, language)
                written = write_program(alone, staged, language)
                say("verifying the written program")
                checked = verify(result, staged, language)
        for file in written.files:
            outputs.add(file, program.parent / file.name)
        seconds = time.monotonic() - began
        numbers = path_report(result, checked.error, result.command.q, seconds=seconds)
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
    planner = Planner(job.cell, job.robot, job.inverse, job.tools)
    result = uncompensated(job, planner.plan(sampled(job, path)))
    error = np.linalg.norm(result.error_before, axis=1)
    seconds = time.monotonic() - began
    numbers = path_report(result, error, result.path.q, seconds=seconds, corrected=False)
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
    return job, path, completed(job, source)


def _refuse_compensated(toolpath: Path) -> None:
    try:
        data = toolpath.read_bytes()
    except OSError:
        return  # the reader says what is wrong with it
    refuse_compensated(data, str(toolpath))
    if toolpath.suffix.lower() == ".ls":  # a remark holds 32 characters: the marker takes two of them
        from toolpaths.languages.fanuc.reader import refuse_written

        refuse_written(data, str(toolpath))


def _report(
    outputs: Outputs,
    target: Path,
    result: Compensation,
    numbers: dict[str, Any],
    say: Say,
    after: Floats | None = None,
) -> None:
    from compensator.report.html.path import path_page

    say("drawing the report")
    outputs.text(target, path_page(result, numbers, after))
