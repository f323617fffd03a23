"""TargetEdits: edits of a program whose moves give or name targets one by one, as KRL and RAPID do.

A language gives its ``Spelling``.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from toolpaths.columns import blocks
from toolpaths.errors import WriteError
from toolpaths.finding import NOTE, Finding
from toolpaths.interpreting.program_text import Declaration
from toolpaths.interpreting.robot_moves import ARC, RobotMoves
from toolpaths.rewriting.arc_fit import ProgramArcs
from toolpaths.rewriting.edits import Edit
from toolpaths.rewriting.filter import SAME_PLACE, SAME_TURN
from toolpaths.rewriting.spelling import Spelling
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.toolpath import CUT
from toolpaths.writing.program import Floats, Program

_ROW = 1e-9


@dataclass
class _Use:
    """A target that a statement gives or names: numbers as wanted, line, and where it is named."""

    wanted: str
    move: int
    reference: tuple[int, int]


@dataclass
class TargetEdits:
    """Edits and findings of one program.

    Args:
        program: commanded poses in the main frame of ``moves``.
        row: of each pose.
    """

    spelling: Spelling
    moves: RobotMoves
    program: Program
    row: Floats
    changes: list[Finding] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._text = self.spelling.program
        whole = np.abs(self.row - (nearest := np.rint(self.row))) < _ROW
        self._at = np.full(len(self.moves), -1, dtype=np.int32)
        inside = whole & (nearest >= 0) & (nearest < len(self.moves))
        self._at[nearest[inside].astype(np.intp)] = np.flatnonzero(inside)
        self._between: dict[int, list[int]] = {}
        for k in np.flatnonzero(~whole).tolist():
            self._between.setdefault(int(np.ceil(self.row[k])), []).append(k)
        self._work_out_poses()
        self._edits: list[Edit] = []
        self._plain = self.moves.given_once  # those that only they need, with its numbers in the statement
        self._later = np.zeros(len(self.moves), dtype=bool)  # of these the ones that get other numbers
        self._uses: dict[tuple[int, int], dict[int, _Use]] = {}  # place of the numbers -> place of naming -> use
        self._lines, self._straight = dict[int, str](), set[int]()  # statement -> lines put in before it

    def _work_out_poses(self) -> None:
        """What ``spelled`` takes, for all poses: each in the frame of the move that it belongs to."""
        count, self._frames = len(self.row), self.moves.from_main()
        self._move = np.clip(np.ceil(self.row - _ROW), 0, len(self.moves) - 1).astype(np.int32)
        self._turned, self._other, self._other_branch = (np.zeros(count, dtype=bool) for _ in range(3))
        self._block, self._own = slice(0, 0), (np.empty((0, 3)), np.empty((0, 4)))
        for b in blocks(count):
            self._in_own_frame(b)

    def _place_and_turn(self, k: int) -> tuple[list[float], list[float]]:
        """Numbers of a pose; they are made for some poses in a row, which is the order that they are asked for in."""
        if not self._block.start <= k < self._block.stop:
            self._block = next(b for b in blocks(len(self.row)) if b.start <= k < b.stop)
            position, rotation = self._in_own_frame(self._block)
            self._own = position, self.spelling.turns(rotation)
        place, turn = (numbers[k - self._block.start].tolist() for numbers in self._own)
        return place, turn

    def _in_own_frame(self, b: slice) -> tuple[Floats, Floats]:
        """Some poses, (K, 3) mm and (K, 3, 3), looked at: which are others than the file has."""
        move, moves = self._move[b], self.moves
        position, rotation = self.program.position[b].copy(), self.program.rotation[b].copy()
        for number, main in enumerate(self._frames):
            mine = moves.mark["frame"][move] == number
            if mine.any():
                position[mine] = main.at(position[mine])
                rotation[mine] = main.rotation @ rotation[mine]
        off = np.linalg.norm(position - moves.position[move], axis=1)
        with np.errstate(invalid="ignore"):  # moves to joint angles have no pose
            turned = np.abs(rotation - matrix_from_quaternion(moves.quaternion[move])).max(axis=(1, 2)) > SAME_TURN
        self._turned[b], self._other[b] = turned, turned | (off > SAME_PLACE)
        nominal, end = self.program.nominal_joints, self._at[move]
        if nominal is not None and nominal.shape[1] == 6:
            differ = self.spelling.branches_differ(nominal[np.maximum(end, 0)], self.program.joints[b])
            self._other_branch[b] = differ & (end >= 0)
        return position * 1e3, rotation

    def place(self) -> None:
        """Find all edits.

        Raises:
            WriteError: one line would need two poses.
        """
        cutting = np.flatnonzero(self.moves.mark["kind"] == CUT)
        missing = cutting[self._at[cutting] < 0]
        if len(missing):
            raise WriteError(f"{self._line(int(missing[0]))}: no pose was worked out for this move")
        arcs = self.moves.mark["word"][cutting] == ARC
        if arcs.any():
            self._arcs = ProgramArcs(self.moves, self.program, self.row)
        for r, other, arc in zip(cutting.tolist(), self._other[self._at[cutting]].tolist(), arcs.tolist(), strict=True):
            if arc:
                self._arc(r, other)
            else:
                self._line_move(r, other)
        for place, uses in self._uses.items():
            self._settle(place, uses)

    @property
    def kept(self) -> Sequence[Edit]:
        """Those that are more than other numbers in a statement."""
        return self._edits

    def edits(self, first: int = 0, end: int | None = None) -> list[Edit]:
        """Those from one place of the text up to another, once ``place`` has found them; those that only other numbers
        make are made here: of a million moves they are not kept."""
        end = self._text.length + 1 if end is None else end
        start = self.moves.mark["target_start"]
        rows = np.flatnonzero(self._later & (start >= first) & (start < end)).tolist()
        made = (self._renumbered(r) for r in rows)
        return [*(e for e in self._edits if first <= e.start < end), *(e for e in made if e is not None)]

    def _renumbered(self, r: int) -> Edit | None:
        literal = self._literal(r)
        new = self._spelled(literal, int(self._at[r]))
        start, end = (int(self.moves.mark[f"target_{end}"][r]) for end in ("start", "end"))
        return Edit(start, end, new) if new != literal[0] else None

    def _line(self, r: int) -> str:
        return f"{self.moves.file(r)}:{int(self.moves.mark['line'][r])}"

    def _note(self, r: int, what: str, count: int = 1) -> None:
        inside = self.moves.file(r) == self.moves.source
        line = f"line {int(self.moves.mark['line'][r])}" if inside else self._line(r)
        self.changes.append(Finding(NOTE, line, what, "", count=count))

    def _spelled(self, literal: re.Match[str], k: int) -> str:
        position, turn = self._place_and_turn(k)
        out = self.spelling.spelled(literal, position, turn if self._turned[k] else None)
        if self._other_branch[k] and (nominal := self.program.nominal_joints) is not None:
            end = max(int(self._at[self._move[k]]), 0)
            return self.spelling.configured(out, nominal[end], self.program.joints[k])
        return out

    def _literal(self, r: int, name: str = "target") -> re.Match[str]:
        match = self._numbers(r, name) or self.spelling.literal.fullmatch(self.spelling.aggregate(r))
        if match is None:
            raise WriteError(f"{self._line(r)}: this target cannot be written as numbers")
        return match

    def _numbers(self, r: int, name: str = "target") -> re.Match[str] | None:
        """The target as it stands, if that is numbers."""
        start, end = (int(self.moves.mark[f"{name}_{end}"][r]) for end in ("start", "end"))
        text, begin = self._text.around(start)
        return self.spelling.literal.fullmatch(text, start - begin, end - begin)

    def _line_move(self, r: int, other: bool) -> None:
        between = self._between.get(r)
        if between:
            self._insert(r, between, self._literal(r))
        if self._plain[r] and (not other or self._numbers(r)):
            self._later[r] = other
            return
        self._use(r, self._spelled(self._literal(r), int(self._at[r])) if other else None, "target")

    def _insert(self, r: int, between: list[int], literal: re.Match[str]) -> None:
        if not between:
            return
        start = int(self.moves.mark["start"][r])
        poses = [self._standing(r, k, self._spelled(literal, k)) for k in between]
        lines = [self.spelling.inserted(r, pose) for pose in poses]
        indent = re.match(r"[ \t]*", self._text.line_before(start))
        text = "".join(line + self.spelling.newline + (indent[0] if indent else "") for line in lines)
        if start in self._lines:
            if self._lines[start] != text:
                raise WriteError(f"{self._line(r)}: this line runs several times, with different poses: write it out")
            return
        self._lines[start] = text
        self._edits.append(Edit(start, start, text))
        self._note(r, "poses put in before the move", len(between))

    def _standing(self, r: int, k: int, pose: str) -> str:
        """The pose with external axes where they are on the way: they move evenly, together with the TCP."""
        share, stands = float(self.row[k]) - (r - 1), dict[str, float]()
        for name, values in self.moves.external.items():
            a, b = float(values[r - 1]) if r else np.nan, float(values[r])
            known = values[np.isfinite(values)]
            if a == b or np.isnan(b) or (np.isnan(a) and (known == b).all()):
                continue
            if np.isnan(a):
                problem = f"poses have to be put in, but where {name} stands before the move is not known"
                raise WriteError(f"{self._line(r)}: {problem}. Give it in the move before")
            stands[name] = a + share * (b - a)
        return self.spelling.standing(pose, stands) if stands else pose

    def _use(self, r: int, wanted: str | None, name: str) -> None:
        """Note that a move needs ``wanted`` where its target (or via point) stands; None: what stands there."""
        mark, prefix = self.moves.mark, "ref" if name == "target" else "via_ref"
        place = int(mark[f"{name}_start"][r]), int(mark[f"{name}_end"][r])
        reference = int(mark[f"{prefix}_start"][r]), int(mark[f"{prefix}_end"][r])
        text = self._text.piece(*place)
        wanted = text if wanted is None else wanted
        seen = self._uses.setdefault(place, {}).setdefault(reference[0], _Use(wanted, r, reference))
        if seen.wanted != wanted:
            raise WriteError(f"{self._line(r)}: this line runs several times, with different poses: write it out")

    def _arc(self, r: int, other: bool) -> None:
        between = self._between.get(r, [])
        first = int(self._at[r - 1])
        poses = np.array([first, *between, int(self._at[r])])
        corrected = self._arcs.via(r, poses) if first >= 0 else None
        if corrected is None:
            self._insert(r, between, self._literal(r))
            self._make_straight(r)
            self._note(r, "an arc became short lines")
        else:
            via, moved = corrected
            numbers: list[float] = (via * 1e3).tolist()
            self._use(r, self.spelling.spelled(self._literal(r, "via"), numbers, None) if moved else None, "via")
        self._use(r, self._spelled(self._literal(r), int(self._at[r])) if other else None, "target")

    def _make_straight(self, r: int) -> None:
        start = int(self.moves.mark["start"][r])
        if start not in self._straight:
            self._straight.add(start)
            self._edits += self.spelling.straight(r)

    def _settle(self, place: tuple[int, int], uses: dict[int, _Use]) -> None:
        """One pose in the text and all moves that take it."""
        text = self._text.piece(*place)
        first = next(iter(uses.values()))
        if place[0] == first.reference[0]:  # it stands in the move itself
            if first.wanted != text:
                self._edits.append(Edit(*place, first.wanted))
                if not self.spelling.literal.fullmatch(text):
                    if self.moves.mark["word"][first.move] != ARC:  # a relative move becomes an absolute one
                        self._make_straight(first.move)
                    self._note(first.move, f"{' '.join(text.split())[:40]} became numbers")
            return
        kept = {u.wanted for u in uses.values()}
        if kept == {text}:
            return
        target = self._declaration(place[0])
        stays = text if self._others(target, len(uses)) or text in kept else first.wanted
        if stays != text:
            self._edits.append(Edit(*place, stays))
        self._split(target, place, stays, uses)

    def _split(self, target: Declaration, place: tuple[int, int], stays: str, uses: dict[int, _Use]) -> None:
        names: dict[str, str] = {}
        for use in uses.values():
            if use.wanted == stays:
                continue
            if use.wanted not in names:
                name = names[use.wanted] = self.spelling.free_name(target.name, self._taken)
                self._taken.add(name.upper())
                self._declare(target, place, name, use.wanted)
                self._note(use.move, f"{target.name} is used by several moves: {name} was declared beside it")
            self._edits.append(Edit(*use.reference, names[use.wanted]))

    def _declare(self, target: Declaration, place: tuple[int, int], name: str, wanted: str) -> None:
        head = self._text.line_before(target.start) + self._text.piece(target.start, place[0])
        head = re.sub(rf"(?<![\w$]){re.escape(target.name)}(?![\w$])", name, head, count=1)
        at, tail = self._text.line_end(target.end), self._text.piece(place[1], target.end)
        self._edits.append(Edit(at, at, self.spelling.newline + head + wanted + tail))

    def _declaration(self, at: int) -> Declaration:
        if not hasattr(self, "_targets"):
            self._targets, self._counts = list(self.spelling.declared()), dict[tuple[int, int], Counter[str]]()
            self._starts = np.array([d.start for d in self._targets])
            self._taken = set(self._text.words(0, self._text.length))
        return self._targets[int(np.searchsorted(self._starts, at, side="right")) - 1]

    def _others(self, target: Declaration, uses: int) -> bool:
        """Whether something else than these uses names the target: rapids, Offs(...), other routines."""
        scope = self.spelling.scope(target)
        if scope not in self._counts:
            self._counts[scope] = Counter(self._text.words(*scope))
        return self._counts[scope][target.name.upper()] - 1 > uses
