"""A process whose wrench the user knows, in axes of his choice."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.process.path_axes import path_axes
from compensator.process.plausible_wrench import wrench_doubts
from compensator.process.process import Process, ProcessContext, ProcessLoad, ToolMotion
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]


class GivenWrench(Process):
    """A wrench per pose, turned into base axes.

    Attributes:
        context: the cell around it.
    """

    context: ProcessContext

    @abstractmethod
    def given(self, motion: ToolMotion) -> Floats:
        """(N, 6) in ``axes``; what stands at rapids does not count."""

    def load(self, motion: ToolMotion) -> ProcessLoad:
        given = self.given(motion)
        if self.axes == "tool":
            self._refuse_lateral(motion, given)
        rotation = self._rotation(motion)
        force, moment = (np.einsum("...ij,...j->...i", rotation, part) for part in (given[:, :3], given[:, 3:]))
        wrench = np.concatenate([force, moment], axis=1)
        wrench[motion.toolpath.kind != CUT] = 0.0
        return ProcessLoad(wrench, tuple(wrench_doubts(motion, wrench, f"{self.context.source}: process")))

    def _rotation(self, motion: ToolMotion) -> Floats:
        """(3, 3) or (N, 3, 3): the axes in the base."""
        if self.axes == "base":
            return np.eye(3)
        if self.axes == "workobject":
            return motion.workobject.rotation
        tcp, work = motion.tcp, motion.workobject
        if self.axes == "tool":
            return tcp.rotation
        if work.origin.ndim == 1:
            return path_axes(tcp.origin, tcp.rotation, motion.toolpath.kind)
        seen = tcp.relative_to(work)  # the feed is that of the tool against the part
        return work.rotation @ path_axes(seen.origin, seen.rotation, motion.toolpath.kind)

    def _refuse_lateral(self, motion: ToolMotion, given: Floats) -> None:
        """Where the turn about the tool axis is free, the direction of a lateral wrench in tool axes is not known."""
        path = motion.toolpath
        if path.quaternion is None and np.any(given[path.kind == CUT][:, [0, 1, 3, 4]]):
            raise CellError(
                f"{self.context.source}: process.frame = 'tool' with a lateral force or moment needs a fixed "
                f"orientation: {path.source} leaves the turn about the tool axis open. Give orientations (qw, qx, qy, "
                "qz) in the toolpath, or use frame = 'path' or 'workobject'"
            )
