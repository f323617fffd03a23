"""ABB RAPID: the moves of main, worked out one after the other. docs/rapid.md lists what is read and what not."""

from __future__ import annotations

from pathlib import Path

from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.rapid.interpreter import RapidInterpreter
from toolpaths.languages.rapid.scan import RapidModule
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a module; arcs become points within ``chord`` (m).

    Raises:
        ReadError: not RAPID, or something known only while the program runs; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source).toolpath(chord)


def moves_of(data: bytes, source: str) -> RobotMoves:
    """The moves of a module, with the places where they stand in ``data``."""
    return run_of(data, source).track.moves()


def run_of(data: bytes, source: str) -> RapidInterpreter:
    """The program, executed."""
    run = RapidInterpreter(RapidModule(data.decode("latin-1"), source))
    run.main()
    return run
