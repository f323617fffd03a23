"""A text as a file that is read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolpaths.files import read_toolpath
from toolpaths.toolpath import Toolpath


def read_text(name: str, folder: Path, text: str | bytes, chord: float = 1e-5) -> Toolpath:
    """The toolpath of a file ``name`` of this content."""
    (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_toolpath(folder / name, chord=chord)


def ends(path: Toolpath) -> np.ndarray:
    """(N, 3) mm of the poses that stand in the file: those of arcs that are not their ends are left out."""
    return path.position[path.row == np.round(path.row)] * 1e3
