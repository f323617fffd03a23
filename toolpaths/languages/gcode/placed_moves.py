"""PlacedMoves: from a programmed move to those that the tool makes: corners, cutter compensation, tilted planes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from toolpaths.frame import Vector
from toolpaths.languages.gcode.codes import G
from toolpaths.languages.gcode.corner import PendingCorner, made
from toolpaths.languages.gcode.modal_state import ModalState
from toolpaths.languages.gcode.programmed_move import ProgrammedMove
from toolpaths.languages.gcode.words import Words
from toolpaths.machine import Machine
from toolpaths.reading.track import CUT_MARK, RAPID_MARK

NORMALS: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class PlacedMoves(ModalState):
    """The moves of one file as they are appended to its track."""

    def __init__(self, source: str, machine: Machine | None) -> None:
        super().__init__(source, machine)
        self._corner: PendingCorner | None = None

    def refuse_open(self, word: str) -> None:
        """Words that cannot stand where a corner waits for its second line, or under cutter compensation.

        Raises:
            ValueError: one does.
        """
        self.refuse_corner(word)
        if self.compensation is not None:
            raise ValueError(f"{word} under cutter compensation", "Write G40 before it.")

    def refuse_corner(self, word: str) -> None:
        """Words that cannot stand where a corner waits for its second line.

        Raises:
            ValueError: one does.
        """
        if self._corner is not None:
            raise ValueError(f"{word} behind a corner (,R or ,C)", "The second line has to follow: G1 with X and Y.")

    def keep_corner(self, move: ProgrammedMove, values: Words) -> bool:
        """Whether the block has a corner: its line waits for the next one.

        Raises:
            ValueError: a corner where none can be.
        """
        if ",R" not in values and ",C" not in values:
            return False
        size = values.get(",R", values.get(",C", 0.0)) * self.scale()
        if self.motion is not G.LINE or (",R" in values and ",C" in values) or not size >= 0:
            raise ValueError("a corner (,R or ,C): it stands behind a line (G1), alone, and is not negative")
        if any(v != v for v in (*move.start, *move.end)) or not len(self.track):
            raise ValueError("a corner (,R or ,C), but where its line starts is not known")
        if self.tip or self.rotary.used:
            raise ValueError("a corner (,R or ,C) with rotary axes or tool vectors")
        self._corner = PendingCorner(
            move=move, radius=size if ",R" in values else None, chamfer=size, normal=self.normal
        )
        return True

    def round_corner(self, move: ProgrammedMove) -> ProgrammedMove:
        """The corner that waits for this line is made; what is left of the line."""
        pending, self._corner = self._corner, None
        if pending is None:
            return move
        if move.mark != CUT_MARK or move.center is not None or self.normal != pending.normal:
            raise ValueError("a corner (,R or ,C), and no line (G1) in the same plane behind it")
        corner = made(pending, move.end)
        first = pending.move
        if corner.begin != first.start:
            self.place(replace(first, end=corner.begin))
        if corner.end != corner.begin:
            self.place(replace(
                first, start=corner.begin, end=corner.end, center=corner.center, normal=NORMALS[self.normal],
                sweep=corner.sweep,
            ))  # fmt: skip
        return replace(move, start=corner.end)

    def place(self, move: ProgrammedMove, time: float = math.nan) -> None:
        """Append a move; ``time``: s, where rotary axes turn."""
        if self.compensation is not None:
            if self.normal != 2 or self.tip or self.plane is not None:
                raise ValueError("another plane, a tilted plane or tool vectors under cutter compensation")
            self.compensation.segment(move)
            return
        if move.center is not None:
            self.track.arc(self._in_work(move.center), self._along(move.normal), move.sweep)
        self.append(move, time)

    def append(self, move: ProgrammedMove, time: float = math.nan) -> None:
        """The end of a move, as a pose."""
        track = self.track
        if self.plane is None:
            if any(self.beside.values()):
                words = " ".join(f"{c}{v:g}" for c, v in self.beside.items())
                raise ValueError(f"a move in no tilted plane while the rotary axes stand at {words}",
                                 "Write G68.2 and G53.1 before it, or declare [machine] in the cell.")  # fmt: skip
            track.moves.extend((*move.end, *self.axis, move.feed))
        else:
            if not self.in_plane or self.tip:
                what = "G43.4 under G68.2" if self.tip else "a move between G68.2 and G53.1"
                raise ValueError(f"{what}: how the tool stands is not in the file")
            track.moves.extend((*self._in_work(move.end), *self._along(self.axis), move.feed))
        track.marks.extend((move.mark, self.tool, move.line))
        if self.rotary.used:
            self.rotary.note(self.tip, time)

    def rapid(self, end: Vector, line: int) -> ProgrammedMove:
        """A rapid from where the tool is."""
        return ProgrammedMove(self.at, end, mark=RAPID_MARK, feed=math.nan, line=line, tool=self.tool)

    def _in_work(self, point: Vector) -> Vector:
        return point if self.plane is None else _plain(self.plane.at(np.array(point)))

    def _along(self, direction: Vector) -> Vector:
        return direction if self.plane is None else _plain(self.plane.along(np.array(direction)))


def _plain(v: np.typing.NDArray[np.float64]) -> Vector:
    x, y, z = v.tolist()
    return x, y, z
