"""Files of toolpaths and robot programs: read, write, read back. The language follows from the suffix, or is named."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from toolpaths.errors import ReadError, WriteError
from toolpaths.finding import ERROR, Finding, refuse_errors
from toolpaths.languages.table import LANGUAGES, READ, WRITTEN, Language, reading, writing
from toolpaths.machine import Machine
from toolpaths.program_files import ProgramFiles, program_files
from toolpaths.reading.source_text import refuse_absent
from toolpaths.sharing import each, is_shared
from toolpaths.toolpath import Toolpath
from toolpaths.writing.checks import common_findings, unsaid, without_axes
from toolpaths.writing.marker import refuse_compensated, refuse_compensated_remarks
from toolpaths.writing.part_carrier import carrier_findings
from toolpaths.writing.program import Program, ReadBack
from toolpaths.writing.staging import Staging, StagingError


def read_toolpath(
    path: str | os.PathLike[str],
    *,
    chord: float = 1e-5,
    machine: Machine | None = None,
    shown: str | None = None,
    language: str | None = None,
    others: Sequence[str | os.PathLike[str]] | None = None,
) -> Toolpath:
    """Read a toolpath file; its suffix names the language.

    Args:
        path: file to read; of several, any of them; or the folder of a robot program.
        chord: largest distance between an arc of the file and the chords that replace it, m.
        machine: the machine that the file was posted for, where its language asks for one.
        shown: name of the file in messages; else ``path``.
        language: of the file, where its suffix does not tell it.
        others: the other files of a robot program; None: what it needs is looked for beside it.

    Raises:
        ReadError: the file is refused; the message names the line, what stands there and what to do.
        ValueError: ``chord`` is not a positive length.
    """
    return read_program(program_files([path, *(others or ())], language), chord=chord, machine=machine, shown=shown)


def read_program(
    files: ProgramFiles, *, chord: float = 1e-5, machine: Machine | None = None, shown: str | None = None
) -> Toolpath:
    """Read the files of a program, as ``read_toolpath``."""
    if not 0.0 < chord < 1.0:
        raise ValueError(f"chord = {chord} m: a length above 0 and below 1 m is needed")
    source = str(files.main)
    shown = source if shown is None else shown
    refuse_absent(files.main, shown)
    if files.language is None:
        known = "; ".join(f"{known.name}: {' '.join(known.reads)}" for known in READ)
        suffix = repr(files.main.suffix) if files.main.suffix else "a file without suffix"
        remedy = f"Known: {known}. Where the suffix does not tell: --from LANGUAGE"
        raise ReadError(shown, None, f"no reader for {suffix}", remedy)
    return files.language.read(files.main, shown, chord, machine=machine, others=files.others)


def refuse_own(path: Path, name: str | None = None) -> None:
    """Refuse a file that this project wrote: compensated twice is wrong.

    Raises:
        ReadError: names the line of the marker.
    """
    try:
        data = path.read_bytes()
    except OSError:
        return  # the reader tells what is wrong with it
    refuse_compensated(data, str(path))
    language = reading(path, name)
    if language is not None and language.short_remarks:
        refuse_compensated_remarks(data, str(path))


@dataclass(frozen=True)
class Written:
    """What write_program left on the disk.

    Attributes:
        files: in the order of writing; the first is the path asked for.
        findings: warnings about the program.
    """

    files: tuple[Path, ...]
    findings: tuple[Finding, ...]


def language_of(path: str | os.PathLike[str], name: str | None = None, *, like: ProgramFiles | None = None) -> Language:
    """The language that a program is written in: the one asked for, or that of the suffix.

    Args:
        path: of the program.
        name: of the language; None: by suffix.
        like: what the program is made from: with the same suffix it has the same language, so that part.ngc becomes
            part_c.ngc.

    Raises:
        WriteError: there is none; the message lists what there is.
    """
    if name is None and like is not None and Path(path).suffix.lower() == like.main.suffix.lower():
        name = None if like.language is None else like.language.name
    if name is None:
        found = writing(Path(path))
        if found is None:
            known = ", ".join(f"{known.writes} {known.name}" for known in WRITTEN)
            suffix = Path(path).suffix.lower()
            raise WriteError(f"{path}: the suffix {suffix!r} is no language's ({known}). Give --format")
        return found
    if name not in LANGUAGES or not LANGUAGES[name].writes:
        names = ", ".join(known.name for known in WRITTEN)
        raise WriteError(f"{path}: there is no format {name!r}; known: {names}")
    return LANGUAGES[name]


def write_program(
    program: Program, path: str | os.PathLike[str], language: str | None = None, *, staged: bool = False
) -> Written:
    """Writes ``program`` in a controller's language: whole, or not at all.

    Everything goes to a hidden folder beside the target, is flushed to the disk, and only then renamed.

    Args:
        staged: ``path`` will be renamed once more, by one who flushes then.

    Raises:
        WriteError: no such language; a finding of level error (all are listed); a file that cannot be
            written. Nothing is left behind or changed then.
    """
    target = Path(path)
    spoken = language_of(path, language)
    writer = spoken.writer
    found = list(program.findings) + list(common_findings(program))
    if not spoken.external_axes:
        found += without_axes([a.name for a in program.external], spoken.name)
    elif program.carrier is not None:
        found += carrier_findings(program.carrier, spoken.part_unit, spoken.name)
    if not any(f.level == ERROR for f in found):
        found += writer.findings(program, target)
        found += unsaid(program, spoken.name, lambda word: re.fullmatch(spoken.machine_words, word) is not None)
    findings = refuse_errors(str(path), found)
    written: list[Path] = []
    try:
        with Staging(flush=not staged) as staging:
            made = ((target.parent / name, pieces) for name, pieces in writer.files(program, target))
            # what makes several files at a time holds them all
            for some in [list(made)] if is_shared() else ([one] for one in made):
                staging.take_up([file for file, _ in some])
                each(lambda f: staging.fill(f[0], (text.encode("ascii") for text in f[1])), some, poses=len(program))
                written += [file for file, _ in some]
            staging.commit()
    except StagingError as e:
        raise WriteError(f"{e.target}: cannot be written: {e.why}. Nothing was changed") from e
    return Written(tuple(written), findings)


def read_back(path: str | os.PathLike[str], language: str | None = None) -> ReadBack:
    """What stands in a program that write_program wrote: to verify the file itself."""
    return language_of(path, language).read_back(Path(path))
