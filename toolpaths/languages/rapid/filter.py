"""RAPID in place: other numbers in the robtargets of MoveL and MoveC, everything else as it was."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from toolpaths.columns import give_back
from toolpaths.errors import WriteError
from toolpaths.finding import merged
from toolpaths.interpreting.program_text import Declaration
from toolpaths.interpreting.robot_moves import ARC, RobotMoves
from toolpaths.languages.rapid.interpreter import RapidInterpreter
from toolpaths.languages.rapid.moves import EXTERNAL, LITERAL
from toolpaths.languages.rapid.reader import run_of
from toolpaths.languages.rapid.writer import confdata
from toolpaths.rewriting.edits import Edit, MadeFiles, edited_parts, line_end, newline_of, parts_to_write, respelled
from toolpaths.rewriting.filter import Filter, Rewritten, calls_elsewhere
from toolpaths.rewriting.target_edits import TargetEdits
from toolpaths.rotation import quaternion_from_matrix
from toolpaths.writing.marker import marked
from toolpaths.writing.program import Floats, Program

_NAME_LIMIT = 32
_TAIL = re.compile(r"(\s*,[^,\[]*,\s*)([^,\\\s]+)")
_TIMED = re.compile(r"\\\s*T\s*:=", re.I)


def rewrite(
    source: bytes, program: Program, row: Floats, path: Path, others: Sequence[Path] | None = None
) -> Rewritten:
    """``source`` and the modules it needs, with the poses of ``program`` (in the toolpath's work object) at ``row``.

    Raises:
        WriteError: a line would need two poses, or a timed move another one beside it.
    """
    run = run_of(source, str(path), path, others)
    run.program.forget_routines()
    moves = run.track.moves()
    give_back()
    spelling = RapidSpelling(run, moves)
    target_edits = TargetEdits(spelling, moves, program, row)
    target_edits.place()
    found = [*target_edits.changes, *calls_elsewhere(run.elsewhere)]
    modules, begins = run.program.modules, run.program.begins
    files = [Path(module.source) for module in modules]
    written = parts_to_write(begins, moves.mark["start"], target_edits.kept)

    def made(k: int) -> bytes:
        """The text of a module as it becomes."""
        begin, text = begins[k], run.program.text_of(k)
        at = begin + line_end(text, modules[k].body_at)
        mark = Edit(at, at, f"  ! {marked(program.stamp)}{spelling.newline}")
        (new,) = edited_parts([text], [begin], [mark, *target_edits.edits(begin, begin + len(text) + 1)])
        return new.encode("latin-1")

    beside = MadeFiles([files[k].name for k in written[1:]], lambda number: made(written[1 + number]))
    kept = tuple(file for k, file in enumerate(files) if k not in written)
    return Rewritten(made(0), merged(found), beside or (), kept)


class RapidSpelling:
    """How RAPID spells poses and moves."""

    literal = LITERAL

    def __init__(self, run: RapidInterpreter, moves: RobotMoves) -> None:
        self.run, self.moves, self.program = run, moves, run.program
        self.newline = newline_of(self.program.text_of(0))

    def aggregate(self, move: int) -> str:
        """The robtarget of an expression, with its configuration and external axes."""
        conf, axes = self.run.mover.others[move]
        position = ",".join(f"{v:.4f}" for v in self.moves.position[move] * 1e3)
        turn = ",".join(f"{v:.8f}" for v in self.moves.quaternion[move])
        shown = ",".join("9E9" if v >= 8.9e9 else f"{v:.10g}" for v in axes)
        return f"[[{position}],[{turn}],[{','.join(f'{v:g}' for v in conf)}],[{shown}]]"

    def turns(self, rotation: Floats) -> Floats:
        """Quaternions."""
        return quaternion_from_matrix(rotation)

    def spelled(self, literal: re.Match[str], position: Sequence[float], turn: Sequence[float] | None) -> str:
        """Other numbers; the quaternion on the side of the old one, none of its digits where it stays."""
        if turn is None:
            return respelled(literal, position, (4, 4, 4))
        side = sum(float(old) * new for old, new in zip(literal.groups()[3:7], turn, strict=True))
        turn = turn if side >= 0.0 else [-v for v in turn]
        return respelled(literal, (*position, *turn), (4, 4, 4, 8, 8, 8, 8))

    def standing(self, literal: str, external: Mapping[str, float]) -> str:
        """Other values of eax_a ... eax_f."""
        for name, value in external.items():
            if match := LITERAL.fullmatch(literal):
                literal = respelled(match, (value,), (4,), 12 + EXTERNAL.index(name))
        return literal

    def branches_differ(self, nominal: Floats, commanded: Floats) -> npt.NDArray[np.bool_]:
        """Whether axis 1, 4 or 6 is in another quarter."""
        return np.asarray((_quarters(nominal) != _quarters(commanded)).any(axis=1))

    def configured(self, literal: str, nominal: Floats, commanded: Floats) -> str:
        """cf1, cf4 and cf6 where they are those of ``nominal``, but for whole turns."""
        old, new = _quarters(nominal[None])[0].tolist(), _quarters(commanded[None])[0].tolist()
        for group, was, now in zip((8, 9, 10), old, new, strict=True):
            match = LITERAL.fullmatch(literal)
            if match is not None and now != was and (float(match[group]) - was) % 4 == 0:
                literal = respelled(match, (float(match[group]) + now - was,), (0,), group)
        return literal

    def inserted(self, move: int, target: str) -> str:
        """MoveL with speed, tool and work object of the move; a stop point becomes the smallest fly-by zone."""
        mark = self.moves.mark
        tail = self.program.piece(int(mark["ref_end"][move]), int(mark["end"][move]))
        if _TIMED.search(tail):
            place = f"{self.moves.file(move)}:{int(mark['line'][move])}"
            raise WriteError(f"{place}: a move with \\T cannot be divided. Give it a speed instead")
        match = _TAIL.match(tail)
        if match and match[2].lower() == "fine":
            tail = tail[: match.start(2)] + "z0" + tail[match.end(2) :]
        return f"MoveL {target}{tail}"

    def straight(self, move: int) -> Iterator[Edit]:
        """MoveC becomes MoveL, the via point goes."""
        mark = self.moves.mark
        if mark["word"][move] == ARC:
            start = int(mark["start"][move])
            yield Edit(start + 4, start + 5, "L" if self.program.piece(start + 4, start + 5) == "C" else "l")
            yield Edit(int(mark["via_ref_start"][move]), int(mark["ref_start"][move]), "")

    def declared(self) -> Sequence[Declaration]:
        """All declared robtargets."""
        found = [d for d in self.run.program.declarations() if d.type == "robtarget"]
        return sorted(found, key=lambda d: d.start)

    def scope(self, target: Declaration) -> tuple[int, int]:
        """Its module where it is LOCAL, else all of them."""
        return self.run.program.scope(target)

    def free_name(self, name: str, taken: set[str]) -> str:
        """``p10`` -> ``p10_c1``, at most 32 characters."""
        for n in range(1, 1_000_000):
            suffix = f"_c{n}"
            if (new := name[: _NAME_LIMIT - len(suffix)] + suffix).upper() not in taken:
                return new
        raise WriteError(f"{self.run.program.source}: no free name for {name}")


def _quarters(joints: Floats) -> npt.NDArray[np.int64]:
    """(K, 3) cf1, cf4, cf6 of joint angles (K, 6) rad."""
    return confdata(joints, None)[:, :3]


FILTER = Filter(rewrite=rewrite)
