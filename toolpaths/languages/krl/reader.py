"""KUKA KRL: the moves of a .src, with the .dat beside it. docs/krl.md lists what is read and what not."""

from __future__ import annotations

from pathlib import Path

from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.krl.interpreter import KrlInterpreter
from toolpaths.languages.krl.scan import KrlProgram
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a program; arcs become points within ``chord`` (m).

    Raises:
        ReadError: not KRL, or something known only while the program runs; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source, path).toolpath(chord)


def moves_of(data: bytes, source: str, path: Path) -> RobotMoves:
    """The moves of a program, with the places where they stand in the text."""
    return run_of(data, source, path).track.moves()


def run_of(data: bytes, source: str, path: Path) -> KrlInterpreter:
    """The program, executed; its .dat and the files that it calls are looked for beside ``path``."""
    beside = next((p for p in (path.with_suffix(".dat"), path.with_suffix(".DAT")) if p.is_file()), None)
    values = ""
    if beside is not None:
        load_lines(beside, str(beside))
        values = beside.read_bytes().decode("latin-1")
    program = KrlProgram(data.decode("latin-1"), source, values, "" if beside is None else str(beside))
    run = KrlInterpreter(program, path)
    run.main()
    return run
