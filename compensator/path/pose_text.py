"""How messages name a pose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]


def place(toolpath: Toolpath, k: int) -> str:
    """How messages name a pose."""
    return f"{toolpath.source}:{toolpath.line[k]} (pose {k})"


def mm(position: Floats) -> str:
    """A position in mm as messages show it."""
    return "(" + ", ".join(f"{v * 1e3:.2f}" for v in position) + ")"
