"""A toolpath as the arm follows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class PlannedPath:
    """A toolpath as the arm follows it, nominal.

    Attributes:
        toolpath: the poses, sampled.
        tcp: (N) TCP in the base.
        q: (N, n) rad, nominal inverse kinematics.
        turn: (N,) rad about the tool axis, from the reference orientation.
        branch: (N,) arm configuration; the same for all poses of a tool.
    """

    toolpath: Toolpath
    tcp: Frame
    q: Floats
    turn: Floats
    branch: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"PlannedPath({len(self)} poses, branch {np.unique(self.branch).tolist()})"
