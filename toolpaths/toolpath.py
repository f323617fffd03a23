"""Toolpath: where a CAM file wants the tool centre point, pose by pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpaths.axis_ways import AxisWays
from toolpaths.columns import once
from toolpaths.finding import Finding
from toolpaths.frame import Frame
from toolpaths.tool_frame import ToolFrame

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]
Rows = npt.NDArray[np.intp]
Senses = npt.NDArray[np.int8]

RAPID = np.uint8(0)
CUT = np.uint8(1)

#: Senses of the spindle: M3, right-handed about TCP z (clockwise seen from the spindle); M4; not in the file.
CLOCKWISE, COUNTERCLOCKWISE, SENSE_OPEN = np.int8(1), np.int8(-1), np.int8(0)


@dataclass(frozen=True)
class MachineCommand:
    """What a file asks of the machine besides moving.

    Attributes:
        word: as G-code has it, whatever the language of the file: M3, M4, M5, M6 (mount a tool), M7 to M9, M0, M1, G4,
            T (a tool to have ready); else the first word of the statement, in capitals, such as CLAMP or SETDO.
        values: S, 1/min, of M3 and M4; T of M6 and T; P of G4, as the file has it.
    """

    word: str
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Event:
    """Something that stands between two moves of a CAM file (spindle, coolant, tool call, comment).

    Attributes:
        pose: index of the first pose that comes after it.
        word: short text as a program comment may carry it, such as ``S5000 M3``.
        line: line of the source file, counted from 1.
        commands: what it asks of the machine, in the order of execution; none for comments.
        file: which of ``Toolpath.sources`` that is.
    """

    pose: int
    word: str
    line: int
    commands: tuple[MachineCommand, ...] = ()
    file: int = 0


@dataclass(frozen=True, repr=False)
class Setting:
    """Tools, work object, joints and more of a robot program; keys and rows are whole values of ``Toolpath.row``.

    It is about the source: sampling and ``take`` leave it as it is.

    Attributes:
        tools: number (as in ``Toolpath.tool``) -> frame and load; a number without an entry is one that the program
            only names, its frame stands in the controller.
        workobject: frame of the poses in the base; None: only the controller knows it.
        carried: what turns the work object, where the program says so: name or number of the mechanical unit, and the
            frame of the poses on it; None: nothing does.
        joints: row -> (n,) rad of moves given in joint angles. Their position and quaternion are NaN.
        zones: (rows,) m the corner at the move's end may be cut by; 0 is an exact stop, NaN: not given.
        configuration: (rows,) bits as in Program, -1: not given; None: the language has none.
        external: external axis, as the language calls it -> (rows,) where it stands at the move's end, mm or deg, NaN:
            not given. Axes that stand at 0 all the time are left out.
        arcs: row of an arc that starts from joint angles -> (3,) m of a point that it passes, m its points may be off.
        straight: (rows,) whether the way to the move's end is a line or an arc, not a joint move. None: not known.
    """

    tools: Mapping[int, ToolFrame] = field(default_factory=dict)
    workobject: Frame | None = None
    carried: tuple[str | int, Frame] | None = None
    joints: Mapping[int, Floats] = field(default_factory=dict)
    zones: Floats | None = None
    configuration: Ints | None = None
    external: Mapping[str, Floats] = field(default_factory=dict)
    arcs: Mapping[int, tuple[Floats, float]] = field(default_factory=dict)
    straight: npt.NDArray[np.bool_] | None = None

    def __repr__(self) -> str:
        return f"Setting({len(self.tools)} tools, {len(self.joints)} joint moves)"


@dataclass(frozen=True, repr=False)
class Toolpath:
    """Poses of the TCP in the work-object frame, in the order of machining.

    Attributes:
        source: the file as the user named it; of several, the main one.
        language: the reader's name (``gcode``, ``apt``, ``csv``, ...).
        position: (N, 3) m.
        axis: (N, 3) unit tool axis, from the tip to the spindle; TCP z is its negative.
        quaternion: (N, 4) w, x, y, z of the TCP where the file fixes the whole orientation
            (then ``axis`` is minus its z column), else None: the turn about the axis is open.
        feed: (N,) m/s of the move that ends at the pose; NaN where the file gives none.
        kind: (N,) RAPID or CUT, of the move that ends at the pose.
        tool: (N,) number of the tool in use, 0 where none was called.
        spindle: (N,) rad/s of the spindle during the move that ends at the pose; 0 where the file has stopped it (M5,
            a tool change), NaN where it gives no speed. Robot programs give none: they only set outputs.
        sense: (N,) CLOCKWISE (M3), COUNTERCLOCKWISE (M4) or SENSE_OPEN, of the same move.
        line: (N,) line of the source file, counted from 1.
        row: (N,) index of the pose in the source, plus the fraction towards the next one
            for poses that sampling put in between.
        events: what stands between the moves.
        setting: tools and frames of a robot program; None for CAM files.
        findings: what its reader has to tell about the file.
        sources: all files of a program of several, ``source`` first; else none.
        file: (N,) which of ``sources`` the line is in; None: in ``source``.
        ways: where external axes stand along the path, that were chosen for it; None: none was.
    """

    source: str
    language: str
    position: Floats
    axis: Floats
    quaternion: Floats | None
    feed: Floats
    kind: npt.NDArray[np.uint8]
    tool: Ints
    spindle: Floats
    sense: Senses
    line: Ints
    row: Floats
    events: tuple[Event, ...] = ()
    setting: Setting | None = None
    findings: tuple[Finding, ...] = ()
    sources: tuple[str, ...] = ()
    file: Ints | None = None
    ways: AxisWays | None = None

    def __post_init__(self) -> None:
        n = len(self.position)
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, np.ndarray):
                if len(value) != n:
                    raise ValueError(f"Toolpath.{f.name} has {len(value)} rows, position {n}")
                if f.name in ("feed", "kind", "tool", "spindle", "sense"):
                    value = once(value)
                    object.__setattr__(self, f.name, value)
                value.setflags(write=False)

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"Toolpath({self.source!r}, {len(self)} poses, {int(np.sum(self.kind))} cutting)"

    @property
    def on_part(self) -> Floats:
        """(N, 3) m, the positions as the part sees them: its ways are the feed's, whatever axes do meanwhile."""
        return self.position if self.ways is None else self.ways.on_part(self.row, self.position)

    @property
    def axis_on_part(self) -> Floats:
        """(N, 3) the tool axes as the part sees them."""
        part = None if self.ways is None else self.ways.part_at(self.row)
        return self.axis if part is None else np.einsum("nji,nj->ni", part.rotation, self.axis)

    def where(self, pose: int) -> str:
        """File and line of a pose, as messages have them."""
        source = self.source if self.file is None else self.sources[self.file[pose]]
        return f"{source}:{self.line[pose]}"

    def line_words(self, pose: int) -> str:
        """``line 7``; of a program of several files with the name of its file."""
        beside = "" if self.file is None else f" of {Path(self.sources[self.file[pose]]).name}"
        return f"line {self.line[pose]}{beside}"

    def _columns(self) -> dict[str, npt.NDArray[Any]]:
        """What has a row per pose, by name."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {name: value for name, value in values.items() if isinstance(value, np.ndarray)}

    def take(self, index: Sequence[int] | Rows) -> Toolpath:
        """The poses of ``index``, in that order; events move to the next pose kept."""
        return self._with(np.asarray(index, dtype=np.intp), {})

    def _with(self, chosen: Rows, own: dict[str, Any]) -> Toolpath:
        """The poses ``chosen``, but for columns of their ``own``."""
        events = tuple(replace(e, pose=int(np.searchsorted(chosen, e.pose))) for e in self.events)
        columns: dict[str, Any] = {k: values[chosen] for k, values in self._columns().items() if k not in own}
        return replace(self, **columns, **own, events=events)

    def with_points(self, end: Rows, row: Floats, position: Floats, orientation: Floats) -> Toolpath:
        """The path with M poses put into its moves; everything else of a new pose is that of its move's end.

        Events that stand before a move stay before it, ahead of the poses put into it.

        Args:
            end: (M,) the pose that each move leads to, ascending; poses of one move in their order along it.
            row: (M,) as in ``Toolpath.row``.
            position: (M, 3) m.
            orientation: (M, 4) quaternions where this path has them, else (M, 3) tool axes.
        """
        own: dict[str, Floats] = {"row": row, "position": position}
        if self.quaternion is None:
            own["axis"] = orientation
        else:
            own |= {"quaternion": orientation, "axis": tool_axis(orientation)}
        grown = {name: np.insert(getattr(self, name), end, values, axis=0) for name, values in own.items()}
        return self._with(np.insert(np.arange(len(self)), end, end), grown)


def tool_axis(quaternion: Floats) -> Floats:
    """Minus the z column of the rotations (N, 4) w, x, y, z: from the tip to the spindle, (N, 3)."""
    w, x, y, z = quaternion.T
    return -np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
