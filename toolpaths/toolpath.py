"""Toolpath: where a CAM file wants the tool centre point, pose by pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:  # programs import this module
    from toolpaths.writing.program import ToolFrame

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]

RAPID = np.uint8(0)
CUT = np.uint8(1)


@dataclass(frozen=True)
class Event:
    """Something a CAM file says between two moves (spindle, coolant, tool call, comment).

    Attributes:
        pose: index of the first pose that comes after it.
        word: short text as a program comment may carry it, such as ``S5000 M3``.
        line: line of the source file, counted from 1.
    """

    pose: int
    word: str
    line: int


@dataclass(frozen=True, repr=False)
class Setting:
    """What a robot program says of tool, work object and joints; keys and rows are whole values of ``Toolpath.row``.

    It is about the source: sampling and ``take`` leave it as it is.

    Attributes:
        tools: number (as in ``Toolpath.tool``) -> frame and load; a number without an entry is one that the program
            only names, its frame stands in the controller.
        workobject: (4, 4) base -> frame of the poses; None: only the controller knows it.
        joints: row -> (n,) rad of moves given in joint angles. Their position and quaternion are NaN.
        zones: (rows,) m the corner at the move's end may be cut by; 0 is an exact stop, NaN: not said.
        configuration: (rows,) bits as in Program, -1: not said; None: the language does not say.
        external: external axis, as the language calls it -> (rows,) where it stands at the move's end, mm or deg, NaN:
            not said. Axes that stand at 0 all the time are left out.
        arcs: row of an arc that starts from joint angles -> (3,) m of a point that it passes, m its points may be off.
    """

    tools: Mapping[int, ToolFrame] = field(default_factory=dict)
    workobject: Floats | None = None
    joints: Mapping[int, Floats] = field(default_factory=dict)
    zones: Floats | None = None
    configuration: Ints | None = None
    external: Mapping[str, Floats] = field(default_factory=dict)
    arcs: Mapping[int, tuple[Floats, float]] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Setting({len(self.tools)} tools, {len(self.joints)} joint moves)"


@dataclass(frozen=True, repr=False)
class Toolpath:
    """Poses of the TCP in the work-object frame, in the order of machining.

    Attributes:
        source: the file as the user named it.
        language: the reader's name (``gcode``, ``apt``, ``csv``, ...).
        position: (N, 3) m.
        axis: (N, 3) unit tool axis, from the tip to the spindle; TCP z is its negative.
        quaternion: (N, 4) w, x, y, z of the TCP where the file fixes the whole orientation
            (then ``axis`` is minus its z column), else None: the turn about the axis is open.
        feed: (N,) m/s of the move that ends at the pose; NaN where the file gives none.
        kind: (N,) RAPID or CUT, of the move that ends at the pose.
        tool: (N,) number of the tool in use, 0 where none was called.
        line: (N,) line of the source file, counted from 1.
        row: (N,) index of the pose in the source, plus the fraction towards the next one
            for poses that sampling put in between.
        events: what stands between the moves.
        setting: what a robot program says of its tools and frames; None for CAM files.
    """

    source: str
    language: str
    position: Floats
    axis: Floats
    quaternion: Floats | None
    feed: Floats
    kind: npt.NDArray[np.uint8]
    tool: Ints
    line: Ints
    row: Floats
    events: tuple[Event, ...] = ()
    setting: Setting | None = None

    def __post_init__(self) -> None:
        n = len(self.position)
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, np.ndarray):
                if len(value) != n:
                    raise ValueError(f"Toolpath.{f.name} has {len(value)} rows, position {n}")
                value.setflags(write=False)

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"Toolpath({self.source!r}, {len(self)} poses, {int(np.sum(self.kind))} cutting)"

    def take(self, index: Sequence[int] | npt.NDArray[np.intp]) -> Toolpath:
        """The poses of ``index``, in that order; events move to the next pose kept."""
        chosen = np.asarray(index, dtype=np.intp)
        at = {e: int(np.searchsorted(chosen, e.pose)) for e in self.events}
        return replace(
            self,
            position=self.position[chosen],
            axis=self.axis[chosen],
            quaternion=None if self.quaternion is None else self.quaternion[chosen],
            feed=self.feed[chosen],
            kind=self.kind[chosen],
            tool=self.tool[chosen],
            line=self.line[chosen],
            row=self.row[chosen],
            events=tuple(replace(e, pose=at[e]) for e in self.events),
        )


def tool_axis(quaternion: Floats) -> Floats:
    """Minus the z column of the rotations (N, 4) w, x, y, z: from the tip to the spindle, (N, 3)."""
    w, x, y, z = quaternion.T
    return -np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
