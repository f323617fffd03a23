"""Program: the moves of one robot with all that a controller has to know, in no language yet."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields
from pathlib import PurePath

import numpy as np
import numpy.typing as npt

from toolpaths.columns import Column, MadeColumn
from toolpaths.finding import Finding
from toolpaths.frame import Frame
from toolpaths.made_frames import MadeFrames
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import MachineCommand
from toolpaths.writing.part_carrier import PartCarrier

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]


HEADING = "Compensated program"


@dataclass(frozen=True)
class Order:
    """What the source asks of the machine in front of a pose.

    Attributes:
        pose: of the program; its length: behind the last one.
        command: what is asked.
        line: of the source.
        text: what the source says, as in ``Program.comments``.
        lines: what the program does for it, in its language; None: nobody said what.
        source: file of the line, of a source of several files; empty: the program's one.
    """

    pose: int
    command: MachineCommand
    line: int
    text: str
    lines: tuple[str, ...] | None = None
    source: str = ""


@dataclass(frozen=True, repr=False, eq=False)
class ExternalAxis:
    """Where a rail or a table stands at every pose.

    Attributes:
        name: as the cell calls it, such as E1 or eax_a. unit: mm or deg. places: (N,) in that unit.
    """

    name: str
    unit: str
    places: Floats

    def __repr__(self) -> str:
        return f"ExternalAxis({self.name}, {self.places.min():g} ... {self.places.max():g} {self.unit})"


@dataclass(frozen=True, repr=False)
class Program:
    """Moves of one robot in the order of execution; every array has N rows.

    The first pose is reached by a joint move, and so is the first one of every tool; every other by a straight line of
    the TCP.

    Attributes:
        name: of the program, as the user calls it; each language makes it legal in its own way.
        position: (N, 3) m, commanded TCP in the work-object frame.
        rotation: (N, 3, 3), or made where asked for: commanded orientation of the TCP in the work-object frame.
        joints: (N, n) rad, command.
        feed: (N,) m/s of the move that ends at the pose; NaN where none (rapids: ``rapid_speed`` holds).
        kind: (N,) RAPID or CUT.
        tool: (N,) number of the tool; a key of ``tools``.
        line: (N,) line of the source file, counted from 1.
        tools: number -> ToolFrame.
        workobject: in the base.
        rapid_speed: m/s of rapids.
        configuration: (N,) bits 4 = wrist centre behind axis 1, 2 = wrist centre behind the lower arm,
            1 = joint 5 negative; None for arms without a spherical wrist.
        exact: (N,) poses that have to be reached, not rounded; None: none but the last.
        start_joints: (n,) rad to drive to first, or None: start at the first pose.
        comments: (pose, text): a comment in front of that pose.
        orders: what the source asks of the machine, in its order.
        robot: name of the robot.
        source: name of the file that the poses come from.
        nominal_position: (N, 3) m, where the TCP has to be; None: where it is commanded.
        nominal_rotation: (N, 3, 3).
        nominal_joints: (N, n) rad, of the nominal pose, in the same turns as ``joints``; None: not known.
        wrench: (N, 6) N and N m on the robot, base axes, about the TCP; None: not known.
        deflection: (N, 3) m predicted at the command, base axes; None: not known.
        external: rails and tables that were chosen with the path; none where the program has none.
        carrier: what turns the part on the way: ``workobject`` is where it stands with the axis at 0; None: nothing.
        stamp: comments for the head of the program, of at most 30 characters each: what it was made from.
        heading: what it is, in the first comment of its head; of another than HEADING nothing is compensated.
        findings: of whoever made the program.
    """

    name: str
    position: Floats
    rotation: Column
    joints: Column
    feed: Floats
    kind: npt.NDArray[np.uint8]
    tool: Ints
    line: Ints
    tools: dict[int, ToolFrame]
    workobject: Frame
    rapid_speed: float
    configuration: Ints | None = None
    exact: npt.NDArray[np.bool_] | None = None
    start_joints: Floats | None = None
    comments: tuple[tuple[int, str], ...] = ()
    orders: tuple[Order, ...] = ()
    robot: str = ""
    source: str = ""
    nominal_position: Column | None = None
    nominal_rotation: Column | None = None
    nominal_joints: Column | None = None
    wrench: Floats | None = None
    deflection: Column | None = None
    external: tuple[ExternalAxis, ...] = ()
    carrier: PartCarrier | None = None
    stamp: tuple[str, ...] = ()
    heading: str = HEADING
    findings: tuple[Finding, ...] = field(default=())

    def __post_init__(self) -> None:
        n = len(self.position)
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, np.ndarray | MadeColumn):
                if f.name != "start_joints" and len(value) != n:
                    raise ValueError(f"Program.{f.name} has {len(value)} rows, position {n}")
                if isinstance(value, np.ndarray):
                    value.setflags(write=False)

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"Program({self.name!r}, {len(self)} poses, {int(np.sum(self.kind))} cutting, {self.robot})"

    def place(self, pose: int) -> str:
        """A pose as messages name it."""
        return f"pose {pose} ({self.source or 'source'}:{int(self.line[pose])})"

    @property
    def source_name(self) -> str:
        """The source without its folder: the same inputs give the same bytes, wherever they lie."""
        return PurePath(self.source).name

    @property
    def tool_changes(self) -> list[int]:
        """Poses that another tool goes to than to the pose before."""
        return [int(k) for k in np.flatnonzero(np.diff(self.tool)) + 1]

    def blocks(self, size: int = 4096, first: int = 0, end: int | None = None) -> Iterator[slice]:
        """Ranges of poses to format at one time, so that memory stays bounded."""
        stop = len(self) if end is None else end
        for start in range(first, stop, size):
            yield slice(start, min(start + size, stop))


@dataclass(frozen=True, repr=False)
class ReadBack:
    """What stands in a written program: poses and joints as printed.

    Attributes:
        poses: (N) of the TCP.
        joints: (N, n) rad where the language prints them for every pose, else None.
        start_joints: (n,) rad of the joint move to the start, or None.
        feed: (N,) m/s, NaN where none is printed.
        configuration: (N,) bits as in Program, or None where the language has none.
        external: (N, K) of K external axes, in their order in the program, mm or deg; None: it has none.
        turn_known: whether the turn about the tool is printed; where it is not, that of ``rotation`` is any.
    """

    poses: Frame
    joints: Floats | None = None
    start_joints: Floats | None = None
    feed: Floats | None = None
    configuration: Ints | None = None
    turn_known: bool = True
    external: Floats | None = None

    def __len__(self) -> int:
        return self.poses.count

    def __repr__(self) -> str:
        return f"ReadBack({len(self)} poses)"

    @property
    def position(self) -> Floats:
        """(N, 3) m."""
        return self.poses.origin

    @property
    def rotation(self) -> Floats:
        """(N, 3, 3)."""
        return self.poses.rotation


def printed_poses(position: Floats, turn: Floats, rotation: Callable[[Floats], Floats]) -> Frame:
    """N poses at positions (N, 3) m, with orientations (N, k) as a language prints them; they are made to rotations
    where they are asked for.

    Args:
        rotation: orientations (K, k) -> (K, 3, 3).
    """
    return MadeFrames(len(position), lambda rows: Frame(rotation(turn[rows]), position[rows]), lambda: position)
