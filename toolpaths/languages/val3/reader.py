"""Staubli VAL3: the moves of a program (.pgx), with data and programs beside it. docs/val3.md lists what is read."""

from __future__ import annotations

from pathlib import Path

from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.val3.interpreter import ValInterpreter
from toolpaths.languages.val3.scan import ValProgram, data_beside
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a program; arcs become points within ``chord`` (m).

    Raises:
        ReadError: not a program of VAL3 7, or something known only to the controller; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source, path).toolpath(chord)


def moves_of(data: bytes, source: str, path: Path) -> RobotMoves:
    """The moves of a program (one character a byte).

    Args:
        path: where the file lies; data and programs that it calls are looked for beside it.
    """
    program = ValProgram(data.decode("latin-1"), source)
    run = ValInterpreter(program, dict(data_beside(path)), path)
    run.run()
    return run.track.moves()
