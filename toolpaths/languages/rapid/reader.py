"""ABB RAPID: the moves of main, worked out one after the other. docs/rapid.md lists what is read and what not."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolpaths.interpreting.moves import RobotMoves
from toolpaths.languages.rapid.interpreter import Run
from toolpaths.reading.source_text import load_lines
from toolpaths.toolpath import Floats, Toolpath


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a module; arcs become points within ``chord`` (m).

    Raises:
        ReadError: what is no RAPID, or is known only while the program runs, by line.
    """
    load_lines(path, source)
    return moves_of(path.read_bytes(), source).toolpath(chord)


def moves_of(data: bytes, source: str) -> RobotMoves:
    """The moves of a module, with the places where they stand in ``data``."""
    return run_of(data, source).track.moves()


def run_of(data: bytes, source: str) -> Run:
    """The program, executed."""
    run = Run(data.decode("latin-1"), source)
    run.main()
    return run


def quaternions(numbers: Floats) -> Floats:
    """Quaternions (N, 4) as printed, of unit length."""
    return np.asarray(numbers / np.linalg.norm(numbers, axis=1, keepdims=True))
