"""RobotTrack: where an interpreter collects moves, in flat arrays, until they become RobotMoves."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

from toolpaths.columns import once
from toolpaths.errors import ReadError
from toolpaths.frame import Frame
from toolpaths.interpreting.move_columns import MoveColumns
from toolpaths.interpreting.program_text import LinkedText
from toolpaths.interpreting.robot_moves import MARKS, RobotMoves
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import Event, Floats, MachineCommand

_FIRST_WORD = re.compile(r"\$?\w+")
SAME_PLACES = {"ref_start": "target_start", "ref_end": "target_end"}
NUMBERS = ("x", "y", "z", "a", "b", "c", "d", "feed", "zone", "via_x", "via_y", "via_z")


class RobotTrack:
    """Where a reader of a robot language appends moves.

    Args:
        quaternions: how the language's orientation numbers (N, 4) become quaternions (N, 4).
        external: names of the external axes, in the order of ``stand``.
        text: that of a program of several files, in which the places of moves count.
    """

    def __init__(
        self, source: str, language: str, quaternions: Callable[[Floats], Floats], external: Sequence[str] = (),
        text: LinkedText | None = None,
    ) -> None:  # fmt: skip
        self.source, self.language, self._quaternions, self._text = source, language, quaternions, text
        self._columns = MoveColumns(NUMBERS, MARKS)
        self.joints: dict[int, Floats] = {}
        self.frames: list[Floats | None] = []
        self._unknown: dict[str, int] = {}
        self.tools: dict[int, ToolFrame] = {}
        self.events: list[Event] = []
        self.carried: dict[int, tuple[str | int, Frame]] = {}
        self.external = tuple(external)
        self.stands: list[tuple[int, tuple[float, ...]]] = []

    @property
    def count(self) -> int:
        """How many moves there are."""
        return self._columns.count

    def event(self, word: str, line: int, instruction: str = "", file: int = 0) -> None:
        """Keep a remark of a file for the next move; ``instruction``: what it is, if it acts on the machine."""
        named = _FIRST_WORD.match(instruction)
        commands = (MachineCommand(named[0].upper()),) if named else ()
        self.events.append(Event(self.count, word, line, commands=commands, file=file))

    def stand(self, values: tuple[float, ...]) -> None:
        """Where the external axes stand from the end of the next move on, NaN where it is not given."""
        self.stands.append((self.count, values))

    def _external(self) -> dict[str, Floats]:
        """As in Setting."""
        if not self.stands:
            return {}
        table = np.array([(np.nan,) * len(self.external), *(values for _, values in self.stands)])
        row = np.searchsorted([move for move, _ in self.stands], np.arange(self.count), side="right")
        used = np.nan_to_num(table).any(axis=0)
        return {name: table[row, k] for k, name in enumerate(self.external) if used[k]}

    def frame(self, pose: Floats | None, name: str = "") -> int:
        """The number of a frame (4, 4), the same for the same; those that only the controller knows go by name."""
        if pose is None:
            if name not in self._unknown:
                self._unknown[name] = len(self.frames)
                self.frames.append(None)
            return self._unknown[name]
        for number, known in enumerate(self.frames):
            if known is pose or (known is not None and np.array_equal(known, pose)):
                return number
        self.frames.append(pose)
        return len(self.frames) - 1

    def frame_on(self, unit: str | int, pose: Floats, key: str) -> int:
        """The number of a frame (4, 4) on a mechanical unit, the same for the same ``key``."""
        number = self.frame(None, key)
        self.carried[number] = (unit, Frame.of(pose))
        return number

    def move(self, numbers: tuple[float, ...], marks: tuple[int, ...]) -> None:
        """Append a move: values of NUMBERS (lengths in mm, feed in mm/s) and of MARKS."""
        self._columns.append(numbers, marks)

    def moves(self) -> RobotMoves:
        """All moves, in SI; they are given away."""
        if not self.count:
            raise ReadError(self.source, None, "there is no move in the program", "Give one that moves the arm.")
        c = self._columns
        frames = tuple(None if pose is None else Frame.of(pose) for pose in self.frames)
        mark = {name: c.mark(name) for name in MARKS}
        for name, same in SAME_PLACES.items():  # of poses that stand in the move itself
            if np.array_equal(mark[name], mark[same]):
                mark[name] = mark[same]
        sources: tuple[str, ...] = ()
        if self._text is not None and len(self._text.parts) > 1:
            sources = tuple(part.source for part in self._text.parts)
            mark["file"] = self._text.parts_of(mark["start"])
        return RobotMoves(
            source=self.source, language=self.language, position=_in_si(c.numbers("x", "y", "z")),
            quaternion=self._quaternions(c.numbers("a", "b", "c", "d")),
            via=_in_si(c.numbers("via_x", "via_y", "via_z")), feed=once(c.number("feed") * 1e-3),
            zone=once(c.number("zone") * 1e-3), mark=mark, sources=sources,
            joints=self.joints, frames=frames, tools=self.tools, events=tuple(self.events), external=self._external(),
            carried=self.carried,
        )  # fmt: skip


def _in_si(numbers: Floats) -> Floats:
    """m of mm, in their place."""
    if numbers.flags.writeable:
        numbers *= 1e-3
    return numbers
