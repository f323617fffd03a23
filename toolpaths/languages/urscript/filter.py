"""Filter in place of URScript: the poses of cutting moves get new numbers, all else stays byte by byte.

A pose that several moves use is written into each; poses put in become moves like the one they lead to; an arc that is
no arc any more becomes movels; blend radii shrink where the segments beside them did, since overlapping blends are
skipped by the controller.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.finding import merged
from toolpaths.frame import Frame
from toolpaths.interpreting.robot_moves import RobotMoves
from toolpaths.languages.urscript.moves import PARAMETERS
from toolpaths.languages.urscript.reader import moves_of
from toolpaths.rewriting.corrections import Correction, angles_of, corrections
from toolpaths.rewriting.edits import Edit, edited
from toolpaths.rewriting.filter import Filter, Rewritten
from toolpaths.rewriting.move_edits import MoveEdits
from toolpaths.rotation import ur_from_matrix
from toolpaths.writing.blending import CUT_TOLERANCE
from toolpaths.writing.marker import marked, refuse_compensated
from toolpaths.writing.numbers import number
from toolpaths.writing.program import Floats, Program

_NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_HEAD = re.compile(r"^([ \t]*)def\b[^\r\n]*(\r\n|\r|\n)([ \t]*)", re.M)
#: Share of the shorter segment that a blend may take: half of it is where two blends touch.
_SHARE = 0.4


def rewrite(source: bytes, program: Program, row: Floats, path: Path) -> Rewritten:
    """The .script ``source`` with the poses of ``program``."""
    refuse_compensated(source, str(path))
    moves = moves_of(source, str(path))
    work = _Work(text=source.decode("latin-1"), moves=moves, program=program, row=row, path=path)
    for c in work.found:
        work.move(c)
    return Rewritten(work.text_out().encode("latin-1"), merged(work.changes))


class _Work(MoveEdits):
    """Edits of one .script."""

    def __init__(self, text: str, moves: RobotMoves, program: Program, row: Floats, path: Path) -> None:
        super().__init__(text=text, moves=moves, program=program, row=row, path=path)
        self.limited: set[int] = set()
        self.found = corrections(moves, program, row)
        self.vectors = angles_of(self.found, len(program), ur_from_matrix)
        self.way, self.fly = _radii(program.position)
        self.uses = Counter(moves.mark["target_start"].tolist())
        self.runs = Counter(moves.mark["start"].tolist())

    def move(self, c: Correction) -> None:
        """The edits of one move."""
        start, end = self.span(c.move, "start", "end")
        if self.runs[start] > 1:
            problem = f"{self._place(c.move)}: this move runs more than once, and would need other poses each time"
            raise WriteError(f"{problem}. Write the function's moves out where it is called")
        arc = self.is_arc(c.move)
        via = self.via_point(c) if arc else None
        if via is not None:
            self._through(c, via, start, end)
            if c.moved:
                self._end(c, start, end)
            return
        if len(c.poses) > 1:
            if np.isnan(self.moves.feed[c.move]):
                raise WriteError(f"{self._place(c.move)}: a move by time cannot be divided. Give it v instead of t")
            self.note(c.move, "an arc became straight lines" if arc else "poses were put in", len(c.poses) - 1)
        indent = self.text[self.text.rfind("\n", 0, start) + 1 : start]
        lines = [indent + self._like(c, k) + self.eol for k in range(len(c.poses) - 1)]
        if lines:
            self.edits.append(Edit(start - len(indent), start - len(indent), "".join(lines)))
            self._limit_before(c)
        if arc:
            self.limited.add(start)
            self.edits.append(Edit(start, end, self._like(c, len(c.poses) - 1)))
            return
        if c.moved:
            self._end(c, start, end)
        if lines:
            self._limit(c.move, float(self.way[c.poses[-1]]))

    def text_out(self) -> str:
        """The file with its edits and the marker behind the first def."""
        head = _HEAD.search(self.text)
        at = head.end(2) if head else 0
        marker = Edit(at, at, f"{head[3] if head else ''}# {marked(self.program.stamp)}{self.eol}")
        return edited(self.text, [marker, *self.edits])

    def _end(self, c: Correction, start: int, end: int) -> None:
        """New numbers for the pose that the move has; where others use it, too, its own pose in the move."""
        target = self.span(c.move, "target_start", "target_end")
        if target[0] >= 0 and (self.uses[target[0]] == 1 or start <= target[0] < end):
            literal = self._literal(self.text[slice(*target)], c.pose.origin[-1], self.vectors[c.poses[-1]])
            self.edits.append(Edit(*target, literal))
            return
        self.note(c.move, "a pose that other moves use, too, or that is computed, was written into the move", 1)
        first, last = self._arguments(self.text[start:end])[int(self.is_arc(c.move))]
        self.edits.append(Edit(start + first, start + last, self._in_base(c, len(c.poses) - 1)))

    def _through(self, c: Correction, via: Floats, start: int, end: int) -> None:
        """The point ``via`` (3,) m as what an arc passes. Its turn is not used: that of a pose in the move stays."""
        first, last = self._arguments(self.text[start:end])[0]
        given = (start + first, start + last)
        if given != self.span(c.move, "via_start", "via_end"):
            self.note(c.move, "a pose that other moves use, too, or that is computed, was written into the move", 1)
            passed = replace(c, pose=Frame(c.pose.rotation[-1:], np.array([via])), poses=c.poses[-1:])
            self.edits.append(Edit(*given, self._in_base(passed, 0)))
            return
        old = self.text[slice(*given)]
        vector = np.array([float(m[0]) for m in _NUMBER.finditer(old)][3:])
        self.edits.append(Edit(*given, self._literal(old, self._frame(c).at(via), vector)))

    def _place(self, move: int) -> str:
        return f"{self.path.name}:{self.line(move)}"

    def _like(self, c: Correction, k: int) -> str:
        """A move like this one to pose ``k``; an arc's as a movel."""
        start, end = self.span(c.move, "start", "end")
        statement = self.text[start:end]
        spans = self._arguments(statement)
        target = self.span(c.move, "target_start", "target_end")
        arc = self.is_arc(c.move)
        first, last = spans[1 if arc else 0]
        if start + first <= target[0] < start + last:
            inside = slice(target[0] - start, target[1] - start)
            literal = self._literal(statement[inside], c.pose.origin[k], self.vectors[c.poses[k]])
            pose = statement[first : inside.start] + literal + statement[inside.stop : last]
        else:
            pose = self._in_base(c, k)
        radius = float(self.fly[c.poses[k]])
        if k == len(c.poses) - 1:
            room = self.way[c.poses[k] : c.poses[k] + 2].min()  # of an arc: nobody else looks at what comes behind it
            radius = min(float(room), float(self.moves.zone[c.move]))
        texts = [statement[a:b] for a, b in spans]
        if arc:
            named = self._named("movec", texts)
            rest = "".join(f", {n}={named[n]}" for n in ("a", "v") if n in named)
            return f"movel({pose}{rest}, r={_radius(radius)})"
        at = _radius_argument(texts, statement)
        head = statement[:first] + pose
        if at is None:
            return head + statement[last : statement.rindex(")")] + f", r={_radius(radius)})"
        a, b = spans[at]
        return head + statement[last:a] + _with_radius(statement[a:b], radius) + statement[b:]

    def _named(self, word: str, texts: list[str]) -> dict[str, str]:
        """Arguments of a move by name."""
        out = {}
        for name, text in zip(PARAMETERS[word], texts, strict=False):
            key, sign, value = text.partition("=")
            out[key.strip() if sign else name] = value.strip() if sign else text.strip()
        return out

    def _arguments(self, statement: str) -> list[tuple[int, int]]:
        """Places of the arguments of a call."""
        at, depth, out = statement.index("(") + 1, 0, []
        start = at
        for i in range(at, len(statement)):
            c = statement[i]
            if depth == 0 and c in ",)":
                out.append(_stripped(statement, start, i))
                start = i + 1
                if c == ")":
                    break
            depth += (c in "([") - (c in ")]")
        return out

    def _in_base(self, c: Correction, k: int) -> str:
        """Pose ``k`` as a literal in the base frame."""
        frame = self._frame(c)
        vector = ur_from_matrix(frame.rotation @ c.pose.rotation[k])
        target = self.span(c.move, "target_start", "target_end")
        plain = target[0] >= 0 and np.array_equal(frame.rotation, np.eye(3))
        old = _NUMBER.findall(self.text[slice(*target)]) if plain else []
        turned = _nearest(vector.tolist(), [float(v) for v in old[3:]]) if len(old) == 6 else vector.tolist()
        values = [*frame.at(c.pose.origin[k]).tolist(), *turned]
        return "p[" + ", ".join(f"{round(v, 8) + 0.0:.8f}" for v in values) + "]"

    def _frame(self, c: Correction) -> Frame:
        """The move's frame in the base."""
        return self.moves.frames[int(self.moves.mark["frame"][c.move])] or Frame.identity()

    def _literal(self, old: str, position: Floats, vector: Floats) -> str:
        """The literal ``p[...]`` with other numbers; no fewer digits, and the vector next to the one that was."""
        found = list(_NUMBER.finditer(old))
        before = [float(m[0]) for m in found]
        near = _nearest(vector.tolist(), before[3:])
        pieces, at = [], 0
        for i, (m, value) in enumerate(zip(found, [*position.tolist(), *near], strict=True)):
            digits = max(len(m[0].partition(".")[2]), 7 if i < 3 else 8)
            same = abs(value - float(m[0])) < 0.5 * 10.0**-digits
            pieces += [old[at : m.start()], m[0] if same else f"{round(value, digits) + 0.0:.{digits}f}"]
            at = m.end()
        return "".join([*pieces, old[at:]])

    def _limit_before(self, c: Correction) -> None:
        """The blend of the move before, whose way out became shorter."""
        if c.move and c.poses[0]:
            self._limit(c.move - 1, float(self.way[c.poses[0]]))

    def _limit(self, move: int, room: float) -> None:
        start, end = self.span(move, "start", "end")
        if float(self.moves.zone[move]) <= room or start in self.limited:
            return
        statement = self.text[start:end]
        spans = self._arguments(statement)
        at = _radius_argument([statement[a:b] for a, b in spans], statement)
        if at is not None:
            a, b = spans[at]
            if start + a not in self.limited:
                self.limited.add(start + a)
                self.edits.append(Edit(start + a, start + b, _with_radius(statement[a:b], room)))
                self.note(move, "a blend radius became smaller, like the segment beside it", 1)


def _radii(position: Floats) -> tuple[Floats, Floats]:
    """Of every pose (N,) m: the largest blend on the way to it, and the largest at a pose that is put in: that also
    keeps to the way behind it, and misses its corner by no more than CUT_TOLERANCE (blending.py)."""
    step = np.nan_to_num(np.diff(position, axis=0))
    gap = np.linalg.norm(step, axis=1)
    way = _SHARE * np.concatenate([[0.0], gap])
    fly = np.minimum(way, np.append(way[1:], 0.0))
    unit = step / np.maximum(gap, 1e-300)[:, None]
    bend = 0.5 * np.linalg.norm(np.diff(unit, axis=0), axis=1)
    fly[1:-1] = np.minimum(fly[1:-1], 2.0 * CUT_TOLERANCE / np.maximum(bend, 1e-12))
    return way, fly


def _nearest(vector: list[float], before: list[float]) -> list[float]:
    """The rotation vector, longer or shorter by whole turns, that is next to the one before."""
    turn = math.hypot(*vector)
    if turn == 0.0:
        return vector
    others = [[v * (1.0 + 2.0 * math.pi * n / turn) for v in vector] for n in (-1, 0, 1)]
    return min(others, key=lambda v: math.dist(v, before))


def _stripped(text: str, start: int, end: int) -> tuple[int, int]:
    piece = text[start:end]
    return start + len(piece) - len(piece.lstrip()), end - len(piece) + len(piece.rstrip())


def _radius(room: float) -> str:
    """Rounded down, so that blends stay apart."""
    return number(np.floor(max(room, 0.0) * 1e6) * 1e-6, 6)


def _with_radius(text: str, room: float) -> str:
    name, sign, _ = text.partition("=")
    return f"{name}{sign}{_radius(room)}" if sign else _radius(room)


def _radius_argument(texts: list[str], statement: str) -> int | None:
    """Which argument is the blend radius."""
    names = PARAMETERS[statement[: statement.index("(")].strip()]
    for i, text in enumerate(texts):
        name, sign, _ = text.partition("=")
        if (name.strip() if sign else names[i] if i < len(names) else "") == "r":
            return i
    return None


FILTER = Filter(rewrite=rewrite)
