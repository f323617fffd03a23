"""What ``write`` of the Python interface does: the file of a result, under the rules that hold for every verb."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from compensator.errors import CompensatorError
from compensator.program.export import Export, program_of
from compensator.program.filter_in_place import filter_of
from compensator.program.maker import ProgramMaker
from compensator.program.provenance import seal
from compensator.report.json.path import path_report
from compensator.results import DiagnoseResult, IdentifyResult, PathResult, TaskResult, WrittenFiles
from compensator.solve.assessment import assessed
from compensator.tasks.diagnose import refined_text
from compensator.tasks.identify import fitted_model
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import current_run, writes
from stiffness.model.model import model_text
from toolpaths.files import language_of, write_program
from toolpaths.languages.table import Language

PARQUET = ".parquet"


@writes("program")
def write_path(result: PathResult, program: Path, language: str | None = None) -> WrittenFiles:
    """A robot program of a compensated path, a csv of a previewed one.

    Raises:
        ToolpathError, CompensatorError: refused; nothing was changed.
    """
    _refuse_inputs(result)
    spoken = language_of(program, language, like=result.files)
    if not result.result.is_corrected:
        return _write_preview(result, program, spoken)
    maker = _maker(result, spoken, program)
    maker.check(result.result.job.placement, result.result.path.toolpath, program)
    with Outputs() as outputs:
        with outputs.writing(program, spoken.writes) as staged:
            made = maker.write(result.result, staged)
            checked = maker.verify(made, program)
            seal(made.files, float(checked.error[made.result.cutting].max()))
        files = outputs.add(made.files[0], program, made.files[1:])
        judged = assessed(made.result, made.findings)
        judged.collisions.refuse_contacts()
        numbers = path_report(judged, checked.error, seconds=result.summary["seconds"])
        summary = {**numbers, "provenance": result.provenance.as_dict()}
        outputs.commit()
    return WrittenFiles(files, summary)


def _write_preview(result: PathResult, program: Path, spoken: Language) -> WrittenFiles:
    if not spoken.table:
        raise CompensatorError(f"{program}: a preview is written as csv; compensate makes {spoken.name} programs")
    with Outputs() as outputs:
        with outputs.writing(program, spoken.writes) as staged:
            made = write_program(program_of(result.result, corrected=False), staged, spoken.name)
        files = outputs.add(made.files[0], program)
        outputs.commit()
    judged = assessed(result.result, made.findings, corrected=False)
    error = np.linalg.norm(result.result.error_before, axis=1)
    return WrittenFiles(files, path_report(judged, error, seconds=result.summary["seconds"], corrected=False))


def _maker(result: PathResult, spoken: Language, program: Path) -> ProgramMaker:
    """Anew, or in place, as the path was compensated for."""
    name = result.source.language
    if result.language is None and result.files is not None and spoken.filtered and spoken.name == name:
        what = f"{result.source.source} is {name}, too, and is changed in place"
        raise CompensatorError(f"{program}: {what}: compensate it with language={name!r}")
    if result.language is None:
        return Export.of(result.result.job.placement, result.source, spoken, result.provenance.stamp)
    if result.language.name != spoken.name:
        what = f"the path was compensated for language={result.language.name!r}, not {spoken.name!r}"
        raise CompensatorError(f"{program}: {what}: compensate it for that, or name another file")
    maker = None if result.files is None else filter_of(
        result.files, result.source, spoken, result.provenance.stamp
    )
    if maker is None:
        raise CompensatorError(f"{program}: {result.source.source} cannot be changed in place")
    return maker


@writes("model")
def write_model(result: TaskResult, model: Path) -> WrittenFiles:
    """The model file of a fit, or the refined one of a diagnosis.

    Raises:
        CompensatorError: the result has no file, or it cannot be written there; nothing was changed.
    """
    _refuse_inputs(result)
    if isinstance(result, IdentifyResult):
        prior = None if result.prior is None else Path(result.prior)
        text = model_text(fitted_model(result.fit, result.sessions[0], model, prior))
    elif isinstance(result, DiagnoseResult):
        text = refined_text(result.diagnosis, result.known, result.sessions, model)
    else:
        raise CompensatorError(f"{model}: {type(result).__name__} has no file: take its summary or to_pandas()")
    with Outputs() as outputs:
        outputs.text(model, text)
        outputs.commit()
    return WrittenFiles((model,), result.summary)


@writes("table")
def write_parquet(result: TaskResult, table: Path) -> WrittenFiles:
    """The columns of a result as Parquet.

    Raises:
        CompensatorError: pyarrow is not installed, or the file cannot be written there; nothing was changed.
    """
    _refuse_inputs(result)
    try:
        from pyarrow import Table, parquet
    except ImportError as e:
        remedy = "pip install 'toolpath-compensator[parquet]', or take columns(), which needs nothing"
        raise CompensatorError(f"{table}: pyarrow is not installed: {remedy}") from e
    with Outputs() as outputs:
        with outputs.writing(table, PARQUET) as staged:
            columns = {name: list(values) for name, values in result.columns().items()}
            parquet.write_table(Table.from_pydict(columns), staged)
        files = outputs.add(staged, table)
        outputs.commit()
    return WrittenFiles(files, result.summary)


def _refuse_inputs(result: TaskResult) -> None:
    """What the result was made from counts as read by this run, too."""
    run = current_run()
    if run is None:
        return
    for file in result.inputs:
        run.opened(file)
