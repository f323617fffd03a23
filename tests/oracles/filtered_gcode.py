"""G-code, and what its filter makes of it with cuts that are moved by a smooth field."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.oracles.commanded import program_of
from toolpaths.languages.gcode.filter import rewrite
from toolpaths.languages.gcode.reader import parse
from toolpaths.rewriting.filter import Rewritten
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.program import Program


def read(data: bytes, chord: float = 1e-5) -> Toolpath:
    return parse(
        data.removeprefix(b"\xef\xbb\xbf").decode("latin-1").replace("\r\n", "\n").split("\n"), "a.nc"
    ).toolpath(chord)


def corrected(path: Toolpath, size: float = 1e-4) -> np.ndarray:
    """Positions of cutting moves moved by a smooth field of about ``size`` m."""
    p = path.position
    off = size * np.column_stack([np.sin(30 * p[:, 1]) + 0.4, np.cos(25 * p[:, 0]), np.sin(20 * p[:, 0]) - 0.5])
    return np.where((path.kind == CUT)[:, None], p + off, p)


def filtered(text: str | bytes, size: float = 1e-4) -> tuple[Rewritten, Program, Toolpath]:
    data = text.encode() if isinstance(text, str) else text
    path = read(data)
    program = program_of(path, corrected(path, size))
    return rewrite(data, program, path.row, Path("a.nc")), program, path


def cuts(path: Toolpath | Program) -> np.ndarray:
    return path.position[path.kind == CUT] * 1e3
