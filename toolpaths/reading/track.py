"""Track: where a reader collects moves, in flat arrays, until they become a Toolpath."""

from __future__ import annotations

from array import array

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.frame import Vector
from toolpaths.reading.arc_points import arc_points, chord_count
from toolpaths.reading.spindle import SpindleTrack
from toolpaths.toolpath import CUT, RAPID, Event, Floats, Ints, MachineCommand, Toolpath

LIMIT = 1e3  # m; a coordinate beyond it is a mistake, and arcs of such size would fill the memory
MOST_POSES = 50_000_000
POSES_OF_A_FILE, POSES_OF_A_MOVE = 1_000_000, 3000  # so that a short file cannot fill the memory
RAPID_MARK, CUT_MARK = int(RAPID), int(CUT)


def most_poses(moves: int) -> int:
    """How many poses a file of so many moves may become."""
    return min(MOST_POSES, POSES_OF_A_FILE + POSES_OF_A_MOVE * moves)


class Track:
    """Moves of one file, appended in the order of machining.

    Attributes:
        moves: 7 numbers a move: x, y, z of its end (``scale`` makes m of them), i, j, k, feed m/s.
        marks: 3 integers a move: kind, tool, line.
        arcs: 7 numbers an arc: center x, y, z, normal i, j, k, sweep rad.
        arc_moves: which move each arc is.
        spindle: how it turns; counts moves as ``len`` does.
        events: their ``pose`` counts moves until ``toolpath`` is called.
    """

    def __init__(self, source: str, language: str) -> None:
        self.source, self.language = source, language
        self.moves, self.marks = array("d"), array("i")
        self.arcs, self.arc_moves = array("d"), array("q")
        self.spindle = SpindleTrack()
        self.events: list[Event] = []

    def __len__(self) -> int:
        return len(self.marks) // 3

    def event(self, word: str, line: int, *commands: MachineCommand) -> None:
        """Keep a remark of the file for its next move, with what it asks of the machine."""
        self.events.append(Event(len(self), word, line, commands))

    def arc(self, center: Vector, normal: Vector, sweep: float) -> None:
        """Declare that the move appended next is an arc from the last one's end."""
        self.arcs.extend((*center, *normal, sweep))
        self.arc_moves.append(len(self))

    def toolpath(self, chord: float, *, scale: float = 1.0) -> Toolpath:
        """The poses, arcs as points; ``scale`` makes m of the positions."""
        n = len(self)
        if not n:
            raise ReadError(self.source, None, "there is no move in the file", "Post it again from CAM.")
        moves = np.frombuffer(self.moves, dtype=np.float64).reshape(n, 7)
        kind, tool, line = np.frombuffer(self.marks, dtype=np.int32).reshape(n, 3).T
        position = moves[:, :3] * scale
        self._check_reach(position, line)
        spindle, sense = self.spindle.columns(n)
        ends = Toolpath(
            source=self.source,
            language=self.language,
            position=position,
            axis=moves[:, 3:6].copy(),
            quaternion=None,
            feed=moves[:, 6].copy(),
            kind=kind.astype(np.uint8),
            tool=tool.copy(),
            spindle=spindle,
            sense=sense,
            line=line.copy(),
            row=np.arange(n, dtype=np.float64),
            events=tuple(self.events),
        )
        return self._with_arc_points(ends, chord, scale) if self.arc_moves else ends

    def _check_reach(self, position: Floats, line: Ints) -> None:
        far = ~(np.abs(position) <= LIMIT).all(axis=1)
        if far.any():
            at = int(np.argmax(far))
            x, y, z = position[at]
            problem = f"position {x:g}, {y:g}, {z:g} m is beyond {LIMIT:g} m"
            raise ReadError(self.source, int(line[at]), problem, "Check the number and the units.")

    def _with_arc_points(self, path: Toolpath, chord: float, scale: float) -> Toolpath:
        """Arcs as points: with the tool axis of their end."""
        moves, ends = np.frombuffer(self.arc_moves, dtype=np.int64), path.position
        arcs = np.frombuffer(self.arcs, dtype=np.float64).reshape(-1, 7)
        center, sweep = arcs[:, :3] * scale, arcs[:, 6]
        start = ends[moves - 1]
        radius = np.linalg.norm(start - center, axis=1)
        if (far := np.flatnonzero(~(radius <= LIMIT))).size:
            problem = f"an arc of radius {radius[far[0]]:g} m, at most {LIMIT:g} m"
            raise ReadError(self.source, int(path.line[moves[far[0]]]), problem, "Post a line instead.")
        total = int(chord_count(radius, sweep, chord).sum()) + len(ends)
        if total > (most := most_poses(len(ends))):
            problem = f"its arcs make {total} poses; at most {most} of {len(ends)} moves"
            raise ReadError(self.source, None, problem, "Take a larger chord tolerance.")
        points = arc_points(start, end=ends[moves], center=center, normal=arcs[:, 3:6], sweep=sweep, chord=chord)
        end = moves[points.arc]
        return path.with_points(end, end - 1 + points.fraction, points.position, path.axis[end])
