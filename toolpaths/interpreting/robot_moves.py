"""RobotMoves: the moves of a robot program, with the places where their poses stand in the text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.frame import Frame
from toolpaths.interpreting.arcs import with_arc_points
from toolpaths.interpreting.move_columns import Marks
from toolpaths.reading.track import LIMIT
from toolpaths.rotation import matrix_from_quaternion, quaternion_from_matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT, SENSE_OPEN, Event, Floats, Ints, Setting, Toolpath, tool_axis

LINE, PTP, JOINTS, ARC = 0, 1, 2, 3  # straight line; joint move to a pose; joint move to angles; arc
MARKS = (
    "word", "kind", "tool", "line", "frame", "configuration", "start", "end",
    "target_start", "target_end", "ref_start", "ref_end", "via_start", "via_end", "via_ref_start", "via_ref_end",
)  # fmt: skip
#: Where the numbers of a pose stand, and where the move names it: the same place twice for poses within the move.
Span = tuple[int, int, int, int]
NOWHERE: Span = (-1, -1, -1, -1)


@dataclass(frozen=True, repr=False)
class RobotMoves:
    """Moves in the order of execution, one row each; arcs are not yet points.

    Attributes:
        source, language: as in Toolpath.
        position: (N, 3) m in the move's own frame; NaN for moves to joint angles.
        quaternion: (N, 4) w, x, y, z in the move's own frame.
        via: (N, 3) m, the point that an arc passes, own frame; NaN for other moves.
        feed, zone: (N,) m/s and m.
        mark: name of MARKS -> (N,) integers. ``start`` and ``end`` are the statement's place in the text,
            ``target_*`` and ``via_*`` those of the numbers of its target and via point, ``*ref_*`` those where the
            statement gives or names them; -1 where there is none. In a program of several files also ``file``.
        joints: move -> (n,) rad.
        frames: in the base, by number; None: only the controller knows it.
        carried: of those that stand on a mechanical unit, by number: as in Setting.
        tools, events, external: as in Setting and Toolpath; events and external axes count moves.
        sources: as in Toolpath.
    """

    source: str
    language: str
    position: Floats
    quaternion: Floats
    via: Floats
    feed: Floats
    zone: Floats
    mark: dict[str, Marks]
    joints: dict[int, Floats]
    frames: tuple[Frame | None, ...]
    tools: dict[int, ToolFrame]
    events: tuple[Event, ...]
    external: Mapping[str, Floats] = field(default_factory=dict)
    sources: tuple[str, ...] = ()
    carried: Mapping[int, tuple[str | int, Frame]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"RobotMoves({self.source!r}, {len(self)} moves)"

    def file(self, move: int) -> str:
        """The file of a move."""
        return self.sources[int(self.mark["file"][move])] if "file" in self.mark else self.source

    def refuse(self, move: int, problem: str, remedy: str = "") -> NoReturn:
        """Raise ReadError for the line of a move."""
        raise ReadError(self.file(move), int(self.mark["line"][move]), problem, remedy)

    @property
    def given_once(self) -> npt.NDArray[np.bool_]:
        """(N,) moves whose statement runs once, and gives the target itself."""
        _, which, runs = np.unique(self.mark["start"], return_inverse=True, return_counts=True)
        return np.asarray((runs[which] == 1) & (self.mark["target_start"] == self.mark["ref_start"]))

    @property
    def main_frame(self) -> int:
        """The frame that the toolpath is given in: that of most cutting moves, of equals the first."""
        cut = self.mark["kind"] == CUT
        return int(np.argmax(np.bincount(self.mark["frame"][cut if cut.any() else slice(None)])))

    def from_main(self) -> list[Frame]:
        """Per frame: the main frame in it."""
        main = self.frames[self.main_frame]
        out: list[Frame] = []
        for number, frame in enumerate(self.frames):
            posed = (self.mark["frame"] == number) & (self.mark["word"] != JOINTS)
            if number == self.main_frame or not posed.any():
                out.append(Frame.identity())
            elif frame is None or main is None:
                problem = "another frame, and one of the two is not in the file"
                remedy = "Give both frames in the program, or one frame for all moves."
                self.refuse(int(np.argmax(posed)), problem, remedy)
            else:
                out.append(Frame.of(np.linalg.inv(frame.matrix) @ main.matrix))
        return out

    def in_main(self, points: Floats) -> Floats:
        """Points (N, 3), one a move in its own frame, in the main frame."""
        out = points
        for number, main in enumerate(self.from_main()):
            rows = self.mark["frame"] == number
            if number != self.main_frame and rows.any():
                out = points.copy() if out is points else out
                out[rows] = main.inward(points[rows])
        return out

    def turned_to_main(self) -> Floats:
        """Quaternions (N, 4) in the main frame."""
        out = self.quaternion
        for number, main in enumerate(self.from_main()):
            rows = (self.mark["frame"] == number) & np.isfinite(self.quaternion[:, 0])
            if number != self.main_frame and rows.any():
                out = out.copy() if out is self.quaternion else out
                out[rows] = quaternion_from_matrix(main.rotation.T @ matrix_from_quaternion(self.quaternion[rows]))
        return out

    def toolpath(self, chord: float) -> Toolpath:
        """The poses in the main frame, arcs as points; ``row`` counts moves.

        Arcs that start from joint angles stay one pose each, and are in ``Setting.arcs``: see ``with_arcs``.

        Raises:
            ReadError: an arc through points on a line, or as the first move.
        """
        position, quaternion = self.in_main(self.position), self.turned_to_main()
        self._check_reach(position)
        arcs = np.flatnonzero(self.mark["word"] == ARC)
        if len(arcs) and arcs[0] == 0:
            self.refuse(0, "an arc whose start is not given", "Put a straight move before it.")
        known = np.isfinite(position[arcs - 1]).all(axis=1)
        via, mark = self.in_main(self.via), self.mark
        ends = Toolpath(
            source=self.source,
            language=self.language,
            position=position,
            axis=tool_axis(quaternion),
            quaternion=quaternion,
            feed=self.feed,
            kind=mark["kind"].astype(np.uint8),
            tool=mark["tool"].astype(np.int32),
            spindle=np.full(len(self), np.nan),
            sense=np.full(len(self), SENSE_OPEN),
            line=mark["line"].astype(np.int32),
            row=np.arange(len(self), dtype=np.float64),
            events=self.events,
            setting=self._setting({int(k): (via[k], chord) for k in arcs[~known]}),
            sources=self.sources,
            file=mark["file"].astype(np.int32) if "file" in mark else None,
        )
        return with_arc_points(ends, arcs[known], via[arcs[known]], chord)

    def _setting(self, arcs: dict[int, tuple[Floats, float]]) -> Setting:
        configuration: Ints = self.mark["configuration"].astype(np.int32)
        frame = self.frames[self.main_frame]
        return Setting(
            tools=self.tools,
            workobject=frame,
            carried=self.carried.get(self.main_frame),
            joints=self.joints,
            zones=self.zone,
            configuration=configuration,
            external=self.external,
            arcs=arcs,
            straight=np.isin(self.mark["word"], (LINE, ARC)),
        )

    def _check_reach(self, position: Floats) -> None:
        far = (np.abs(position) > LIMIT).any(axis=1)
        if far.any():
            at = int(np.argmax(far))
            x, y, z = position[at]
            problem = f"position {x:g}, {y:g}, {z:g} m is beyond {LIMIT:g} m"
            self.refuse(at, problem, "Check the number and the units.")
