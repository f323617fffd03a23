"""Universal Robots URScript: the moves of a .script. docs/urscript.md lists what is read and what not."""

from __future__ import annotations

from pathlib import Path

from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.urscript.interpreter import UrInterpreter
from toolpaths.languages.urscript.scan import tree
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a program; arcs become points within ``chord`` (m).

    Raises:
        ReadError: not URScript, or something known only while the program runs; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source).toolpath(chord)


def moves_of(data: bytes, source: str) -> RobotMoves:
    """The moves of a program, with the places where they stand in the text (one character a byte)."""
    text = data.decode("latin-1")
    run = UrInterpreter(text, source)
    run.file(tree(text, source))
    return run.track.moves()
