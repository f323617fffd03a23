"""Compensation: a path with its commands, and what the model predicts for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.path.planned_path import PlannedPath
from compensator.process.process import ProcessLoad
from stiffness.memory.preload import PreloadState
from stiffness.statics.prediction import Command
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class ShareSizes:
    """Shares of the deflection of the cutting poses (K) of a path without a correction.

    Attributes:
        size: cause -> (K,) m of its share. mean: cause -> (3,) m, its mean, base axes.
        largest: m, the largest deflection.
    """

    size: Mapping[str, Floats]
    mean: Mapping[str, Floats]
    largest: float

    def __repr__(self) -> str:
        return f"ShareSizes({', '.join(self.size)})"


@dataclass(frozen=True, repr=False)
class Compensation:
    """A path with its commands.

    Attributes:
        job, path: what was asked.
        load: of the process.
        target: (N) where the TCP has to be, base. Differs from the nominal path only where a correction fades along
            a rapid.
        command: the solve.
        state: of every pose.
        before: (N, 3) m, base: where the TCP stands when the nominal poses are commanded.
        iterations: rounds until state and correction agreed.
        inserted: poses that flank changes needed.
        plain: the path without poses put in and without a correction, as ``preview`` has it, but for the torques of its
            command, which are not kept: NaN; None: this is it.
        uncoupled: the prediction with the wrench of the nominal path, where here it follows the deflection; else None.
        shares: of the deflection, where they were worked out beside the solve; None: not yet.
    """

    job: Job
    path: PlannedPath
    load: ProcessLoad
    target: Frame
    command: Command
    state: PreloadState
    before: Floats
    iterations: int
    inserted: int
    plain: Compensation | None = None
    uncoupled: Compensation | None = None
    shares: ShareSizes | None = None

    def __len__(self) -> int:
        return len(self.path)

    def __repr__(self) -> str:
        return f"Compensation({self.path.toolpath.source!r}, {len(self)} poses, {self.iterations} rounds)"

    @property
    def is_corrected(self) -> bool:
        """False for what ``preview`` shows: no round of the solve was run."""
        return self.iterations > 0

    @property
    def uncompensated(self) -> Compensation:
        """The path as it was given, uncompensated: its figures are the same whatever is done about them."""
        return self.plain or self

    @property
    def wrench(self) -> Floats:
        """(N, 6) of the process on the robot, base axes, about the TCP."""
        return self.load.wrench

    @property
    def cutting(self) -> npt.NDArray[np.bool_]:
        """(N,) which poses cut."""
        return np.asarray(self.path.toolpath.kind == CUT)

    @property
    def printed(self) -> Frame:
        """(N) nominal TCP of the commands, base: what a program prints."""
        poses = self.command.printed
        return poses if isinstance(poses, Frame) else Frame(poses.rotation, poses.origin)

    @property
    def correction(self) -> Floats:
        """(N, 3) m, base axes: command minus nominal."""
        return self.printed.origin - self.path.tcp.origin

    @property
    def error_before(self) -> Floats:
        """(N, 3) m, base axes: TCP error when the nominal poses are commanded."""
        return self.before - self.path.tcp.origin
