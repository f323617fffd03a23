"""`compensate` and `preview`, from files to files, in the steps that docs/compensate.md names."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.cell_file import load_cell
from compensator.cell.job import Job
from compensator.program.export import Export, program_of
from compensator.program.filter_in_place import filter_of
from compensator.program.maker import ProgramMaker, refuse_study_frame, refuse_what_is_kept
from compensator.program.provenance import Provenance, provenance_of, seal
from compensator.program.robot_program import job_for, with_joint_poses
from compensator.report.json.path import path_report
from compensator.report.json.text import as_json
from compensator.solve.assessment import Assessment, assessed, assessed_beside, judged, with_findings
from compensator.solve.compensate import compensate
from compensator.solve.compensation import Compensation
from compensator.solve.coupled import previewed
from compensator.solve.planned import planned
from compensator.tasks.cut_files import refuse_without_cut, write_cut
from compensator.tasks.outputs import UNNAMED, Outputs
from compensator.tasks.picture_files import write_pictures
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.source_lines import source_lines
from compensator.tasks.strict import refuse_warnings
from stiffness.numerics.beside import beside, halves
from toolpaths.columns import give_back
from toolpaths.files import language_of, read_program, refuse_own, write_program
from toolpaths.finding import Finding
from toolpaths.languages.table import Language
from toolpaths.program_files import ProgramFiles, program_files
from toolpaths.sharing import shared_by
from toolpaths.toolpath import Toolpath
from toolpaths.writing.staging import flushed

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Done:
    """What a task made: the result as it is judged, its JSON report, and the files."""

    judged: Assessment
    report: dict[str, Any]
    files: tuple[Path, ...]

    @property
    def result(self) -> Compensation:
        """The commands."""
        return self.judged.result

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What every stage found, the worst level first."""
        return self.judged.findings


@dataclass(frozen=True, repr=False)
class RunInput:
    """Cell and toolpath, read.

    Attributes:
        path: to be solved: a robot program without its rapids that no cut starts from.
        source: as the reader gave it, its moves in joint angles completed.
        provenance: hashes of what was read.
    """

    job: Job
    path: Toolpath
    source: Toolpath
    provenance: Provenance


@writes("program", "report", "json", "engagement", "left", "glb", "pdf")
def compensate_file(
    toolpath: Path | Sequence[Path],
    cell: Path,
    program: Path,
    *,
    language: str | None = None,
    read_as: str | None = None,
    report: Path | None = None,
    json: Path | None = None,
    engagement: Path | None = None,
    left: Path | None = None,
    glb: Path | None = None,
    pdf: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Done:
    """The main job: a CAM file in, a compensated robot program out.

    Args:
        toolpath: the file; several, or their folder, where a robot program is made of several.
        cell: cell file.
        program: to be written.
        language: of the program, where its suffix does not tell it.
        read_as: language of the toolpath, where its suffix does not tell it.
        report: HTML.
        json: summary. glb: the scene for other viewers. pdf: one page.
        say: what is being done.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    began = time.monotonic()
    read_from = files_of(toolpath, read_as)
    written_in = language_of(program, language, like=read_from)
    for file in read_from.paths:
        refuse_own(file, read_as)
    given = read_input(read_from, cell, say, written_in=written_in)
    refuse_study_frame(given.job)
    refuse_without_cut(given.job.placement.process, given.job.placement.source, engagement, left)
    stamp = given.provenance.stamp
    maker: ProgramMaker | None = filter_of(read_from, given.source, written_in, stamp)
    maker = maker or Export.of(given.job.placement, given.source, written_in, stamp)
    named = Path(f"{UNNAMED}{written_in.writes}") if program == STDOUT else program
    refuse_what_is_kept(given.job, maker.in_place)
    maker.check(given.job.placement, given.path, named)
    job, toolpath_read, provenance = given.job, given.path, given.provenance
    del given  # a path that is sampled is another one
    give_back()
    say(job.placement.process.preparation() or "solving")
    path = planned(job, toolpath_read)
    del toolpath_read
    maker.check(job.placement, path.toolpath, named)
    give_back()
    handed = [path]
    del path  # one with poses put in is another one
    result = compensate(job, handed.pop(), rapids_stay=maker.in_place)
    give_back()
    with Outputs() as outputs:
        say(f"writing {written_in.name}")
        writing = outputs.writing(program, written_in.writes)
        with writing as staged, assessed_beside(result) as judging, shared_by(halves):
            made = maker.write(result, staged)
            say("verifying the written program")
            with beside(partial(flushed, made.files), known=made.files, poses=len(result)) as disk:
                checked, made = maker.verify(made, program), made.verified()
                give_back()
                same = seal(made.files, float(checked.error[made.result.cutting].max()))
                found = judging.result() if made.result is result else judged(made.result)
                disk.result()
            outputs.are_on_disk(same)
        programs = outputs.add(made.files[0], program, made.files[1:])
        assessment = with_findings(found, made.findings)
        assessment.collisions.refuse_contacts()
        numbers = path_report(assessment, checked.error, seconds=time.monotonic() - began)
        numbers["provenance"] = provenance.as_dict()
        if maker.in_place:
            numbers["changes"] = [_change(f) for f in made.findings]
        refuse_warnings(numbers, strict)
        write_cut(outputs, made.result, made.poses, engagement=engagement, left=left)
        _write_reports(outputs, assessment, numbers, report=report, json=json, after=checked.error, say=say)
        write_pictures(outputs, made.result, numbers, checked.error, glb=glb, pdf=pdf, say=say)
        outputs.commit()
    files = (*programs, *(f for f in (engagement, left, report, glb, pdf, json) if f))
    return Done(assessment, numbers, files)


@writes("csv", "report", "json", "engagement", "left", "glb", "pdf")
def preview_file(
    toolpath: Path | Sequence[Path],
    cell: Path,
    *,
    read_as: str | None = None,
    csv: Path | None = None,
    report: Path | None = None,
    json: Path | None = None,
    engagement: Path | None = None,
    left: Path | None = None,
    glb: Path | None = None,
    pdf: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Done:
    """The deflection per pose when the nominal path is commanded.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    began = time.monotonic()
    given = read_input(files_of(toolpath, read_as), cell, say)
    refuse_without_cut(given.job.placement.process, given.job.placement.source, engagement, left)
    say(given.job.placement.process.preparation() or "predicting")
    path = planned(given.job, given.path)
    result = previewed(given.job, path)
    error = np.linalg.norm(result.error_before, axis=1)
    with Outputs() as outputs:
        written: tuple[Finding, ...] = ()
        if csv:
            with outputs.writing(csv, ".csv") as staged:
                made = write_program(program_of(result, corrected=False), staged, "csv", staged=True)
            outputs.add(made.files[0], csv)
            written = made.findings
        judged = assessed(result, written, corrected=False)
        numbers = path_report(judged, error, seconds=time.monotonic() - began, corrected=False)
        numbers["provenance"] = given.provenance.as_dict()
        refuse_warnings(numbers, strict)
        write_cut(outputs, result, np.arange(len(result)), engagement=engagement, left=left)
        _write_reports(outputs, judged, numbers, report=report, json=json, after=None, say=say)
        write_pictures(outputs, result, numbers, None, glb=glb, pdf=pdf, say=say)
        outputs.commit()
    return Done(judged, numbers, tuple(f for f in (csv, engagement, left, report, glb, pdf, json) if f))


def files_of(toolpath: Path | Sequence[Path], read_as: str | None) -> ProgramFiles:
    """The files of a toolpath: one, or those of a robot program."""
    return program_files([toolpath] if isinstance(toolpath, Path) else toolpath, read_as)


def read_input(files: ProgramFiles, cell: Path, say: Say = quiet, *, written_in: Language | None = None) -> RunInput:
    """Cell and toolpath from their files, and the job that they make.

    Args:
        written_in: the language of the program that the poses are for; None: for none.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: one of them is refused, or they do not fit each other.
    """
    say("reading the cell")
    table = load_cell(cell)
    say(f"reading {files.main.name}")
    source = read_program(files, chord=table.sampling.chord / 1e3, machine=table.posted_for())
    in_place = written_in is None or (written_in.filtered and written_in.name == source.language)
    job, path = job_for(table, source, with_rapids=not in_place)
    whole = with_joint_poses(job.placement, job.arm.robot, source)
    return RunInput(job, path, whole, provenance_of(table, source))


def _change(finding: Finding) -> dict[str, object]:
    """A change of a filtered program for the JSON report, with every line of the source that it is about."""
    return {"where": finding.place, "what": finding.what, "count": finding.count, "lines": list(finding.lines)}


def _write_reports(
    outputs: Outputs,
    judged: Assessment,
    numbers: dict[str, Any],
    *,
    report: Path | None,
    json: Path | None,
    after: Floats | None,
    say: Say,
) -> None:
    """HTML and JSON, those that are asked for; ``after``: (N,) m left with the written program, None: nothing is."""
    if report:
        from compensator.report.html.path import path_page

        say("drawing the report")
        texts = source_lines(judged.result.path.toolpath)
        outputs.text(report, path_page(judged.result, numbers, after, judged=judged, texts=texts))
    if json:
        outputs.text(json, as_json(numbers))
