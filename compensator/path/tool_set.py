"""Tools of a placement by the number that a toolpath calls, and the flange that carries each of its poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.statics.tool import Tool
from toolpaths.frame import Frame
from toolpaths.toolpath import Ints, Toolpath

ONE_TOOL = 0  # number of a tool that holds for every number


@dataclass(frozen=True, repr=False)
class ToolSet:
    """One tool for all poses, or several by number.

    Attributes:
        by_number: number in the toolpath -> tool.
        any_number: the one tool holds whatever number the toolpath calls; its own is ONE_TOOL.
    """

    by_number: Mapping[int, Tool]
    any_number: bool = False

    def __repr__(self) -> str:
        return f"ToolSet({', '.join(t.name for t in self.by_number.values())})"

    @classmethod
    def of_one(cls, tool: Tool) -> ToolSet:
        """A tool that holds for every number."""
        return cls({ONE_TOOL: tool}, any_number=True)

    @property
    def first(self) -> Tool:
        """The first, or only, tool."""
        return next(iter(self.by_number.values()))

    def tool(self, number: int) -> Tool:
        """The tool that ``number`` calls; the first where there is none of this number."""
        return self.by_number.get(number) or self.first

    def rows(self, toolpath: Toolpath) -> Sequence[tuple[int, npt.NDArray[np.intp] | slice]]:
        """Number of every tool that the toolpath uses, and its poses."""
        return self.rows_of(toolpath.tool)

    def rows_of(self, called: Ints) -> Sequence[tuple[int, npt.NDArray[np.intp] | slice]]:
        """Number of every tool that poses call by these numbers (N,), and those poses."""
        if len(self.by_number) == 1:
            return [(next(iter(self.by_number)), slice(None))]
        rows = [(number, np.flatnonzero(called == number)) for number in self.by_number]
        return [(number, r) for number, r in rows if len(r)]

    def changes(self, toolpath: Toolpath) -> list[int]:
        """Poses that another tool goes to than to the pose before."""
        return [] if self.any_number else [int(k) for k in np.flatnonzero(np.diff(toolpath.tool)) + 1]

    def flange(self, toolpath: Toolpath, tcp: Frame) -> Frame:
        """(N) flange in the base under the TCP poses (N) of a toolpath."""
        return tcp.mapped(lambda some, rows: self._flange(toolpath.tool[rows], some))

    def _flange(self, called: Ints, tcp: Frame) -> Frame:
        rotation, origin = np.empty_like(tcp.rotation), np.empty_like(tcp.origin)
        for number, rows in self.rows_of(called):
            tool = self.by_number[number]
            rotation[rows] = tcp.rotation[rows] @ tool.rotation.T
            origin[rows] = tcp.origin[rows] - np.einsum("nij,j->ni", rotation[rows], tool.position)
        return Frame(rotation, origin)
