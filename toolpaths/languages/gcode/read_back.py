"""Reads back G-code, to verify the file on the disk: with the reader of the language itself."""

from __future__ import annotations

from pathlib import Path

from toolpaths.errors import WriteError
from toolpaths.languages.gcode.reader import parse
from toolpaths.reading.source_text import load_lines
from toolpaths.rotation import rotation_of_axis
from toolpaths.writing.program import ReadBack, printed_poses


def read_back(path: Path) -> ReadBack:
    """Position, tool vector and feed of every move; the turn about the vector is any."""
    source = str(path)
    try:
        poses = parse(load_lines(path, source), source).toolpath(1e-5)
    except OSError as problem:
        raise WriteError(f"{path}: cannot be read back: {problem}") from None
    return ReadBack(printed_poses(poses.position, poses.axis, rotation_of_axis), feed=poses.feed, turn_known=False)
