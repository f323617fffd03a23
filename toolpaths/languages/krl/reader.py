"""KUKA KRL: the moves of a .src, with the .dat beside it. docs/krl.md lists what is read and what not."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.krl.interpreter import KrlInterpreter
from toolpaths.languages.krl.program import KrlProgram, module_of
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath

_CALLED = re.compile(r"^[ \t]*([A-Za-z_$][\w$]*)[ \t]*\([ \t]*\)[ \t]*(?:;|\r|$)", re.M)


def read(path: Path, source: str, chord: float, others: Sequence[Path] | None = None) -> Toolpath:
    """Poses of a program; arcs become points within ``chord`` (m).

    Args:
        path: of the main .src.
        source: its name in messages.
        chord: of arcs.
        others: the other files of the program; None: what it calls is looked for beside it.

    Raises:
        ReadError: not KRL, or something known only while the program runs; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source, path, others).toolpath(chord)


def main_of(files: Sequence[Path]) -> Path:
    """The .src that no other one calls.

    Raises:
        ReadError: there are several of them, or each is called by another.
    """
    calls: dict[Path, set[str]] = {}
    for file in files:
        load_lines(file, str(file))
        calls[file] = {name.upper() for name in _CALLED.findall(file.read_bytes().decode("latin-1"))}
    free = [f for f in files if not any(f.stem.upper() in called for other, called in calls.items() if other != f)]
    if len(free) != 1:
        shown = ", ".join(f.name for f in free)
        problem = f"no file calls these: {shown}" if free else "each of the files is called by another one"
        raise ReadError(str(files[0].parent), None, problem, "Name the main file of the program, or the files of one.")
    return free[0]


def moves_of(data: bytes, source: str, path: Path, others: Sequence[Path] | None = None) -> RobotMoves:
    """The moves of a program, with the places where they stand in its text."""
    return run_of(data, source, path, others).track.moves()


def run_of(data: bytes, source: str, path: Path, others: Sequence[Path] | None = None) -> KrlInterpreter:
    """The program, executed."""
    run = KrlInterpreter(KrlProgram(module_of(data, source, path), path, others))
    run.main()
    return run
