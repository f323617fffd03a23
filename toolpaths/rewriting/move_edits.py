"""MoveEdits: edits of a program whose filter changes whole moves, for languages that number or nest their poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolpaths.finding import NOTE, Finding
from toolpaths.interpreting.robot_moves import ARC, RobotMoves
from toolpaths.rewriting.arc_fit import ProgramArcs
from toolpaths.rewriting.corrections import Correction
from toolpaths.rewriting.edits import Edit
from toolpaths.writing.program import Floats, Program

_EVEN = 1e-6


class MoveEdits:
    """What changes in one file.

    Args:
        text: of the file, one character a byte.
        row: of the poses of ``program``.

    Attributes:
        eol: a line end of the file.
        edits, changes: as in Rewritten, filled by the language.
    """

    def __init__(self, text: str, moves: RobotMoves, program: Program, row: Floats, path: Path) -> None:
        self.text, self.moves, self.program, self.row, self.path = text, moves, program, row, path
        self.eol = "\r\n" if "\r\n" in text else "\n"
        self.edits: list[Edit] = []
        self.changes: list[Finding] = []
        self._arcs = ProgramArcs(moves, program, row)

    def span(self, move: int, first: str, last: str) -> tuple[int, int]:
        """Two places of a move, by their names in MARKS."""
        return int(self.moves.mark[first][move]), int(self.moves.mark[last][move])

    def is_arc(self, move: int) -> bool:
        """Whether the move is an arc."""
        return bool(self.moves.mark["word"][move] == ARC)

    def line(self, move: int) -> int:
        """The line of a move in the file."""
        return int(self.moves.mark["line"][move])

    def note(self, move: int, what: str, count: int = 1) -> None:
        """Say what else than numbers changed at a move."""
        self.changes.append(
            Finding(level=NOTE, place=f"{self.path.name}:{self.line(move)}", what=what, remedy="", count=count)
        )

    def via_point(self, c: Correction) -> Floats | None:
        """The point (3,) m, in the move's frame, that a corrected arc has to pass; None where it can be no arc.

        Poses put in besides those that stand for the roundness (these are evenly spaced) are there because something
        changes at them.
        """
        poses = np.array([c.poses[0] - 1, *c.poses])
        if len(c.poses) < 2 or poses[0] < 0 or abs(self.row[poses[0]] - (c.move - 1)) > _EVEN:
            return None
        share = self.row[poses] - self.row[poses[0]]
        if np.abs(share - np.linspace(0.0, 1.0, len(poses))).max() > _EVEN:
            return None
        found = self._arcs.via(c.move, poses)
        return None if found is None else found[0]
