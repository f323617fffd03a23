"""The table of languages: one entry each. Everything else about a language is in its folder ``languages/NAME/``.

To add a language: its folder (with ``vocabulary.py``, where it is read), its entry here, its page ``docs/NAME.md``, its
sample tests/contracts/languages/NAME.py.
No language imports this module, nor another language.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

if TYPE_CHECKING:  # the command line reads the table to show its help: nothing heavy here
    from toolpaths.finding import Finding
    from toolpaths.interpreting.vocabulary import Vocabulary
    from toolpaths.machine import Machine
    from toolpaths.rewriting.filter import Filter, Rewritten
    from toolpaths.toolpath import Floats, Toolpath
    from toolpaths.writing.part_carrier import UnitWords
    from toolpaths.writing.program import Program, ReadBack
    from toolpaths.writing.stops import Stops


class Writer(Protocol):
    """What ``languages/NAME/writer.py`` offers."""

    def findings(self, program: Program, path: Path) -> Iterable[Finding]:
        """What stands against writing this program to this name, or should be known about it."""

    def name_findings(self, name: str, path: Path, moves: int) -> Iterable[Finding]:
        """Those of it that name, file and number of moves of a program give: they are known before it is made."""

    def files(self, program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
        """The files beside each other that make up the program: name, text in pieces."""


@dataclass(frozen=True, kw_only=True)
class Language:
    """A language of CAM files or of robot programs; its modules are imported when they are first asked for.

    Attributes:
        name: the language's, and that of its folder.
        reads: suffixes of the files that ``reader.py`` reads; none: it is only written.
        writes: suffix of the programs that ``writer.py`` writes; empty: it is only read.
        filtered: whether ``filter.py`` changes a finished program in place.
        on_a_machine: whether reader and filter take the machine that a file was posted for.
        several: whether a program may be several files: reader and filter take the others, ``reader.py`` has main_of.
        parts: suffixes of files that may belong to a program of several, but are none of their own.
        short_remarks: a remark is too short for the marker of what this project wrote: it takes two of them.
        stops: whether ``stops.py`` writes programs that drive to postures and wait there.
        table: rows of numbers: a pose is a row, and no robot runs them.
        external_axes: whether its programs have places of rails and tables beside a pose.
        part_unit: how its programs tell what turns the part while they run.
        machine_words: what a command of G-code matches that its programs have a word for.
    """

    name: str
    reads: tuple[str, ...] = ()
    writes: str = ""
    filtered: bool = False
    on_a_machine: bool = False
    several: bool = False
    parts: tuple[str, ...] = ()
    short_remarks: bool = False
    table: bool = False
    stops: bool = False
    external_axes: bool = False
    part_unit: UnitWords = ""
    machine_words: str = "M0|M6"  # robots: a halt, and the data of a tool

    def read(
        self, path: Path, source: str, chord: float, machine: Machine | None, others: Sequence[Path] | None = None
    ) -> Toolpath:
        """The poses of a file; ``source`` is its name in messages, arcs become chords within ``chord`` (m).

        Args:
            path: the file; of several, the main one.
            source: its name in messages.
            chord: how far chords may stray from arcs, m.
            machine: see ``on_a_machine``.
            others: the other files of the program, where it may be ``several``; None: what lies beside.

        Raises:
            ReadError: the file is refused, by line.
        """
        return cast("Toolpath", self._module("reader").read(path, source, chord, *self._more(machine, others)))

    def main_of(self, files: Sequence[Path]) -> Path:
        """The file that runs first, of those of one program, where it may be ``several``.

        Raises:
            ReadError: there is none, or more than one.
        """
        return cast(Path, self._module("reader").main_of(files))

    def listed(self, path: Path) -> list[Path]:
        """The files of a program that a list of the language names.

        Raises:
            ReadError: it is none, or names a file that is not there.
        """
        return cast("list[Path]", self._module("reader").listed(path))

    def _more(self, machine: Machine | None, others: Sequence[Path] | None) -> tuple[Any, ...]:
        return (machine,) * self.on_a_machine + (others,) * self.several

    @property
    def vocabulary(self) -> Mapping[str, Vocabulary]:
        """Its words that are read or refused by name, by what they are: for its page."""
        return cast("Mapping[str, Vocabulary]", self._module("vocabulary").VOCABULARY)

    @property
    def writer(self) -> Writer:
        """How a program is written."""
        return cast(Writer, self._module("writer"))

    @property
    def read_back(self) -> Callable[[Path], ReadBack]:
        """What stands in a program that ``writer`` wrote."""
        return cast("Callable[[Path], ReadBack]", self._module("read_back").read_back)

    @property
    def filter(self) -> Filter:
        """How a finished program is changed in place, where the language is ``filtered``."""
        return cast("Filter", self._module("filter").FILTER)

    def stops_text(self, stops: Stops, name: str) -> str:
        """A program that drives to postures and waits there, where the language has ``stops``."""
        return cast(str, self._module("stops").stops_text(stops, name))

    def rewrite(
        self, source: bytes, program: Program, row: Floats, path: Path, machine: Machine | None,
        others: Sequence[Path] | None = None,
    ) -> Rewritten:  # fmt: skip
        """A finished program with the poses of ``program``: see ``Filter``."""
        return self.filter.rewrite(source, program, row, path, *self._more(machine, others))

    def _module(self, name: str) -> Any:
        return import_module(f"toolpaths.languages.{self.name}.{name}")


_ROBOTS = (
    Language(name="rapid", reads=(".mod", ".modx", ".prg", ".pgf"), writes=".mod", filtered=True, stops=True,
             several=True, parts=(".sys", ".sysx"), external_axes=True, part_unit="name"),
    Language(name="krl", reads=(".src",), writes=".src", filtered=True, stops=True, several=True,
             parts=(".dat",), external_axes=True, part_unit="number"),
    Language(name="fanuc", reads=(".ls",), writes=".ls", filtered=True, stops=True, short_remarks=True,
             external_axes=True),
    Language(name="urscript", reads=(".script", ".urscript"), writes=".script", filtered=True, stops=True),
    Language(name="val3", reads=(".pgx",), writes=".pgx"),
    Language(name="inform", reads=(".jbi",), writes=".jbi"),
)  # fmt: skip
_GCODE = (
    ".nc", ".ngc", ".gcode", ".tap", ".cnc", ".g", ".gc", ".ncc", ".iso", ".eia", ".min", ".ptp"
)  # fmt: skip
_CAM = (
    Language(
        name="gcode", reads=_GCODE, writes=".nc", filtered=True, on_a_machine=True, machine_words=r"M\d+|G4"
    ),
    Language(name="siemens", reads=(".mpf", ".spf", ".arc"), on_a_machine=True),
    Language(name="heidenhain", reads=(".h",), on_a_machine=True),
    Language(name="apt", reads=(".apt", ".aptsource", ".cl", ".cls", ".clsf", ".cldata", ".ncl")),
    Language(name="csv", reads=(".csv",), writes=".csv", table=True, machine_words=".*", external_axes=True,
             part_unit="none"),
)

#: By name.
LANGUAGES: dict[str, Language] = {language.name: language for language in (*_ROBOTS, *_CAM)}
#: Those that are read, CAM files first, and those that are written, robot programs first: as messages list them.
READ = tuple(language for language in (*_CAM, *_ROBOTS) if language.reads)
WRITTEN = tuple(language for language in (*_ROBOTS, *_CAM) if language.writes)


def reading(path: Path, name: str | None = None) -> Language | None:
    """The language that reads files of this suffix, or of this name."""
    if name is not None:
        return next((language for language in READ if language.name == name), None)
    return next((language for language in READ if path.suffix.lower() in language.reads), None)


def writing(path: Path) -> Language | None:
    """The language that programs of this suffix are written in."""
    return next((language for language in WRITTEN if language.writes == path.suffix.lower()), None)
