"""`verify`: a finished program read anew, run through the model of a cell, and compared with what its head tells."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.named_files import sha256_of
from compensator.errors import CompensatorError, SolveError
from compensator.program.changed_lines import changed_lines
from compensator.program.export import Export
from compensator.program.filter_in_place import filter_of
from compensator.program.filtered_program import FilteredProgram, verify_filtered
from compensator.program.maker import MadeProgram, ProgramMaker
from compensator.program.provenance import digest_of, head_of
from compensator.report.json.text import as_json
from compensator.report.json.verification import CONFIRMED, Standing, verification_report
from compensator.solve.compensate import compensate
from compensator.solve.planned import planned
from compensator.solve.verify import simulated
from compensator.tasks.compensate import RunInput, read_input
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from toolpaths.errors import ToolpathError
from toolpaths.files import language_of
from toolpaths.languages.table import Language, reading
from toolpaths.program_files import ProgramFiles, program_files

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Verification:
    """A JSON report with a verdict, and the files that were written."""

    report: dict[str, Any]
    files: tuple[Path, ...]

    def refuse_unconfirmed(self) -> None:
        """End with exit status 1 unless the program does what was predicted.

        Raises:
            CompensatorError: names the verdict.
        """
        if self.report["verdict"] != CONFIRMED:
            raise CompensatorError(f"{self.report['program']}: {self.report['verdict']}: do not run it")


@writes("json")
def verify_file(
    program: Path,
    cell: Path,
    *,
    toolpath: Sequence[Path] = (),
    language: str | None = None,
    read_as: str | None = None,
    json: Path | None = None,
    say: Say = quiet,
) -> Verification:
    """Verify a program that ``compensate`` wrote.

    Args:
        toolpath: what it was made from; empty: looked for by its hash, beside the program, the cell, and here.
        language: of the program, where its suffix does not tell it.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: a file cannot be read, or the path cannot be solved.
    """
    head = head_of(_bytes(program))
    sources = list(toolpath) or [_found(head.toolpath, program, cell)]
    files = program_files(sources, read_as)
    spoken = language_of(program, language, like=files)
    given = read_input(files, cell, say, written_in=spoken)
    say("solving")
    with tempfile.TemporaryDirectory(prefix="compensator-verify-") as folder:
        made = _written_anew(given, files, spoken, Path(folder) / program.name)
        standing = [program.parent / file.name for file in made.files]
        standing[0] = program
        parts = [_bytes(file) for file in standing]
        lines = [line for a, b in zip(made.files, standing, strict=True) for line in changed_lines(a, b)]
        say("reading the program")
        error, why = _error(made, standing, program, spoken)
        predicted, _ = _error(made, made.files, program, spoken)
    seal = None if head.seal is None else head.seal == digest_of(parts)
    if predicted is None:
        raise SolveError(f"{program}: the program that is written now is not the one that was solved")
    cut = made.result.cutting
    report = verification_report(
        str(program),
        Standing(head=head, now=given.provenance, sealed=seal, lines=tuple(lines)),
        error=None if error is None else error[cut],
        predicted=predicted[cut],
        why=why,
    )
    if json:
        with Outputs() as outputs:
            outputs.text(json, as_json(report))
            outputs.commit()
    return Verification(report, (json,) if json else ())


def _written_anew(given: RunInput, files: ProgramFiles, spoken: Language, target: Path) -> MadeProgram:
    """The program as it is written now, in a folder of its own."""
    stamp = given.provenance.stamp
    maker: ProgramMaker | None = filter_of(files, given.source, spoken, stamp)
    maker = maker or Export.of(given.job.placement, given.source, spoken, stamp)
    path = planned(given.job, given.path)
    return maker.write(compensate(given.job, path, rapids_stay=maker.in_place), target)


def _error(
    made: MadeProgram, standing: Sequence[Path], shown: Path, spoken: Language
) -> tuple[Floats | None, str]:
    """(N,) m of the program on the disk; None, and why, where its poses cannot be told."""
    try:
        if isinstance(made, FilteredProgram):
            return verify_filtered(replace(made, files=tuple(standing)), shown).error, ""
        return simulated(made.result, standing[0], spoken.name).error, ""
    except (SolveError, ToolpathError, ValueError) as e:
        return None, str(e)


def _bytes(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as e:
        why = e.strerror or str(e)
        raise CompensatorError(f"{file}: cannot be read: {why}; give the program with all of its files") from e


def _found(told: str | None, program: Path, cell: Path) -> Path:
    """The toolpath with the hash that the head of a program tells.

    Raises:
        CompensatorError: there is none; asks for it.
    """
    remedy = "give --toolpath FILE, what it was made from"
    if told is None:
        raise CompensatorError(f"{program}: its head does not tell what it was made from: {remedy}")
    for file in _near(program, cell):
        if sha256_of([file]) == told:
            return file
    raise CompensatorError(f"{program}: no toolpath with sha256 {told} beside it, the cell, or here: {remedy}")


def _near(program: Path, cell: Path) -> Iterator[Path]:
    """Files that some language reads, in the folders of program and cell and in the working folder."""
    for folder in dict.fromkeys(f.resolve() for f in (program.parent, cell.parent, Path())):
        yield from (f for f in sorted(folder.iterdir()) if reading(f) is not None and f.is_file())
