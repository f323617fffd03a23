"""ABB RAPID: the moves of main, worked out one after the other. docs/rapid.md lists what is read and what not."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.rapid.interpreter import RapidInterpreter
from toolpaths.languages.rapid.program import RapidProgram
from toolpaths.languages.rapid.scan import RapidModule
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath

_MAIN = re.compile(r"^[ \t]*(?:LOCAL[ \t]+)?PROC[ \t]+main[ \t]*\(", re.I | re.M)
_LISTED = re.compile(r"<Module>\s*([^<>\s]+)\s*</Module>", re.I)


def read(path: Path, source: str, chord: float, others: Sequence[Path] | None = None) -> Toolpath:
    """Poses of a program; arcs become points within ``chord`` (m).

    Args:
        path: of the main module.
        source: its name in messages.
        chord: of arcs.
        others: the other files of the program; None: modules in the folder, those that are needed.

    Raises:
        ReadError: not RAPID, or something known only while the program runs; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source, path, others).toolpath(chord)


def main_of(files: Sequence[Path]) -> Path:
    """The module with PROC main().

    Raises:
        ReadError: none of the files has it, or several have.
    """
    found = []
    for file in files:
        load_lines(file, str(file))
        if _MAIN.search(file.read_bytes().decode("latin-1")):
            found.append(file)
    if len(found) != 1:
        what = "several files have PROC main(): " + ", ".join(f.name for f in found) if found else "no PROC main()"
        problem = f"{what} in {len(files)} modules"
        raise ReadError(str(files[0].parent), None, problem, "Give the files of one program, one with main.")
    return found[0]


def listed(path: Path) -> list[Path]:
    """The modules that a .pgf lists; they lie beside it.

    Raises:
        ReadError: it lists none, or one that is not there.
    """
    load_lines(path, str(path))
    text = path.read_bytes().decode("latin-1")
    files = []
    for found in _LISTED.finditer(text):
        line = text.count("\n", 0, found.start()) + 1
        name = found[1].replace("\\", "/").rpartition("/")[2]
        try:
            file = path.with_name(name)
        except ValueError:
            raise ReadError(str(path), line, f"{found[1][:40]!r} is no name of a module") from None
        if not file.is_file():
            raise ReadError(str(path), line, f"{name[:80]} is not beside this list", "Put the modules into its folder.")
        files.append(file)
    if not files:
        raise ReadError(str(path), None, "no <Module> in the list", "Give the .pgf of a program, or its main module.")
    return files


def moves_of(data: bytes, source: str, path: Path | None = None, others: Sequence[Path] | None = None) -> RobotMoves:
    """The moves of a program, with the places where they stand in its text."""
    return run_of(data, source, path, others).track.moves()


def run_of(
    data: bytes, source: str, path: Path | None = None, others: Sequence[Path] | None = None
) -> RapidInterpreter:
    """The program, executed."""
    run = RapidInterpreter(RapidProgram(RapidModule(data.decode("latin-1"), source), others, path))
    run.main()
    return run
