"""Controller languages: which there are, and writing a program so that it is there whole or not at all."""

from __future__ import annotations

import importlib
import os
import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol, cast

from toolpaths.errors import WriteError
from toolpaths.writing.checks import common_findings
from toolpaths.writing.program import ERROR, Finding, Program, ReadBack, ToolFrame, refuse_errors

__all__ = [
    "FORMATS", "SUFFIXES", "Finding", "Program", "ReadBack", "ToolFrame", "Written",
    "format_of", "read_back", "write_program",
]  # fmt: skip

#: Language -> module that writes it.
FORMATS: dict[str, str] = {
    "rapid": "toolpaths.languages.rapid.writer",
    "krl": "toolpaths.languages.krl.writer",
    "fanuc": "toolpaths.languages.fanuc.writer",
    "urscript": "toolpaths.languages.urscript.writer",
    "val3": "toolpaths.languages.val3.writer",
    "inform": "toolpaths.languages.inform.writer",
    "gcode": "toolpaths.languages.gcode.writer",
    "csv": "toolpaths.languages.csv.writer",
}

#: Suffix of the program's name -> language.
SUFFIXES = {
    ".mod": "rapid", ".src": "krl", ".ls": "fanuc", ".script": "urscript",
    ".pgx": "val3", ".jbi": "inform", ".nc": "gcode", ".csv": "csv",
}  # fmt: skip


class Writer(Protocol):
    """What the module of a controller language offers."""

    def findings(self, program: Program, path: Path) -> Iterable[Finding]:
        """What stands against writing this program to this name, or should be known about it."""

    def files(self, program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
        """The files beside each other that make up the program: name, text in pieces."""

    def read_back(self, path: Path) -> ReadBack:
        """What stands in the program that ``files`` wrote to ``path``."""


@dataclass(frozen=True)
class Written:
    """What write_program left on the disk.

    Attributes:
        files: in the order of writing; the first is the path asked for.
        findings: warnings about the program.
    """

    files: tuple[Path, ...]
    findings: tuple[Finding, ...]


def format_of(path: str | os.PathLike[str], format: str | None = None) -> str:
    """The language asked for, or what the suffix of ``path`` says. WriteError names what there is."""
    known = ", ".join(f"{s} {n}" for s, n in SUFFIXES.items())
    if format is None:
        suffix = Path(path).suffix.lower()
        if suffix not in SUFFIXES:
            raise WriteError(f"{path}: the suffix {suffix!r} is no language's ({known}). Give --format")
        format = SUFFIXES[suffix]
    if format not in FORMATS:
        raise WriteError(f"{path}: there is no format {format!r}; known: {', '.join(FORMATS)}")
    return format


def write_program(program: Program, path: str | os.PathLike[str], format: str | None = None) -> Written:
    """Writes ``program`` in a controller's language: whole, or not at all.

    Everything goes to temporary files beside the target, is flushed to the disk, and only then renamed.

    Raises:
        WriteError: no such language; a finding of level error (all are listed); a file that cannot be
            written. Nothing is left behind or changed then.
    """
    target = Path(path)
    writer = _writer(format_of(path, format))
    found = list(program.findings) + list(common_findings(program))
    if not any(f.level == ERROR for f in found):
        found += writer.findings(program, target)
    findings = refuse_errors(str(path), found)
    return Written(_write_all(target.parent, writer.files(program, target)), findings)


def read_back(path: str | os.PathLike[str], format: str | None = None) -> ReadBack:
    """What stands in a program that write_program wrote: to verify the file itself."""
    return _writer(format_of(path, format)).read_back(Path(path))


def _writer(format: str) -> Writer:
    return cast(Writer, importlib.import_module(FORMATS[format]))


def _write_all(folder: Path, files: Iterator[tuple[str, Iterator[str]]]) -> tuple[Path, ...]:
    """Writes (name, pieces) pairs into ``folder``, all or none."""
    done: list[tuple[Path, Path]] = []
    target = folder
    try:
        for name, pieces in files:
            target = folder / name
            temporary = folder / f".{name}.{os.getpid()}.tmp"
            _refuse_folder(target)
            done.append((temporary, target))
            with open(temporary, "wb") as stream:
                _write_pieces(stream, pieces)
        _rename_all(done)
    except OSError as e:
        raise WriteError(f"{target}: cannot be written: {e.strerror or e}. Nothing was changed") from e
    finally:
        for temporary, _ in done:
            temporary.unlink(missing_ok=True)
    return tuple(t for _, t in done)


def _refuse_folder(target: Path) -> None:
    if target.is_dir():
        raise IsADirectoryError(21, "a folder of this name is in the way")


def _write_pieces(stream: BinaryIO, pieces: Iterator[str]) -> None:
    for piece in pieces:
        stream.write(piece.encode("ascii"))
    stream.flush()
    os.fsync(stream.fileno())


def _rename_all(done: list[tuple[Path, Path]]) -> None:
    """Renames every (temporary, target); on a failure the targets are put back as they were."""
    backups = _set_aside(done) if len(done) > 1 else {}
    renamed: list[Path] = []
    try:
        for temporary, target in done:
            os.replace(temporary, target)
            renamed.append(target)
    except OSError:
        for target in renamed:
            if target in backups:
                os.replace(backups[target], target)
            else:
                target.unlink()
        raise
    finally:
        for backup in backups.values():
            backup.unlink(missing_ok=True)


def _set_aside(done: list[tuple[Path, Path]]) -> dict[Path, Path]:
    """Target -> second name (or copy, where the disk knows no links) of the file that stands there."""
    backups: dict[Path, Path] = {}
    for temporary, target in done:
        if target.exists():
            backup = backups[target] = temporary.with_suffix(".old")
            backup.unlink(missing_ok=True)
            try:
                os.link(target, backup)
            except OSError:
                shutil.copy2(target, backup)
    return backups
