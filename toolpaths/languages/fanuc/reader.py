"""Fanuc TP programs: the moves of a .ls. docs/fanuc.md lists what is read and what not."""

from __future__ import annotations

from pathlib import Path

from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.fanuc.interpreter import TpInterpreter
from toolpaths.languages.fanuc.scan import Listing
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath
from toolpaths.writing.marker import is_compensated_in_remarks


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a program; arcs become points within ``chord`` (m).

    Raises:
        ReadError: not a TP program, or something known only while it runs; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source, path).toolpath(chord)


def moves_of(data: bytes, source: str, path: Path) -> RobotMoves:
    """The moves of a program, with the places where they stand in the text (one character a byte).

    Args:
        path: where the file lies; programs that it calls are looked for beside it.
    """
    run = TpInterpreter(Listing(data.decode("latin-1"), source), path, checked=is_compensated_in_remarks(data))
    run.all()
    return run.track.moves()
