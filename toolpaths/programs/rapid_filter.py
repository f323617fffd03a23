"""RAPID in place: other numbers in the robtargets of MoveL and MoveC, everything else as it was."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.programs.program import Floats, Program, merged
from toolpaths.programs.rewriting import MARKER, SAME_TURN, Edit, Rewritten, edited
from toolpaths.programs.robot_rewrite import Declared, Placing, line_end, newline_of, respelled
from toolpaths.readers.rapid import run_of
from toolpaths.readers.rapid_moves import LITERAL
from toolpaths.readers.rapid_run import Run
from toolpaths.readers.robot_moves import ARC, RobotMoves
from toolpaths.rotation import matrix_from_quaternion, quaternion_from_matrix

_NAME_LIMIT = 32
_TAIL = re.compile(r"(\s*,[^,\[]*,\s*)([^,\\\s]+)")
_TIMED = re.compile(r"\\\s*T\s*:=", re.I)


def rewrite(source: bytes, program: Program, row: Floats, path: Path) -> Rewritten:
    """``source`` with the poses of ``program`` (in the toolpath's work object) at ``row``.

    Raises:
        WriteError: a line would need two poses, or a timed move another one beside it.
    """
    run = run_of(source, str(path))
    moves = run.track.moves()
    style = RapidStyle(run, moves)
    placing = Placing(style, moves, program, row)
    placing.place()
    at = line_end(run.text, run.module.body_at)
    marker = Edit(at, at, f"  ! {MARKER}{style.newline}")
    text = edited(run.text, [marker, *placing.edits])
    return Rewritten(text.encode("latin-1"), merged(placing.changes))


class RapidStyle:
    """How RAPID spells poses and moves."""

    literal = LITERAL

    def __init__(self, run: Run, moves: RobotMoves) -> None:
        self.run, self.moves, self.text = run, moves, run.text
        self.newline = newline_of(run.text)

    def aggregate(self, move: int) -> str:
        """The robtarget of an expression, with its configuration and external axes."""
        conf, axes = self.run.mover.others[move]
        position = ",".join(f"{v:.4f}" for v in self.moves.position[move] * 1e3)
        turn = ",".join(f"{v:.8f}" for v in self.moves.quaternion[move])
        shown = ",".join("9E9" if v >= 8.9e9 else f"{v:.10g}" for v in axes)
        return f"[[{position}],[{turn}],[{','.join(f'{v:g}' for v in conf)}],[{shown}]]"

    def spelled(self, literal: str, position: Floats, rotation: Floats | None) -> str:
        """Other numbers; the quaternion on the side of the old one, none of its digits where it stays."""
        match = LITERAL.fullmatch(literal)
        if match is None:
            raise WriteError(f"{self.run.source}: {literal[:60]!r} is no robtarget")
        values, digits = [float(v) for v in position * 1e3], [4, 4, 4]
        if rotation is not None:
            old = np.array([float(match[k]) for k in range(4, 8)])
            if np.abs(rotation - matrix_from_quaternion(old)).max() > SAME_TURN:
                new = quaternion_from_matrix(rotation)
                values += (new if new @ old >= 0.0 else -new).tolist()
                digits += [8] * 4
        return respelled(literal, match, values, digits)

    def inserted(self, move: int, target: str) -> str:
        """MoveL with speed, tool and work object of the move; a stop point becomes the smallest fly-by zone."""
        mark = self.moves.mark
        tail = self.text[int(mark["ref_end"][move]) : int(mark["end"][move])]
        if _TIMED.search(tail):
            line = int(mark["line"][move])
            raise WriteError(f"{self.run.source}:{line}: a move with \\T cannot be divided. Give it a speed instead")
        match = _TAIL.match(tail)
        if match and match[2].lower() == "fine":
            tail = tail[: match.start(2)] + "z0" + tail[match.end(2) :]
        return f"MoveL {target}{tail}"

    def straight(self, move: int) -> Iterator[Edit]:
        """MoveC becomes MoveL, the via point goes."""
        mark = self.moves.mark
        if mark["word"][move] == ARC:
            start = int(mark["start"][move])
            yield Edit(start + 4, start + 5, "L" if self.text[start + 4] == "C" else "l")
            yield Edit(int(mark["via_ref_start"][move]), int(mark["ref_start"][move]), "")

    def declared(self) -> Sequence[Declared]:
        """All declared robtargets."""
        found = [d for d in self.run.module.data.values() if d.type == "robtarget"]
        return sorted((Declared(d.name, d.start, d.end) for d in found), key=lambda d: d.start)

    def free_name(self, name: str, taken: set[str]) -> str:
        """``p10`` -> ``p10_c1``, at most 32 characters."""
        for n in range(1, 1_000_000):
            suffix = f"_c{n}"
            if (new := name[: _NAME_LIMIT - len(suffix)] + suffix).upper() not in taken:
                return new
        raise WriteError(f"{self.run.source}: no free name for {name}")
