"""How messages name a pose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]


def place(toolpath: Toolpath, k: int, first: int = 0) -> str:
    """How messages name a pose; ``first``: where a toolpath that is part of another one begins in it."""
    return f"{toolpath.where(k)} (pose {first + k})"


def mm(position: Floats) -> str:
    """A position in mm as messages show it."""
    return "(" + ", ".join(f"{v * 1e3:.2f}" for v in position) + ")"
