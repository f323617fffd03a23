"""Puts poses into the text of a robot program: the part of the filter that is the same in every language.

A language gives a ``Style``: how a pose is spelled, and what a line that is put in looks like.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

from toolpaths.errors import WriteError
from toolpaths.programs.program import WARNING, Finding, Floats, Program
from toolpaths.programs.rewriting import SAME_PLACE, SAME_TURN, Edit
from toolpaths.readers.robot_moves import ARC, RobotMoves, circle_through, slerped
from toolpaths.rotation import matrix_from_quaternion, quaternion_from_matrix
from toolpaths.toolpath import CUT

ARC_PLACE = 1e-5  # m that commanded poses may lie off one arc
ARC_TURN = 2e-4  # rad that they may be turned off the turn from its start to its end
_ROW = 1e-9
_WORDS = re.compile(r"[A-Za-z_$][\w$]*")


@dataclass(frozen=True)
class Declared:
    """A declared target: its name and the place of the whole declaration."""

    name: str
    start: int
    end: int


class Style(Protocol):
    """How a language spells poses and moves."""

    text: str
    #: A pose made of numbers; groups 1 to 3 are X, Y, Z.
    literal: re.Pattern[str]
    #: A line end of the file.
    newline: str

    def aggregate(self, move: int) -> str:
        """The target of a move that is no literal, as one."""

    def spelled(self, literal: str, position: Floats, rotation: Floats | None) -> str:
        """A literal with other numbers: (3,) m and (3, 3); without rotation that stays."""

    def inserted(self, move: int, target: str) -> str:
        """A straight move to ``target`` as it is put in before the move's statement."""

    def straight(self, move: int) -> Iterator[Edit]:
        """What makes the move a straight one to a target of its own: its word; of an arc the via point goes."""

    def declared(self) -> Sequence[Declared]:
        """Declared targets by ``start``."""

    def free_name(self, name: str, taken: set[str]) -> str:
        """A legal name near ``name`` whose upper case is not in ``taken``."""


@dataclass
class _Use:
    """A target that a statement gives or names: numbers as wanted, line, and where it is named."""

    wanted: str
    move: int
    reference: tuple[int, int]


@dataclass
class Placing:
    """Edits and findings of one program.

    Args:
        program: commanded poses in the main frame of ``moves``.
        row: of each pose.
    """

    style: Style
    moves: RobotMoves
    program: Program
    row: Floats
    edits: list[Edit] = field(default_factory=list)
    changes: list[Finding] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._own = self.moves.from_main()
        nearest = np.rint(self.row)
        whole = np.abs(self.row - nearest) < _ROW
        self._at = np.full(len(self.moves), -1, dtype=np.intp)
        inside = whole & (nearest >= 0) & (nearest < len(self.moves))
        self._at[nearest[inside].astype(np.intp)] = np.flatnonzero(inside)
        between = np.flatnonzero(~whole)
        self._between: dict[int, list[int]] = {}
        for k in between.tolist():
            self._between.setdefault(int(np.ceil(self.row[k])), []).append(k)
        self._uses: dict[tuple[int, int], dict[int, _Use]] = {}  # place of the numbers -> place of naming -> use
        self._lines: dict[int, str] = {}  # statement -> lines put in before it
        self._straight: set[int] = set()

    def place(self) -> None:
        """Make all edits.

        Raises:
            WriteError: one line would need two poses.
        """
        cutting = np.flatnonzero(self.moves.mark["kind"] == CUT)
        missing = cutting[self._at[cutting] < 0]
        if len(missing):
            raise WriteError(f"{self._line(int(missing[0]))}: no pose was worked out for this move")
        changed = self._changed(cutting)
        for r, other in zip(cutting.tolist(), changed.tolist(), strict=True):
            if self.moves.mark["word"][r] == ARC:
                self._arc(r, other)
            else:
                self._line_move(r, other)
        for place, uses in self._uses.items():
            self._settle(place, uses)

    def _line(self, r: int) -> str:
        return f"{self.moves.source}:{int(self.moves.mark['line'][r])}"

    def _note(self, r: int, what: str, count: int = 1) -> None:
        self.changes.append(Finding(WARNING, f"line {int(self.moves.mark['line'][r])}", what, "", count))

    def _changed(self, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
        """Whether the pose of each move is another than in the source."""
        at = self._at[rows]
        position, rotation = self._in_own(at, rows)
        moved = np.linalg.norm(position - self.moves.position[rows], axis=1)
        old = matrix_from_quaternion(self.moves.quaternion[rows])
        return np.asarray((moved > SAME_PLACE) | (np.abs(rotation - old).max(axis=(1, 2)) > SAME_TURN))

    def _in_own(self, at: npt.NDArray[np.intp], rows: npt.NDArray[np.intp]) -> tuple[Floats, Floats]:
        """Poses of the program in the frames of the moves ``rows``."""
        position, rotation = self.program.position[at].copy(), self.program.rotation[at].copy()
        for number, (turn, origin) in enumerate(self._own):
            mine = self.moves.mark["frame"][rows] == number
            if mine.any():
                position[mine] = position[mine] @ turn.T + origin
                rotation[mine] = turn @ rotation[mine]
        return position, rotation

    def _pose(self, k: int, r: int) -> tuple[Floats, Floats]:
        position, rotation = self._in_own(np.array([k]), np.array([r]))
        return position[0], rotation[0]

    def _literal(self, r: int, name: str = "target") -> str:
        mark = self.moves.mark
        text = self.style.text[mark[f"{name}_start"][r] : mark[f"{name}_end"][r]]
        return text if self.style.literal.fullmatch(text) else self.style.aggregate(r)

    def _line_move(self, r: int, other: bool) -> None:
        between = self._between.get(r, [])
        if not other and not between:
            self._use(r, self._literal(r), "target", keep=True)
            return
        literal = self._literal(r)
        self._insert(r, between, literal)
        wanted = self.style.spelled(literal, *self._pose(int(self._at[r]), r)) if other else literal
        self._use(r, wanted, "target", keep=not other)

    def _insert(self, r: int, between: list[int], literal: str) -> None:
        if not between:
            return
        start = int(self.moves.mark["start"][r])
        lines = [self.style.inserted(r, self.style.spelled(literal, *self._pose(k, r))) for k in between]
        begin = max(self.style.text.rfind("\n", 0, start), self.style.text.rfind("\r", 0, start)) + 1
        indent = re.match(r"[ \t]*", self.style.text[begin:start])
        text = "".join(line + self.style.newline + (indent[0] if indent else "") for line in lines)
        if start in self._lines:
            if self._lines[start] != text:
                raise WriteError(f"{self._line(r)}: this line runs several times, with different poses: write it out")
            return
        self._lines[start] = text
        self.edits.append(Edit(start, start, text))
        self._note(r, "poses put in before the move", len(between))

    def _use(self, r: int, wanted: str, name: str, keep: bool = False) -> None:
        """Note that a move needs ``wanted`` where its target (or via point) stands."""
        mark = self.moves.mark
        place = int(mark[f"{name}_start"][r]), int(mark[f"{name}_end"][r])
        prefix = "ref" if name == "target" else "via_ref"
        reference = int(mark[f"{prefix}_start"][r]), int(mark[f"{prefix}_end"][r])
        if keep:
            wanted = self.style.text[slice(*place)]
        seen = self._uses.setdefault(place, {}).setdefault(reference[0], _Use(wanted, r, reference))
        if seen.wanted != wanted:
            raise WriteError(f"{self._line(r)}: this line runs several times, with different poses: write it out")

    def _arc(self, r: int, other: bool) -> None:
        between = self._between.get(r, [])
        corrected = self._arc_points(r, between)
        if corrected is None:
            self._insert(r, between, self._literal(r))
            self._make_straight(r)
            self._note(r, "an arc became short lines")
        else:
            via, moved = corrected
            literal = self._literal(r, "via")
            self._use(r, self.style.spelled(literal, via, None) if moved else literal, "via", keep=not moved)
        wanted = self.style.spelled(self._literal(r), *self._pose(int(self._at[r]), r)) if other else ""
        self._use(r, wanted, "target", keep=not other)

    def _make_straight(self, r: int) -> None:
        start = int(self.moves.mark["start"][r])
        if start not in self._straight:
            self._straight.add(start)
            self.edits += self.style.straight(r)

    def _arc_points(self, r: int, between: list[int]) -> tuple[Floats, bool] | None:
        """The via point (3,) in the move's frame and whether it moved; None where the poses are on no arc."""
        first, last = int(self._at[r - 1]), int(self._at[r])
        via = self.moves.via[r]
        if first < 0:
            return None
        ends = self.moves.in_main(self.moves.position)[r - 1 : r + 1]
        main = self.moves.in_main(self.moves.via)[r]
        center, normal, sweep, share, _ = circle_through(ends[:1], main[None], ends[1:])
        k = np.array([first, *between, last])
        t = self.row[k] - (r - 1)
        nominal = _on_circle(ends[0], center[0], normal[0], sweep[0] * t)
        shift = self.program.position[k] - nominal
        moved = np.array([np.interp(share[0], t, column) for column in shift.T])
        if np.linalg.norm(moved) < SAME_PLACE and np.abs(shift).max() < SAME_PLACE:
            return via, False
        if not self._one_arc(k, t, main + moved):
            return None
        turn, origin = self._own[int(self.moves.mark["frame"][r])]
        return turn @ (main + moved) + origin, True

    def _one_arc(self, k: npt.NDArray[np.intp], t: Floats, via: Floats) -> bool:
        points = self.program.position[k]
        center, normal, _, _, flat = circle_through(points[:1], via[None], points[-1:])
        if flat[0]:
            return False
        arm = points - center
        height = arm @ normal[0]
        radius = np.linalg.norm(arm - height[:, None] * normal, axis=1)
        if np.hypot(height, radius - radius[0]).max() > ARC_PLACE:
            return False
        q = quaternion_from_matrix(self.program.rotation[k])
        way = slerped(np.repeat(q[:1], len(k), axis=0), np.repeat(q[-1:], len(k), axis=0), t)
        return bool(2.0 * np.sqrt(np.maximum(0.0, 1.0 - np.sum(way * q, axis=1) ** 2)).max() <= ARC_TURN)

    def _settle(self, place: tuple[int, int], uses: dict[int, _Use]) -> None:
        """One pose in the text and all moves that take it."""
        text = self.style.text[slice(*place)]
        first = next(iter(uses.values()))
        if place[0] == first.reference[0]:  # it stands in the move itself
            if first.wanted != text:
                self.edits.append(Edit(*place, first.wanted))
                if not self.style.literal.fullmatch(text):
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
            self.edits.append(Edit(*place, stays))
        self._split(target, place, stays, uses)

    def _split(self, target: Declared, place: tuple[int, int], stays: str, uses: dict[int, _Use]) -> None:
        names: dict[str, str] = {}
        for use in uses.values():
            if use.wanted == stays:
                continue
            if use.wanted not in names:
                name = names[use.wanted] = self.style.free_name(target.name, self._taken)
                self._taken.add(name.upper())
                self._declare(target, place, name, use.wanted)
                self._note(use.move, f"{target.name} is used by several moves: {name} was declared beside it")
            self.edits.append(Edit(*use.reference, names[use.wanted]))

    def _declare(self, target: Declared, place: tuple[int, int], name: str, wanted: str) -> None:
        text = self.style.text
        begin = max(text.rfind("\n", 0, target.start), text.rfind("\r", 0, target.start)) + 1
        head = re.sub(rf"(?<![\w$]){re.escape(target.name)}(?![\w$])", name, text[begin : place[0]], count=1)
        line_end = re.compile(r"[\r\n\f]|$").search(text, target.end)
        at = line_end.start() if line_end else len(text)
        self.edits.append(Edit(at, at, self.style.newline + head + wanted + text[place[1] : target.end]))

    def _declaration(self, at: int) -> Declared:
        if not hasattr(self, "_targets"):
            self._targets = list(self.style.declared())
            self._starts = np.array([d.start for d in self._targets])
            self._counts = Counter(w.upper() for w in _WORDS.findall(self.style.text))
            self._taken = set(self._counts)
        return self._targets[int(np.searchsorted(self._starts, at, side="right")) - 1]

    def _others(self, target: Declared, uses: int) -> bool:
        """Whether something else than these uses names the target: rapids, Offs(...), other routines."""
        return self._counts[target.name.upper()] - 1 > uses


def _on_circle(start: Floats, center: Floats, normal: Floats, angle: Floats) -> Floats:
    """Points (K, 3) of a circle, ``angle`` (K,) from ``start`` on."""
    out = start - center
    side = np.cross(normal, out)
    return np.asarray(center + np.cos(angle)[:, None] * out + np.sin(angle)[:, None] * side)


def respelled(literal: str, match: re.Match[str], values: Sequence[float], decimals: Sequence[int]) -> str:
    """A literal with the numbers of groups 1, 2, ... replaced, those that stay the same in print left as they are."""
    pieces, at = [], 0
    for group, (value, least) in enumerate(zip(values, decimals, strict=True), start=1):
        old = match[group]
        digits = max(least, len(old.partition(".")[2]) if "e" not in old.lower() else 0)
        if abs(float(old) - value) < 0.5 * 10.0**-least:
            continue
        new = f"{value:.{digits}f}"
        new = new.lstrip("-") if float(new) == 0.0 else new
        pieces += [literal[at : match.start(group)], new]
        at = match.end(group)
    return "".join([*pieces, literal[at:]])


def newline_of(text: str) -> str:
    """The line end that a text uses first."""
    found = re.search(r"\r\n|\n|\r", text)
    return found[0] if found else "\n"


def line_end(text: str, at: int) -> int:
    """Where the line of a place ends, behind its line end."""
    found = re.compile(r"\r\n|\n|\r|$").search(text, at)
    return found.end() if found else len(text)
