"""A process whose wrench the user knows, in axes of his choice."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.process.path_axes import axes_along
from compensator.process.plausible_wrench import wrench_doubts
from compensator.process.process import Process, ProcessContext, ProcessLoad, ToolMotion
from toolpaths.columns import blocks
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


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
        wrench = self.wrench_of(motion, np.arange(len(motion)))
        return ProcessLoad(wrench, tuple(wrench_doubts(motion, wrench, f"{self.context.source}: process")))

    def wrench_of(self, motion: ToolMotion, rows: Rows) -> Floats:
        given = self.given(motion)
        if self.axes == "tool":
            self._refuse_lateral(motion, given)
        axes, wrench = self._axes(motion), np.empty((len(rows), 6))
        for b in blocks(len(rows)):
            rotation = axes(rows[b])
            for part in (slice(0, 3), slice(3, 6)):
                wrench[b, part] = np.einsum("...ij,...j->...i", rotation, given[rows[b], part])
        wrench[motion.toolpath.kind[rows] != CUT] = 0.0
        return wrench

    def _axes(self, motion: ToolMotion) -> Callable[[Rows], Floats]:
        """Rows (K,) -> (3, 3) or (K, 3, 3): the axes in the base."""
        tcp, work = motion.tcp, motion.workobject
        turned = work.rotation
        if self.axes == "base":
            return lambda rows: np.eye(3)
        if self.axes == "workobject":
            return lambda rows: turned if turned.ndim == 2 else turned[rows]
        if self.axes == "tool":
            return lambda rows: tcp.take(rows).rotation
        if work.origin.ndim == 1:
            return axes_along(tcp, motion.toolpath.kind, motion.z)
        seen = axes_along(tcp.relative_to(work), motion.toolpath.kind)  # the feed of the tool against the part
        return lambda rows: turned[rows] @ seen(rows)

    def _refuse_lateral(self, motion: ToolMotion, given: Floats) -> None:
        """Where the turn about the tool axis is free, the direction of a lateral wrench in tool axes is not known."""
        path = motion.toolpath
        if path.quaternion is None and np.any(given[path.kind == CUT][:, [0, 1, 3, 4]]):
            raise CellError(
                f"{self.context.source}: process.frame = 'tool' with a lateral force or moment needs a fixed "
                f"orientation: {path.source} leaves the turn about the tool axis open. Give orientations (qw, qx, qy, "
                "qz) in the toolpath, or use frame = 'path' or 'workobject'"
            )
