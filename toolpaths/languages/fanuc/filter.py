"""Filter in place of Fanuc .ls: position records of cutting moves get new numbers, all else stays byte by byte.

A position that several moves use is split; poses put in become L lines without a line number (the controller numbers
them when it loads) with records of their own; an arc whose corrected poses leave the circle becomes L lines. Where a
correction turns a joint past 180 deg, the turn number of CONFIG follows.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.finding import WARNING, Finding, merged
from toolpaths.interpreting.robot_moves import ARC, RobotMoves
from toolpaths.languages.fanuc.called_program import called
from toolpaths.languages.fanuc.config import continued_turns, letters, turn_numbers
from toolpaths.languages.fanuc.interpreter import BESIDES
from toolpaths.languages.fanuc.reader import moves_of
from toolpaths.rewriting.corrections import Correction, angles_of, corrections
from toolpaths.rewriting.edits import Edit, edited
from toolpaths.rewriting.filter import Filter, Rewritten
from toolpaths.rewriting.move_edits import MoveEdits
from toolpaths.rotation import fanuc_from_matrix
from toolpaths.toolpath import CUT
from toolpaths.writing.marker import refuse_compensated_remarks
from toolpaths.writing.program import Floats, Ints, Program

_FIELD = re.compile(r"\b([XYZWPR])(\s*=)(\s*)(-?(?:\d+\.?\d*|\.\d+))")
_NUMBER = re.compile(r"(?<=P\[)\d+")
_JOINTS = re.compile(r"J1\s*=.*?J6\s*=\s*[-.\d]+\s*deg", re.S)
_TIMED = re.compile(r"P\[[^\]]*\]\s*(?:[\d.]+|R\[[^\]]*\])\s*m?sec\b")
_TERM = re.compile(r"FINE|CNT\s?\d+|C[DR]\s?\d+")
_CONFIG = re.compile(r"(CONFIG\s*:\s*')([^',]*)((?:\s*,\s*-?\d+)*)")
_INTEGER = re.compile(r"-?\d+")
_CALL = re.compile(r"^\s*\d*\s*:(?:\s*IF\b.*,)?\s*CALL\s+(\w+)", re.M)
#: Joints that a CONFIG counts turns of.
_TURNING = [0, 3, 5]


def rewrite(source: bytes, program: Program, row: Floats, path: Path) -> Rewritten:
    """The .ls ``source`` with the poses of ``program``."""
    refuse_compensated_remarks(source, str(path))
    moves = moves_of(source, str(path), path)
    work = _Work(text=source.decode("latin-1"), moves=moves, program=program, row=row, path=path)
    for c in work.found:
        work.move(c)
    return Rewritten(work.text_out().encode("latin-1"), merged(work.changes))


def _turns(text: str, moves: RobotMoves, program: Program, row: Floats) -> Ints:
    """(N, 3) turn numbers of J1, J4, J6 at the poses of the program, as the file counts them."""
    if program.joints.shape[1] != 6:
        return np.zeros((len(program), 3), dtype=np.int32)
    said = np.full((len(program), 3), np.nan)
    for k in np.flatnonzero(np.abs(row - np.rint(row)) < 1e-9).tolist():
        move = round(float(row[k]))
        if move in moves.joints:
            said[k] = turn_numbers(np.degrees(moves.joints[move][_TURNING]))
            continue
        found = _CONFIG.search(text, *(int(moves.mark[f"target_{end}"][move]) for end in ("start", "end")))
        numbers = _INTEGER.findall(found[3]) if found else []
        if len(numbers) == 3:
            said[k] = numbers
    commanded = np.degrees(program.joints[:, _TURNING])
    nominal = commanded if program.nominal_joints is None else np.degrees(program.nominal_joints[:, _TURNING])
    return continued_turns(said, nominal, commanded)


def _other_postures(moves: RobotMoves, program: Program, row: Floats, path: Path) -> list[Finding]:
    """A warning where the solved arm configuration differs from CONFIG: N or F, U or D, T or B."""
    if program.configuration is None:
        return []
    ends = np.flatnonzero((np.abs(row - np.rint(row)) < 1e-9) & (program.kind == CUT))
    move = np.rint(row[ends]).astype(np.int64)
    said, solved = moves.mark["configuration"][move], program.configuration[ends]
    other = np.flatnonzero((said >= 0) & (said != solved))
    if not len(other):
        return []
    at, first = letters(int(said[other[0]])), letters(int(solved[other[0]]))
    what = f"CONFIG says {at}, the arm was solved as {first}: the correction is that of another posture"
    remedy = "give [start] joints in the posture of the program; see that the model counts joints as Fanuc does"
    return [
        Finding(
            level=WARNING,
            place=f"{path.name}:{int(moves.mark['line'][move[other[0]]])}",
            what=what,
            remedy=remedy,
            count=len(other),
        )
    ]


def _unseen(text: str, path: Path) -> list[Finding]:
    """Called programs that do not lie beside."""
    first: dict[str, int] = {}
    for m in _CALL.finditer(text):
        first.setdefault(m[1], m.start(1))
    out = []
    for name, at in first.items():
        if called(path.parent, name) is None:
            what = f"CALL {name}: {name}.ls is not beside, it is taken to leave the arm where it is"
            place = f"{path.name}:{text.count(chr(10), 0, at) + 1}"
            out.append(Finding(WARNING, place, what, "put it beside: it is read to see that"))
    return out


class _Work(MoveEdits):
    """Edits of one .ls."""

    def __init__(self, text: str, moves: RobotMoves, program: Program, row: Floats, path: Path) -> None:
        super().__init__(text=text, moves=moves, program=program, row=row, path=path)
        self.records: list[str] = []
        self.found = corrections(moves, program, row)
        self.angles = angles_of(self.found, len(program), lambda r: np.degrees(fanuc_from_matrix(r)))
        self.turns = _turns(text, moves, program, row)
        if self.found:
            self.changes += [*_other_postures(moves, program, row, path), *_unseen(text, path)]
        mark = moves.mark
        self.uses = Counter([*mark["target_start"].tolist(), *mark["via_start"][mark["word"] == ARC].tolist()])
        self.next = 1 + max(int(n) for n in re.findall(r"^P\[(\d+)", text, re.M))

    def move(self, c: Correction) -> None:
        """The edits of one move."""
        start, end = self.span(c.move, "start", "end")
        statement = self.text[start:end]
        arc = self.is_arc(c.move)
        via = self.via_point(c) if arc else None
        changed = statement
        if via is not None:
            changed = self._through(c, via, statement)
        elif len(c.poses) > 1:
            if _TIMED.search(statement):
                place = f"{self.path}:{self.line(c.move)}"
                raise WriteError(f"{place}: a move by time cannot be divided. Give it a speed instead of sec or msec")
            what = "an arc became straight lines" if arc else "poses were put in"
            self.note(c.move, what, len(c.poses) - 1)
            lines = (self._line(statement, self._record(c, k)) for k in range(len(c.poses) - 1))
            self.edits.append(Edit(start, start, "".join(lines)))
        target = self.span(c.move, "target_start", "target_end")
        if c.moved and (self.uses[target[0]] > 1 or target[0] < 0):
            number = self._record(c, len(c.poses) - 1)
            self.note(c.move, "a position that other moves use, too, or of joint angles, was split", 1)
            changed = self._with_number(changed, number)
        elif c.moved:
            self.edits.append(Edit(*target, self._moved(c, len(c.poses) - 1)))
        if arc and via is None:
            changed = self._as_line(changed)
        if changed != statement:
            self.edits.append(Edit(start, end, changed))

    def _through(self, c: Correction, via: Floats, statement: str) -> str:
        """The statement of an arc through the point ``via`` (3,) m. The record's W, P, R stay: they are not used."""
        start, end = self.span(c.move, "via_start", "via_end")
        values = dict(zip("XYZ", (via * 1e3).tolist(), strict=True))
        record = self._with_values(self.text[start:end], values)
        if self.uses[start] == 1:
            self.edits.append(Edit(start, end, record))
            return statement
        self.note(c.move, "a position that other moves use, too, was split", 1)
        return self._with_number(statement, self._added(record), 0)

    def text_out(self) -> str:
        """The file with its edits, the new records and the marker."""
        mn = re.search(r"^/MN\b[^\r\n]*(?:\r\n|\r|\n)", self.text, re.M)
        last = re.search(r"^/END\b", self.text, re.M)
        if mn is None or last is None:
            raise WriteError(f"{self.path}: there is no /MN or /END")
        remarks = ("compensated by", "toolpath-compensator", *self.program.stamp)
        marker = "".join(f"    :  !{remark} ;{self.eol}" for remark in remarks)
        ends = [Edit(mn.end(), mn.end(), marker), Edit(last.start(), last.start(), "".join(self.records))]
        return edited(self.text, [*ends, *self.edits])

    def _record(self, c: Correction, k: int) -> int:
        """A new record like that of the move's end; its number."""
        known = self.span(c.move, "target_start", "target_end")[0] >= 0
        return self._added(self._moved(c, k) if known else self._cartesian(c, k))

    def _added(self, record: str) -> int:
        """A record of its own for ``record``; its number."""
        number = self.next
        self.next += 1
        self.records.append(re.sub(r"P\[\d+(?::[^\]\r\n]*)?\]", f"P[{number}]", record, count=1) + self.eol)
        return number

    def _cartesian(self, c: Correction, k: int) -> str:
        """The record of a straight move to joint angles, as a position."""
        statement = self.text[slice(*self.span(c.move, "start", "end"))]
        number = (_NUMBER.findall(statement) or ["?"])[-1]
        found = re.search(rf"^P\[{number}(?::[^\]\r\n]*)?\]\s*\{{.*?\}}\s*;", self.text, re.M | re.S)
        if found is None or self.program.configuration is None:
            place = f"{self.path}:{self.line(c.move)}"
            raise WriteError(f"{place}: a straight move to joint angles. Record P[{number}] as a position")
        turns = ", ".join(str(t) for t in self.turns[c.poses[k]].tolist())
        config = f"{letters(int(self.program.configuration[c.poses[k]]))}, {turns}"
        fields = [f"{key} = {value:.4f}" for key, value in self._values(c, k).items()]
        units = ["mm"] * 3 + ["deg"] * 3
        body = f",{self.eol}\t".join(f"{f}  {u}" for f, u in zip(fields, units, strict=True))
        return _JOINTS.sub(f"CONFIG : '{config}',{self.eol}\t{body}", found[0], count=1)

    def _values(self, c: Correction, k: int) -> dict[str, float]:
        """X, Y, Z mm and W, P, R deg."""
        numbers = [*(c.pose.origin[k] * 1e3).tolist(), *self.angles[c.poses[k]].tolist()]
        return dict(zip("XYZWPR", numbers, strict=True))

    def _moved(self, c: Correction, k: int) -> str:
        """The record of the move's end with pose ``k``, and with the turn numbers of that."""
        start, end = self.span(c.move, "target_start", "target_end")
        turns = self.turns[c.poses[k]].tolist()

        def counted(m: re.Match[str]) -> str:
            said = iter(turns)
            return m[1] + m[2] + (_INTEGER.sub(lambda _: str(next(said)), m[3]) if m[3].count(",") == 3 else m[3])

        return self._with_values(_CONFIG.sub(counted, self.text[start:end], count=1), self._values(c, k))

    def _with_values(self, record: str, new: dict[str, float]) -> str:
        """The record with other numbers, as wide as they were, with no fewer digits and at least 0.0001 mm."""
        done: set[str] = set()

        def put(m: re.Match[str]) -> str:
            key, sign, space, old = m.groups()
            if key in done or key not in new:
                return m[0]
            done.add(key)
            value, digits = new[key], max(len(old.partition(".")[2]), 4 if key in "XYZ" else 5)
            if key in "WPR":
                near = float(old) + (value - float(old) + 180.0) % 360.0 - 180.0
                value = near if abs(near) <= max(180.0, abs(float(old))) else value
            if abs(value - float(old)) < 0.5 * 10.0**-digits:
                return m[0]
            text = f"{round(value, digits) + 0.0:.{digits}f}"
            return f"{key}{sign}{space[:1]}{text.rjust(len(space) + len(old) - 1) if space else text}"

        head, brace, body = record.partition("{")
        return head + brace + _FIELD.sub(put, body)

    def _with_number(self, statement: str, number: int, which: int = -1) -> str:
        """The statement with another position at its end, or as its via point."""
        found = list(re.finditer(r"P\[\d+(?::[^\]]*)?\]", statement))[which]
        return f"{statement[: found.start()]}P[{number}]{statement[found.end() :]}"

    def _line(self, statement: str, number: int) -> str:
        """A line in front of the move with its speed, without a stop, a number and signals of its own."""
        text = self._with_number(self._as_line(statement), number)
        body = text[text.index(":") + 1 :] if re.match(r"\s*\d*\s*:", text) else text
        return f"    :{BESIDES.sub('', _TERM.sub('CNT100', body, count=1))}{self.eol}"

    def _as_line(self, statement: str) -> str:
        """C P[via] P[end] as L P[end], on one line."""
        found = re.match(r"(\s*\d*\s*:\s*)?C\s+P\[.*?\]\s*(?:\d*\s*:\s*)?(?=P\[)", statement, re.S)
        return f"{found[1] or ''}L {statement[found.end() :]}" if found else statement


FILTER = Filter(rewrite=rewrite)
