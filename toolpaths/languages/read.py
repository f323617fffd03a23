"""Readers of toolpath files: one module per language, found by the suffix of the file.

A reader is a module with ``read(path, source, chord) -> Toolpath``. To add a language: one module, its
suffixes here, one section in docs/toolpaths-in.md, one sample in tests/contracts/test_readers.py.
"""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from toolpaths.errors import ReadError
from toolpaths.toolpath import Toolpath

if TYPE_CHECKING:
    from toolpaths.machine import Machine

SUFFIXES: dict[str, tuple[str, ...]] = {
    "gcode": (".nc", ".ngc", ".gcode", ".tap", ".cnc", ".g"),
    "apt": (".apt", ".cl", ".cls", ".clsf", ".cldata"),
    "csv": (".csv",),
    "rapid": (".mod", ".prg"),
    "krl": (".src",),
    "fanuc": (".ls",),
    "urscript": (".script",),
}
ON_A_MACHINE = ("gcode",)  # readers with a fourth argument: the machine that the file was posted for
READERS: dict[str, str] = {suffix: name for name, group in SUFFIXES.items() for suffix in group}


class Reader(Protocol):
    """What a reader module offers."""

    def read(self, path: Path, source: str, chord: float) -> Toolpath:
        """The poses of the file; arcs become points whose chords stay within ``chord`` (m) of the arc."""
        ...


class MachineReader(Reader, Protocol):
    """What a reader of ON_A_MACHINE offers."""

    def read(self, path: Path, source: str, chord: float, machine: Machine | None = None) -> Toolpath:
        """As Reader; ``machine`` is what files with rotary words or several coordinate systems need."""
        ...


def read_toolpath(
    path: str | os.PathLike[str], *, chord: float = 1e-5, machine: Machine | None = None
) -> Toolpath:
    """Read a toolpath file; its suffix names the language.

    Args:
        path: file to read.
        chord: largest distance between an arc of the file and the chords that replace it, m.
        machine: the machine that the file was posted for; other languages than ON_A_MACHINE do not need it.

    Raises:
        ReadError: the file is refused; the message names the line, what stands there and what to do.
        ValueError: ``chord`` is not a positive length.
    """
    if not 0.0 < chord < 1.0:
        raise ValueError(f"chord = {chord} m: a length above 0 and below 1 m is needed")
    reader = reader_of(path)
    if READERS[Path(path).suffix.lower()] in ON_A_MACHINE:
        return cast(MachineReader, reader).read(Path(path), os.fspath(path), chord, machine)
    return reader.read(Path(path), os.fspath(path), chord)


def reader_of(path: str | os.PathLike[str]) -> Reader:
    """The reader for the suffix of a file.

    Raises:
        ReadError: there is none.
    """
    source = os.fspath(path)
    name = READERS.get(Path(source).suffix.lower())
    if name is None:
        known = "; ".join(f"{n}: {' '.join(s)}" for n, s in SUFFIXES.items())
        suffix = repr(Path(source).suffix) if Path(source).suffix else "a file without suffix"
        raise ReadError(source, None, f"no reader for {suffix}", f"Known: {known}")
    return cast(Reader, import_module(f"toolpaths.languages.{name}.reader"))
