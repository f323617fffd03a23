"""Moves of a robot program: collected in flat arrays, with the places where their poses stand in the text."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.programs.program import ToolFrame
from toolpaths.readers.arcs import arc_points, chord_count
from toolpaths.readers.track import LIMIT, most_poses
from toolpaths.rotation import matrix_from_quaternion, quaternion_from_matrix
from toolpaths.toolpath import CUT, Event, Floats, Ints, Setting, Toolpath, tool_axis

LINE, PTP, JOINTS, ARC = 0, 1, 2, 3  # straight line; joint move to a pose; joint move to angles; arc
NUMBERS = ("x", "y", "z", "a", "b", "c", "d", "feed", "zone", "via_x", "via_y", "via_z")
MARKS = (
    "word", "kind", "tool", "line", "frame", "configuration", "start", "end",
    "target_start", "target_end", "ref_start", "ref_end", "via_start", "via_end", "via_ref_start", "via_ref_end",
)  # fmt: skip
#: Where the numbers of a pose stand, and where the move names it: the same place twice for poses within the move.
Span = tuple[int, int, int, int]
NOWHERE: Span = (-1, -1, -1, -1)
_FLAT = 1e-9  # sine below which three points of an arc are on a line


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
            statement gives or names them; -1 where there is none.
        joints: move -> (n,) rad.
        frames: (4, 4) base -> frame, by number; None: only the controller knows it.
        tools, events: as in Setting and Toolpath; events count moves.
    """

    source: str
    language: str
    position: Floats
    quaternion: Floats
    via: Floats
    feed: Floats
    zone: Floats
    mark: dict[str, npt.NDArray[np.int64]]
    joints: dict[int, Floats]
    frames: tuple[Floats | None, ...]
    tools: dict[int, ToolFrame]
    events: tuple[Event, ...]

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"RobotMoves({self.source!r}, {len(self)} moves)"

    @property
    def main_frame(self) -> int:
        """The frame that the toolpath is given in: that of most cutting moves, of equals the first."""
        cut = self.mark["kind"] == CUT
        return int(np.argmax(np.bincount(self.mark["frame"][cut if cut.any() else slice(None)])))

    def from_main(self) -> list[tuple[Floats, Floats]]:
        """Per frame: rotation (3, 3) and origin (3,) of the main frame in it."""
        main = self.frames[self.main_frame]
        out: list[tuple[Floats, Floats]] = []
        for number, frame in enumerate(self.frames):
            posed = (self.mark["frame"] == number) & (self.mark["word"] != JOINTS)
            if number == self.main_frame or frame is main or not posed.any():
                out.append((np.eye(3), np.zeros(3)))
            elif frame is None or main is None:
                at = int(np.argmax(posed))
                raise ReadError(
                    self.source, int(self.mark["line"][at]), "another frame, and one of the two is not in the file",
                    "Give both frames in the program, or one frame for all moves.",
                )  # fmt: skip
            else:
                relative = np.linalg.inv(frame) @ main
                out.append((relative[:3, :3], relative[:3, 3]))
        return out

    def in_main(self, points: Floats) -> Floats:
        """Points (N, 3), one a move in its own frame, in the main frame."""
        out = points.copy()
        for number, (turn, origin) in enumerate(self.from_main()):
            rows = self.mark["frame"] == number
            if number != self.main_frame and rows.any():
                out[rows] = (points[rows] - origin) @ turn
        return out

    def turned_to_main(self) -> Floats:
        """Quaternions (N, 4) in the main frame."""
        out = self.quaternion.copy()
        for number, (turn, _) in enumerate(self.from_main()):
            rows = (self.mark["frame"] == number) & np.isfinite(self.quaternion[:, 0])
            if number != self.main_frame and rows.any():
                out[rows] = quaternion_from_matrix(turn.T @ matrix_from_quaternion(self.quaternion[rows]))
        return out

    def toolpath(self, chord: float) -> Toolpath:
        """The poses in the main frame, arcs as points; ``row`` counts moves.

        Raises:
            ReadError: an arc through points on a line, or from a pose given in joint angles.
        """
        position, quaternion = self.in_main(self.position), self.turned_to_main()
        self._check_reach(position)
        move, row = np.arange(len(self)), np.arange(len(self), dtype=np.float64)
        if (self.mark["word"] == ARC).any():
            position, quaternion, move, row = self._expanded(position, quaternion, chord)
        first = np.searchsorted(move, np.arange(len(self) + 1))
        return Toolpath(
            source=self.source,
            language=self.language,
            position=position,
            axis=tool_axis(quaternion),
            quaternion=quaternion,
            feed=self.feed[move],
            kind=self.mark["kind"][move].astype(np.uint8),
            tool=self.mark["tool"][move].astype(np.int32),
            line=self.mark["line"][move].astype(np.int32),
            row=row,
            events=tuple(Event(int(first[e.pose]), e.word, e.line) for e in self.events),
            setting=self._setting(),
        )

    def _setting(self) -> Setting:
        configuration: Ints = self.mark["configuration"].astype(np.int32)
        return Setting(self.tools, self.frames[self.main_frame], self.joints, self.zone, configuration)

    def _check_reach(self, position: Floats) -> None:
        far = (np.abs(position) > LIMIT).any(axis=1)
        if far.any():
            at = int(np.argmax(far))
            x, y, z = position[at]
            problem = f"position {x:g}, {y:g}, {z:g} m is beyond {LIMIT:g} m"
            raise ReadError(self.source, int(self.mark["line"][at]), problem, "Check the number and the units.")

    def circles(self, position: Floats) -> tuple[npt.NDArray[np.int64], Floats, Floats, Floats, Floats]:
        """Arcs: move (K,), center and normal (K, 3), sweep (K,) rad, share (K,) of the sweep up to the via point.

        Args:
            position: (N, 3) ends of the moves in the main frame.
        """
        arcs = np.flatnonzero(self.mark["word"] == ARC)
        if arcs[0] == 0 or not np.isfinite(position[arcs - 1]).all():
            at = arcs[0] if arcs[0] == 0 else arcs[np.argmin(np.isfinite(position[arcs - 1]).all(axis=1))]
            problem = "an arc whose start is not given as a pose"
            raise ReadError(self.source, int(self.mark["line"][at]), problem, "Put a straight move before it.")
        start, end = position[arcs - 1], position[arcs]
        center, normal, sweep, share, flat = circle_through(start, self.in_main(self.via)[arcs], end)
        if flat.any():
            at = arcs[np.argmax(flat)]
            problem = "start, via point and end of the arc are on one line"
            raise ReadError(self.source, int(self.mark["line"][at]), problem, "Use a straight move, or two arcs.")
        return arcs, center, normal, sweep, share

    def _expanded(
        self, ends: Floats, turned: Floats, chord: float
    ) -> tuple[Floats, Floats, npt.NDArray[np.intp], Floats]:
        """Positions and quaternions with the points of arcs put in, the move of each, and its row."""
        arcs, center, normal, sweep, _ = self.circles(ends)
        radius = np.linalg.norm(ends[arcs] - center, axis=1)
        too_wide = not (radius <= LIMIT).all()
        if too_wide or (total := int(chord_count(radius, sweep, chord).sum())) > most_poses(len(ends)):
            at = int(arcs[np.argmax(radius)])
            problem = f"an arc of radius {radius.max():g} m" + ("" if too_wide else f"; all arcs make {total} poses")
            raise ReadError(self.source, int(self.mark["line"][at]), problem, "Use a straight move instead.")
        points = arc_points(ends[arcs - 1], ends[arcs], center, normal, sweep, chord)
        end = arcs[points.arc]
        quaternion = slerped(turned[end - 1], turned[end], points.fraction)
        move = np.concatenate([np.arange(len(ends)), end])
        row = np.concatenate([np.arange(len(ends)), end - 1 + points.fraction])
        order = np.argsort(row, kind="stable")
        return (
            np.concatenate([ends, points.position])[order], np.concatenate([turned, quaternion])[order],
            move[order], row[order],
        )  # fmt: skip


def circle_through(
    start: Floats, via: Floats, end: Floats
) -> tuple[Floats, Floats, Floats, Floats, npt.NDArray[np.bool_]]:
    """Circles through three points (K, 3) each: center, normal (K, 3), sweep (K,) rad start to end, share of the sweep
    (K,) at ``via``, and (K,) whether the points are on a line."""
    a, b = via - start, end - start
    normal = np.cross(a, b)
    size = np.linalg.norm(normal, axis=1)
    flat = ~(size > _FLAT * np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        lever = np.sum(a * a, axis=1)[:, None] * b - np.sum(b * b, axis=1)[:, None] * a
        center = start + np.cross(lever, normal) / (2.0 * size * size)[:, None]
        normal = normal / size[:, None]
    out = start - center
    angles = []
    for point in (via, end):
        arm = point - center
        sine = np.sum(np.cross(out, arm) * normal, axis=1)
        angles.append(np.arctan2(sine, np.sum(out * arm, axis=1)) % (2.0 * np.pi))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = angles[0] / angles[1]
    return center, normal, angles[1], share, flat | ~(angles[1] > 0.0)


def slerped(a: Floats, b: Floats, share: Floats) -> Floats:
    """Unit quaternions (M, 4) on the shorter way from ``a`` to ``b``."""
    cosine = np.sum(a * b, axis=1)
    b = np.where(cosine[:, None] < 0, -b, b)
    chord = np.linalg.norm(b - a, axis=1)
    angle = 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
    small = angle < 1e-9
    sine = np.where(small, 1.0, np.sin(angle))
    left = np.where(small, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    right = np.where(small, share, np.sin(share * angle) / sine)
    out = left[:, None] * a + right[:, None] * b
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


class RobotTrack:
    """Where a reader of a robot language appends moves.

    Args:
        quaternions: how the language's orientation numbers (N, 4) become quaternions (N, 4).
    """

    def __init__(self, source: str, language: str, quaternions: Callable[[Floats], Floats]) -> None:
        self.source, self.language, self._quaternions = source, language, quaternions
        self.numbers, self.marks = array("d"), array("q")
        self.joints: dict[int, Floats] = {}
        self.frames: list[Floats | None] = []
        self.tools: dict[int, ToolFrame] = {}
        self.events: list[Event] = []
        self.count = 0

    def event(self, word: str, line: int) -> None:
        """Note what the file says before its next move."""
        self.events.append(Event(self.count, word, line))

    def frame(self, pose: Floats | None) -> int:
        """The number of a frame; the same frame has the same number."""
        for number, known in enumerate(self.frames):
            if known is pose or (known is not None and pose is not None and np.array_equal(known, pose)):
                return number
        self.frames.append(pose)
        return len(self.frames) - 1

    def move(self, numbers: tuple[float, ...], marks: tuple[int, ...]) -> None:
        """Append a move: values of NUMBERS (lengths in mm, feed in mm/s) and of MARKS."""
        self.numbers.extend(numbers)
        self.marks.extend(marks)
        self.count += 1

    def moves(self) -> RobotMoves:
        """All moves, in SI."""
        if not self.count:
            raise ReadError(self.source, None, "there is no move in the program", "Give one that moves the arm.")
        table = np.frombuffer(self.numbers, dtype=np.float64).reshape(-1, len(NUMBERS))
        marks = np.frombuffer(self.marks, dtype=np.int64).reshape(-1, len(MARKS))
        return RobotMoves(
            self.source, self.language, table[:, :3] * 1e-3, self._quaternions(table[:, 3:7]), table[:, 9:12] * 1e-3,
            table[:, 7] * 1e-3, table[:, 8] * 1e-3, {name: marks[:, k] for k, name in enumerate(MARKS)},
            self.joints, tuple(self.frames), self.tools, tuple(self.events),
        )  # fmt: skip
