"""KRL in place: other numbers in the targets of LIN and CIRC, in a .src or its .dat, everything else as it was."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from toolpaths.errors import WriteError
from toolpaths.finding import merged
from toolpaths.interpreting.program_text import Declaration
from toolpaths.interpreting.robot_moves import ARC, RobotMoves
from toolpaths.languages.krl.expressions import POSE
from toolpaths.languages.krl.interpreter import KrlInterpreter
from toolpaths.languages.krl.moves import LITERAL, MOTION
from toolpaths.languages.krl.reader import run_of
from toolpaths.languages.krl.writer import status_and_turn
from toolpaths.rewriting.edits import Edit, edited_parts, line_end, newline_of, parts_to_write, respelled
from toolpaths.rewriting.filter import Filter, Rewritten, calls_elsewhere
from toolpaths.rewriting.target_edits import TargetEdits
from toolpaths.rotation import kuka_from_matrix
from toolpaths.writing.marker import marked
from toolpaths.writing.program import Floats, Program

_NAME_LIMIT = 24
_T = re.compile(r"(?<!\w)T\s+(\d{1,2})(?![\w.])", re.I)
_ROUNDED = re.compile(r"(?<!\w)C_\w+", re.I)


def rewrite(
    source: bytes, program: Program, row: Floats, path: Path, others: Sequence[Path] | None = None
) -> Rewritten:
    """``source`` and what it calls, with the poses of ``program`` (in the toolpath's base) at ``row``; their .dat too.

    Raises:
        WriteError: a line would need two poses.
    """
    run = run_of(source, str(path), path, others)
    modules, begins = run.program.modules, run.program.begins
    moves = run.track.moves()
    spelling = KrlSpelling(run, moves)
    target_edits = TargetEdits(spelling, moves, program, row)
    target_edits.place()
    edits = target_edits.edits()
    found = [*target_edits.changes, *calls_elsewhere(run.elsewhere)]
    texts, places = [], []  # of each .src and, behind it, its .dat
    for begin, module in zip(begins, modules, strict=True):
        texts += [module.text[: module.border], module.text[module.border + 1 :]]
        places += [begin, begin + module.border + 1]
    written = parts_to_write(begins, moves.mark["start"], edits)
    ends = (begins[k] + line_end(modules[k].text, modules[k].header_end) for k in written)
    marks = [Edit(at, at, f"; {marked(program.stamp)}{spelling.newline}") for at in ends]
    made = [text.encode("latin-1") for text in edited_parts(texts, places, [*marks, *edits])]
    beside = [(Path(modules[0].beside).suffix, made[1])] if modules[0].beside else []
    for k in written[1:]:
        beside.append((Path(modules[k].source).name, made[2 * k]))
        beside += [(Path(modules[k].beside).name, made[2 * k + 1])] if modules[k].beside else []
    kept = tuple(Path(modules[k].source) for k in range(len(modules)) if k not in written)
    return Rewritten(made[0], merged(found), tuple(beside), kept)


class KrlSpelling:
    """How KRL spells poses and moves."""

    literal = LITERAL

    def __init__(self, run: KrlInterpreter, moves: RobotMoves) -> None:
        self.run, self.moves, self.program, self.text = run, moves, run.program, run.program.text
        self.newline = newline_of(self.text)
        self._angles = np.degrees(kuka_from_matrix(_matrices(moves.quaternion)))

    def aggregate(self, move: int) -> str:
        """The target of an expression, with S, T and external axes where it has them."""
        value = self.run.mover.others.get(move, {})
        numbers = [*(self.moves.position[move] * 1e3).tolist(), *self._angles[move].tolist()]
        parts = [f"{k} {v:.5f}" for k, v in zip(POSE, numbers, strict=True)]
        more = [k for k in ("S", "T", "E1", "E2", "E3", "E4", "E5", "E6") if isinstance(value.get(k), float)]
        return "{" + ",".join([*parts, *(f"{k} {value[k]:g}" for k in more)]) + "}"

    def turns(self, rotation: Floats) -> Floats:
        """A, B, C deg."""
        return np.degrees(kuka_from_matrix(rotation))

    def spelled(self, literal: re.Match[str], position: Sequence[float], turn: Sequence[float] | None) -> str:
        """Other numbers; of the two ways to spell a turn the one near the old angles."""
        if turn is None:
            return respelled(literal, position, (4, 4, 4))
        near = _near(turn, [float(v) for v in literal.groups()[3:6]])
        return respelled(literal, (*position, *near), (4, 4, 4, 6, 6, 6))

    def standing(self, literal: str, external: Mapping[str, float]) -> str:
        """Other values of E1 ... E6."""
        for name, value in external.items():
            if match := re.search(rf"(?<!\w){name}\s+([-+]?[0-9.]+(?:[eE][-+]?\d+)?)", literal, re.I):
                literal = literal[: match.start()] + respelled(match, (value,), (4,)) + literal[match.end() :]
        return literal

    def branches_differ(self, nominal: Floats, commanded: Floats) -> npt.NDArray[np.bool_]:
        """Whether an axis has another sign."""
        return np.asarray(_turn(nominal) != _turn(commanded))

    def configured(self, literal: str, nominal: Floats, commanded: Floats) -> str:
        """T, in the bits that are those of ``nominal``."""
        match = _T.search(literal)
        if match is None:
            return literal
        said, old, new = int(match[1]), int(_turn(nominal[None])[0]), int(_turn(commanded[None])[0])
        changed = (old ^ new) & ~(said ^ old)
        return f"{literal[: match.start(1)]}{said ^ changed}{literal[match.end(1) :]}"

    def inserted(self, move: int, target: str) -> str:
        """LIN (or SLIN) with what stands behind the move; fly-by where the move stops."""
        mark = self.moves.mark
        start = int(mark["start"][move])
        tail = self.text[int(mark["ref_end"][move]) : int(mark["end"][move])].rstrip()
        spline = self.text[start : start + 5].upper() in ("SLIN ", "SCIRC", "SLIN{")
        if not _ROUNDED.search(tail):
            tail = f"{tail} C_SPL" if spline else f" C_DIS{tail}"
        return f"{'SLIN' if spline else 'LIN'} {target}{tail}"

    def straight(self, move: int) -> Iterator[Edit]:
        """CIRC and LIN_REL become LIN, the via point goes."""
        mark = self.moves.mark
        start, end = int(mark["start"][move]), int(mark["end"][move])
        word = MOTION.match(self.text, start, end)
        if word and word[1].upper() not in ("LIN", "SLIN"):
            yield Edit(start, word.end(), "SLIN" if word[1].upper().startswith("S") else "LIN")
            frame = re.compile(r"(?<!\s)\s*+#(?:BASE|TOOL)", re.I).search(self.text, start, end)
            if word[1].upper().endswith("_REL") and frame:
                yield Edit(frame.start(), frame.end(), "")
        if mark["word"][move] == ARC:
            yield Edit(int(mark["via_ref_start"][move]), int(mark["ref_start"][move]), "")

    def declared(self) -> Sequence[Declaration]:
        """All declared poses."""
        found = [d for module in self.run.program.declared for d in module.values() if d.value[0] >= 0]
        return sorted(found, key=lambda d: d.start)

    def scope(self, target: Declaration) -> tuple[int, int]:
        """Its module; all of them where it is GLOBAL."""
        return self.run.program.scope(target)

    def free_name(self, name: str, taken: set[str]) -> str:
        """``XP2`` -> ``XP2_C1``, at most 24 characters."""
        for n in range(1, 1_000_000):
            suffix = f"_C{n}"
            if (new := name[: _NAME_LIMIT - len(suffix)] + suffix).upper() not in taken:
                return new
        raise WriteError(f"{self.run.program.source}: no free name for {name}")


def _near(angles: Sequence[float], old: Sequence[float]) -> list[float]:
    """A, B, C deg of the same turn, as near to ``old`` as whole turns and the other spelling allow."""
    a, b, c = angles
    ways = [
        [v - 360.0 * round((v - was) / 360.0) for v, was in zip(way, old, strict=True)]
        for way in ((a, b, c), (a + 180.0, 180.0 - b, c + 180.0))
    ]
    return min(ways, key=lambda way: max(abs(v - was) for v, was in zip(way, old, strict=True)))


def _matrices(quaternion: Floats) -> Floats:
    from toolpaths.rotation import matrix_from_quaternion

    known = np.where(np.isfinite(quaternion), quaternion, np.array([1.0, 0.0, 0.0, 0.0]))
    return matrix_from_quaternion(known)


def _turn(joints: Floats) -> npt.NDArray[np.int64]:
    """(K,) T of joint angles (K, 6) rad."""
    return status_and_turn(joints, np.zeros(len(joints), dtype=np.int32))[1]


FILTER = Filter(rewrite=rewrite)
