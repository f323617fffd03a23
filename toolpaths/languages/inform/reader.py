"""Yaskawa INFORM: the moves of a job (.jbi) and of those beside it that it calls. docs/inform.md lists what is read."""

from __future__ import annotations

from pathlib import Path

from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.inform.interpreter import JobInterpreter
from toolpaths.languages.inform.scan import InformJob
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Toolpath


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a job; arcs become points within ``chord`` (m).

    Raises:
        ReadError: not a job, or something known only to the controller; names the line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source, path).toolpath(chord)


def moves_of(data: bytes, source: str, path: Path) -> RobotMoves:
    """The moves of a job (one character a byte).

    Args:
        path: where the file lies; jobs that it calls are looked for beside it.
    """
    run = JobInterpreter(InformJob(data.decode("latin-1"), source), path)
    run.run()
    return run.track.moves()
