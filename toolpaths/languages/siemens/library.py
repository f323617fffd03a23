"""SiemensLibrary: the programs that a program can call: in its file, or in files beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.languages.siemens.program import PROGRAMS, SiemensProgram, SiemensUnit, split
from toolpaths.reading.source_text import load_lines

_SUFFIXES = (".spf", ".mpf")


class SiemensLibrary:
    """Programs by name.

    Args:
        program: of the file.
        path: of the file.
        entered: is told the lines of each file that is read.
    """

    def __init__(self, program: SiemensProgram, path: Path, entered: Callable[[list[str]], None]) -> None:
        self._program, self._path, self._entered = program, path, entered
        for unit in program.units:
            entered(unit.lines)
        self._files: dict[str, Path] | None = None
        self._read: dict[Path, SiemensUnit] = {}

    def find(self, name: str) -> SiemensUnit | None:
        """A program, in capitals; None: there is none.

        Raises:
            ReadError: the file beside cannot be read.
        """
        if unit := self._program.called(name):
            return unit
        if self._files is None:
            beside = sorted(p for p in self._path.parent.iterdir() if p.suffix.lower() in _SUFFIXES)
            self._files = {p.stem.upper(): p for p in beside if p.name != self._path.name}
        if (file := self._files.get(name)) is None:
            return None
        if file not in self._read:
            source = str(Path(self._program.source).with_name(file.name))
            units = [u for u in split(load_lines(file, source), source) if u.kind in PROGRAMS]
            if not units:
                raise ReadError(source, None, "there is no program in the file")
            self._read[file] = units[0]
            self._entered(units[0].lines)
        return self._read[file]
