"""The verbs of the command line as functions on objects: what ``import compensator as comp`` offers.

Paths may be str or Path; where a cell, a model or a toolpath is asked for, one that is loaded already will do.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from compensator.cell.cell_file import Cell
from compensator.cell.cell_file import load_cell as _load_cell
from compensator.cell.named_files import named_files
from compensator.errors import CompensatorError
from compensator.program.filter_in_place import filter_of
from compensator.program.maker import refuse_study_frame, refuse_what_is_kept
from compensator.program.provenance import provenance_of
from compensator.program.robot_program import job_for, with_joint_poses
from compensator.report.json.diagnosis import diagnosis_report
from compensator.report.json.fit import fit_report, local_fit_report
from compensator.report.json.path import path_report
from compensator.results import DiagnoseResult, EvaluateResult, IdentifyResult, PathResult, TaskResult, WrittenFiles
from compensator.solve.assessment import assessed
from compensator.solve.compensate import compensate as _compensate
from compensator.solve.compensate import uncompensated
from compensator.solve.planned import planned
from compensator.tasks.identify import evaluated, fitted_model
from compensator.tasks.robot_reference import refuse_other_robot
from compensator.tasks.write_result import PARQUET, write_model, write_parquet, write_path
from stiffness.diagnosis.diagnose import diagnose as _diagnose
from stiffness.errors import StiffnessError
from stiffness.identify import identify as _identify
from stiffness.local_method.identify import identify_local
from stiffness.model.model import ComplianceModel
from stiffness.model.model import load_model as _load_model
from stiffness.robot.load import load_robot as _load_robot
from stiffness.robot.robot import Robot
from stiffness.session.session import Session, load_session
from toolpaths.files import language_of, read_program, refuse_own
from toolpaths.languages.table import Language
from toolpaths.program_files import ProgramFiles, program_files
from toolpaths.toolpath import Toolpath

AnyPath = str | os.PathLike[str]
Paths = AnyPath | Sequence[AnyPath]


def load_robot(name_or_path: AnyPath, *, base: str | None = None, tip: str | None = None) -> Robot:
    """A built-in robot by name, or a robot file (.toml, .urdf).

    Raises:
        RobotError: no such robot, or its file is refused.
    """
    return _load_robot(os.fspath(name_or_path), base=base, tip=tip)


def load_model(name_or_path: AnyPath) -> ComplianceModel:
    """A model/1 file, or the stiffness set of a built-in robot by name; values in SI.

    Raises:
        ModelError: names the file, the key, the value and what was expected.
    """
    return _load_model(os.fspath(name_or_path))


def load_cell(path: AnyPath) -> Cell:
    """A cell/1 file; its values as in the file: mm, deg, kg.

    Raises:
        CellError: all that is wrong in it, in one message.
    """
    return _load_cell(Path(path))


def read_toolpath(toolpath: Paths, cell: Cell | AnyPath | None = None, *, read_as: str | None = None) -> Toolpath:
    """A CAM file or a robot program: poses in SI, in the work object.

    Args:
        toolpath: the file; several, or their folder, where a program is made of several.
        cell: gives [sampling] chord and [machine]; None: arcs within 0.01 mm, no machine.
        read_as: language, where the suffix does not tell it.

    Raises:
        ReadError: names the line, what stands there and what to do.
    """
    return _read(program_files(_listed(toolpath), read_as), None if cell is None else _cell(cell))


def preview(toolpath: Toolpath | Paths, cell: Cell | AnyPath, *, read_as: str | None = None) -> PathResult:
    """The predicted deflection of every pose, uncompensated.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: as the command line refuses it.
    """
    began, (table, files, source) = time.monotonic(), _given(toolpath, cell, read_as)
    job, path = job_for(table, source)
    result = uncompensated(job, planned(job, path))
    judged = assessed(result, corrected=False)
    error = np.linalg.norm(result.error_before, axis=1)
    made_from = provenance_of(table, source)
    summary = path_report(judged, error, seconds=time.monotonic() - began, corrected=False)
    return PathResult(
        {**summary, "provenance": made_from.as_dict()}, _inputs(table, source), judged=judged, source=source,
        files=files, language=None, provenance=made_from,
    )  # fmt: skip


def compensate(
    toolpath: Toolpath | Paths, cell: Cell | AnyPath, *, language: str | None = None, read_as: str | None = None
) -> PathResult:
    """Commands whose deflected TCP stands on the path; ``write`` makes the program.

    Args:
        language: of the program that will be written. The language of the source itself has it changed in place, and
            needs its files, not a ``Toolpath``. None: any other language.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: as the command line refuses it.
    """
    began, (table, files, source) = time.monotonic(), _given(toolpath, cell, read_as)
    for file in () if files is None else files.paths:
        refuse_own(file, read_as)
    filtered, made_from = _filtered(files, source, language), provenance_of(table, source)
    job, path = job_for(table, source, with_rapids=filtered is None)
    refuse_study_frame(job)
    refuse_what_is_kept(job, filtered is not None)
    source = with_joint_poses(job.placement, job.arm.robot, source)
    if files is not None and filtered is not None:
        filter_of(files, source, filtered)  # refuses what no filter can keep, before anything is solved
    result = _compensate(job, planned(job, path), rapids_stay=filtered is not None)
    judged = assessed(result)
    judged.collisions.refuse_contacts()
    summary = path_report(judged, result.command.error, seconds=time.monotonic() - began)
    return PathResult(
        {**summary, "provenance": made_from.as_dict()}, _inputs(table, source), judged=judged, source=source,
        files=files, language=filtered, provenance=made_from,
    )  # fmt: skip


def identify(
    sessions: Paths | Session | Sequence[Session],
    *,
    method: str = "global",
    effects: Sequence[str] | None = None,
    prior: ComplianceModel | AnyPath | None = None,
) -> IdentifyResult:
    """A stiffness model from measurement sessions of one robot; ``write`` makes the model file.

    Args:
        method: ``global``: all readings at once; ``local``: joint by joint, without ``effects`` and ``prior``.
        effects: names that fix the set; None: those that the data ask for.
        prior: model to start from; its standard deviations are prior knowledge.

    Raises:
        StiffnessError: as the command line refuses it.
    """
    loaded = _sessions(sessions)
    if method not in ("global", "local"):
        raise StiffnessError(f"method = {method!r}: expected 'global' or 'local'")
    if method == "local" and (effects is not None or prior is not None):
        raise StiffnessError("method = 'local' takes no effects and no prior: it fits the joints one by one")
    known = None if prior is None else _model(prior)
    if known is not None:
        refuse_other_robot(loaded[0], known)
    read = (*_session_files(loaded), *(() if known is None else (Path(known.source),)))
    if method == "local":
        local = identify_local(*loaded)
        summary = local_fit_report(local, fitted_model(local, loaded[0], Path()))
        return IdentifyResult(summary, read, fit=local, sessions=loaded, prior=None)
    fit = _identify(loaded, effects, known)
    begun = None if known is None else known.source
    return IdentifyResult(fit_report(fit), read, fit=fit, sessions=loaded, prior=begun)


def diagnose(sessions: Paths | Session | Sequence[Session], model: ComplianceModel | AnyPath) -> DiagnoseResult:
    """What a model lacks in the readings of sessions; ``write`` makes the refined model.

    Raises:
        StiffnessError: as the command line refuses it.
    """
    loaded, known = _sessions(sessions), _model(model)
    for session in loaded:
        refuse_other_robot(session, known)
    found = _diagnose(loaded, known)
    read = (*_session_files(loaded), Path(known.source))
    return DiagnoseResult(diagnosis_report(found), read, diagnosis=found, sessions=loaded, known=known)


def evaluate(
    session: Session | AnyPath, model: ComplianceModel | AnyPath, *, register: int | None = None
) -> EvaluateResult:
    """How well a model predicts the readings of a session.

    Args:
        register: states per block that place the tracker; None: 25 where the session is not registered.

    Raises:
        StiffnessError: as the command line refuses it.
    """
    (loaded,), known = _sessions(session), _model(model)
    found, summary = evaluated(loaded, known, register)
    return EvaluateResult(summary, (*_session_files((loaded,)), Path(known.source)), evaluation=found)


def write(result: TaskResult, path: AnyPath, *, language: str | None = None) -> WrittenFiles:
    """The file of a result: all of it or none, and never over what the result was made from.

    A compensated path becomes a robot program, which is read back from the disk and run through the model again; a
    previewed one a csv; a fit or a diagnosis a model file. With the suffix ``.parquet`` the table of any result.

    Args:
        language: of a program, where the suffix does not tell it.

    Raises:
        CompensatorError: the result has no file, or cannot be written there. Nothing was changed.
    """
    target = Path(path)
    if target.suffix.lower() == PARQUET:
        return write_parquet(result, target)
    if isinstance(result, PathResult):
        return write_path(result, target, language)
    return write_model(result, target)


def _given(
    toolpath: Toolpath | Paths, cell: Cell | AnyPath, read_as: str | None
) -> tuple[Cell, ProgramFiles | None, Toolpath]:
    table = _cell(cell)
    if isinstance(toolpath, Toolpath):
        return table, None, toolpath
    files = program_files(_listed(toolpath), read_as)
    return table, files, _read(files, table)


def _read(files: ProgramFiles, cell: Cell | None) -> Toolpath:
    if cell is None:
        return read_program(files)
    return read_program(files, chord=cell.sampling.chord / 1e3, machine=cell.posted_for())


def _filtered(files: ProgramFiles | None, source: Toolpath, name: str | None) -> Language | None:
    """The language of a filter in place; None: the program is written anew."""
    if name is None:
        return None
    language = language_of(source.source, name)
    if language.name != source.language or not language.filtered:
        return None
    if files is None:
        what = f"language = {name!r} is that of {source.source}, which is changed in place"
        raise CompensatorError(f"{what}: give its path, not a Toolpath")
    return language


def _cell(cell: Cell | AnyPath) -> Cell:
    return cell if isinstance(cell, Cell) else load_cell(cell)


def _model(model: ComplianceModel | AnyPath) -> ComplianceModel:
    return model if isinstance(model, ComplianceModel) else load_model(model)


def _listed(paths: Paths) -> list[Path]:
    return [Path(p) for p in ([paths] if isinstance(paths, str | os.PathLike) else paths)]


def _sessions(sessions: Paths | Session | Sequence[Session]) -> tuple[Session, ...]:
    given = [sessions] if isinstance(sessions, str | os.PathLike | Session) else list(sessions)
    if not given:
        raise StiffnessError("no sessions: expected the path of a session.toml, or several")
    return tuple(s if isinstance(s, Session) else load_session(Path(s)) for s in given)


def _session_files(sessions: Sequence[Session]) -> tuple[Path, ...]:
    """The session files and what stands beside them under the names of the format."""
    own = [Path(s.source) for s in sessions]
    return tuple(file for path in own for file in (path, *sorted(path.parent.glob("*.csv"))))


def _inputs(cell: Cell, source: Toolpath) -> tuple[Path, ...]:
    return (*named_files(cell).all, *map(Path, source.sources or (source.source,)))
