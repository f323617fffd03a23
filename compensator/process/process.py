"""Process: what the cut does to the robot. The contract that every kind of process keeps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from compensator.path.added_poses import with_poses_before_corners
from compensator.path.lean import CutterShape
from compensator.process.path_axes import path_axes
from compensator.toml_table import Number, TomlTable
from toolpaths.columns import blocks
from toolpaths.finding import Finding
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
WrenchAxes = Literal["path", "tool", "workobject", "base"]
SMOOTH = np.cos(np.radians(15.0))  # wrenches whose directions differ by less belong to one curve


@dataclass(frozen=True, repr=False)
class ToolMotion:
    """What a process is asked about: N poses of a toolpath, and where the tool is at each.

    Attributes:
        toolpath: feeds, kinds, tool numbers and source lines.
        workobject: the work object in the base; (N) of it where rail or table move it.
        nominal: (N) TCP in the base, as the toolpath has it.
        deflected: (N) TCP in the base, where it really is; None: at ``nominal``.
    """

    toolpath: Toolpath
    workobject: Frame
    nominal: Frame
    deflected: Frame | None = None

    def __post_init__(self) -> None:
        if self.nominal.count != len(self.toolpath):
            raise ValueError(f"{self.nominal.count} frames for {len(self.toolpath)} poses")

    def __len__(self) -> int:
        return len(self.toolpath)

    def __repr__(self) -> str:
        return f"ToolMotion({self.toolpath!r}{', deflected' if self.deflected else ''})"

    @property
    def tcp(self) -> Frame:
        """(N) where the TCP is."""
        return self.nominal if self.deflected is None else self.deflected

    @cached_property
    def z(self) -> Floats:
        """(N, 3) that of the TCP; base."""
        return self.tcp.z


@dataclass(frozen=True, repr=False)
class ProcessLoad:
    """What a process does to the robot along a path, and what else it found out.

    Attributes:
        wrench: (N, 6) N and N*m on the robot, base axes, about the TCP; 0 at rapids.
        programmed: (N, 6) the same as the process has it, where effects of a model change it; None: they do not.
        wall: (N, 3) unit vector, base axes, from the axis of the cutter to the wall that it cuts on the move to a pose;
            zero where it cuts none or two. None: the process does not tell.
        findings: about poses of the path; one of level ``error`` refuses it.
        columns: name with unit, such as ``chip_mm`` -> (N,) of that unit, for tables of the poses.
    """

    wrench: Floats
    findings: tuple[Finding, ...] = ()
    columns: Mapping[str, Floats] = field(default_factory=dict)
    programmed: Floats | None = None
    wall: Floats | None = None

    def predicted(self, rows: Rows) -> ProcessLoad:
        """What is asked of it once the path is predicted: what is told of single poses at ``rows`` (K,) alone."""
        return self

    def solved(self) -> ProcessLoad:
        """What is asked of it once commands are solved for."""
        return self

    @property
    def unchanged(self) -> Floats:
        """(N, 6) the wrench as the process has it: what a program that is written tells."""
        return self.wrench if self.programmed is None else self.programmed

    def __repr__(self) -> str:
        return f"ProcessLoad({len(self.wrench)} poses, {len(self.findings)} findings, {', '.join(self.columns)})"


class Process(ABC):
    """A process that goes on along a whole toolpath.

    Attributes:
        axes: of the wrench as the user thinks of it; in ``path`` axes it turns with the feed.
        yields: whether the wrench follows the deflection of the tool, so that a preview has to solve both together.
        cuts_stock: whether there is a stock, with an engagement at every pose and something that remains.
        tells_walls: whether its loads have ``wall``.
        between_ends: whether ``wrench_between`` is that of the ends of a segment, whatever other poses the motion has.
    """

    axes: WrenchAxes
    yields: bool = False
    cuts_stock: bool = False
    tells_walls: bool = False
    between_ends: bool = False

    @abstractmethod
    def load(self, motion: ToolMotion) -> ProcessLoad:
        """The wrench at every pose of ``motion``, on the robot, base axes, about the TCP where it is.

        The same motion gives the same load; rapids carry none.

        Raises:
            CellError: the process does not fit the path; names file, line and value.
        """

    @abstractmethod
    def description(self) -> str:
        """One line for reports: kind, axes and numbers."""

    def preparation(self) -> str:
        """What the first ``load`` does that takes long and shows nothing, in words of progress; empty: nothing."""
        return ""

    def with_corner_poses(self, toolpath: Toolpath, position: Floats | None = None) -> Toolpath:
        """The path with poses at its corners, so that what changes there is not smeared over a move.

        Args:
            position: (N, 3) m on the part, where rail or table move it.
        """
        return with_poses_before_corners(toolpath, position) if self.axes == "path" else toolpath

    def path_axes(self, motion: ToolMotion) -> Floats:
        """(N, 3, 3) path axes in the base: of the feed that leaves a pose."""
        return path_axes(motion.nominal.origin, motion.nominal.rotation, motion.toolpath.kind)

    def wrench_between(
        self, motion: ToolMotion, known_path: Toolpath, known: ProcessLoad, rows: Rows | None = None
    ) -> Floats:
        """(N, 6) as ``load_between``, for looking at many places inside of segments.

        Args:
            rows: (K,) poses that are asked about: (K, 6) is given. None: all.
        """
        rows = np.arange(len(motion)) if rows is None else rows
        if self.axes != "path":
            return self.wrench_of(motion, rows)
        wrench, found = _between_the_ends(motion.toolpath, known_path, known.wrench, rows)
        return wrench if found.all() else np.where(found[:, None], wrench, self.wrench_of(motion, rows))

    def wrench_of(self, motion: ToolMotion, rows: Rows) -> Floats:
        """(K, 6) of ``load``, at rows (K,) of the motion alone."""
        return self.load(motion).wrench[rows]

    def load_between(self, motion: ToolMotion, known_path: Toolpath, known: ProcessLoad) -> ProcessLoad:
        """The load after poses were put into the segments of ``known_path``, whose load is ``known``.

        Path axes of a sampled curve turn at its poses; a pose put in between gets what lies between the wrenches of
        the ends, or the whole turn would fall on what is left of the segment. Sharp corners stay corners.
        """
        load = self.load(motion)
        if self.axes != "path":
            return load
        wrench = load.wrench.copy()
        for b in blocks(len(motion)):
            between, found = _between_the_ends(motion.toolpath, known_path, known.wrench, np.arange(b.start, b.stop))
            wrench[b][found] = between[found]
        return replace(load, wrench=wrench)


def _between_the_ends(
    toolpath: Toolpath, old: Toolpath, old_wrench: Floats, rows: Rows
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """(K, 6) between the wrenches of the ends of a segment, and (K,) poses for which that is the answer."""
    row = toolpath.row[rows]
    start = np.clip(np.searchsorted(old.row, row, side="right") - 1, 0, len(old) - 2)
    cut = (old.kind[start] == CUT) & (old.kind[start + 1] == CUT)
    share = (row - old.row[start]) / (old.row[start + 1] - old.row[start])
    a, b = old_wrench[start], old_wrench[start + 1]
    gentle = np.sum(a * b, axis=1) > SMOOTH * (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
    return a + share[:, None] * (b - a), cut & gentle & (share > 0) & (share < 1)


@dataclass(frozen=True)
class ProcessContext:
    """What the rest of the cell tells a process.

    Attributes:
        source: the cell file, for messages.
        folder: what paths in the cell are relative to.
        default_feed: m/s where a toolpath gives none.
        tool_lengths: m from the flange to the TCP, by the number of the tool; 0: of all of them.
    """

    source: str
    folder: Path
    default_feed: float = 1000.0 / 60e3
    tool_lengths: Mapping[int, float] = field(default_factory=dict)


class NamedCutterTable(TomlTable):
    """A cutter that a given wrench belongs to: its name, or whatever tells it from others; mm."""

    name: str | None = None
    shape: str | None = None
    diameter: Number | None = Field(default=None, gt=0, le=1000)
    flutes: int | None = Field(default=None, ge=1)
    length: Number | None = Field(default=None, gt=0)
    corner_radius: Number | None = Field(default=None, ge=0)


def cutter_name(cutter: TomlTable) -> str:
    """Its name, or what the keys that every kind of process has for a cutter tell of it: one cutter has one name."""
    told = cutter.model_dump(exclude_unset=True)
    listed = [f"{key} {told[key]}" for key in sorted(NamedCutterTable.model_fields) if told.get(key) is not None]
    return str(told.get("name") or ", ".join(listed))


class ProcessTable(TomlTable):
    """[process] of a cell file; every kind adds ``kind``, a literal of its name, and its own keys."""

    kind: str

    def names(self) -> tuple[str, str]:
        """Names of the material and the cutter, which effects of the process hold for; "" where they are not told."""
        cutter = getattr(self, "cutter", None)
        return getattr(self, "material", None) or "", "" if cutter is None else cutter_name(cutter)

    def shapes(self) -> dict[int | None, CutterShape]:
        """Shapes of the cutters by the number of their tool; None: of all tools."""
        cutters = {None: getattr(self, "cutter", None), **getattr(self, "cutters", {})}
        return {number: _shape(cutter) for number, cutter in cutters.items() if cutter is not None}

    def process(self, context: ProcessContext) -> Process:
        """The process that the table describes."""
        raise NotImplementedError


def _shape(cutter: TomlTable) -> CutterShape:
    shape, diameter = getattr(cutter, "shape", None), getattr(cutter, "diameter", None)
    return CutterShape(shape, None if diameter is None else diameter / 1e3)
