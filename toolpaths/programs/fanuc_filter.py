"""Filter in place of Fanuc .ls: position records of cutting moves get new numbers, all else stays byte by byte.

A position that several moves use is split; poses put in become L lines without a line number (the controller numbers
them when it loads) with records of their own; an arc that is no arc any more becomes L lines.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.programs.corrections import Correction, corrections
from toolpaths.programs.fanuc_config import config_texts
from toolpaths.programs.program import WARNING, Finding, Floats, Program
from toolpaths.programs.rewriting import Edit, Rewritten, edited
from toolpaths.readers.fanuc import moves_of, refuse_written
from toolpaths.readers.robot_moves import ARC, RobotMoves
from toolpaths.rotation import fanuc_from_matrix

_FIELD = re.compile(r"\b([XYZWPR])(\s*=)(\s*)(-?(?:\d+\.?\d*|\.\d+))")
_NUMBER = re.compile(r"(?<=P\[)\d+")
_JOINTS = re.compile(r"J1\s*=.*?J6\s*=\s*[-.\d]+\s*deg", re.S)
_TERM = re.compile(r"FINE|CNT\s?\d+|C[DR]\s?\d+")


def rewrite(source: bytes, program: Program, row: Floats, path: Path) -> Rewritten:
    """The .ls ``source`` with the poses of ``program``."""
    refuse_written(source, str(path))
    moves = moves_of(source, str(path), path)
    work = _Work(source.decode("latin-1"), moves, program, path)
    found = corrections(moves, program, row)
    if found:
        poses = np.concatenate([c.poses for c in found])
        work.angles[poses] = np.degrees(fanuc_from_matrix(np.concatenate([c.rotation for c in found])))
    for c in found:
        work.move(c)
    return Rewritten(work.text_out().encode("latin-1"), tuple(work.changes))


class _Work:
    """Edits of one file."""

    def __init__(self, text: str, moves: RobotMoves, program: Program, path: Path) -> None:
        self.text, self.moves, self.program, self.path = text, moves, program, path
        self.eol = "\r\n" if "\r\n" in text else "\n"
        self.edits: list[Edit] = []
        self.records: list[str] = []
        self.changes: list[Finding] = []
        self.angles = np.zeros((len(program), 3))
        mark = moves.mark
        self.uses = Counter([*mark["target_start"].tolist(), *mark["via_start"][mark["word"] == ARC].tolist()])
        self.next = 1 + max(int(n) for n in re.findall(r"^P\[(\d+)", text, re.M))

    def move(self, c: Correction) -> None:
        """The edits of one move."""
        start, end = self._span(c.move, "start", "end")
        statement = self.text[start:end]
        arc = self.moves.mark["word"][c.move] == ARC
        if len(c.poses) > 1:
            what = "an arc became straight lines" if arc else "poses were put in"
            self._note(c.move, what, len(c.poses) - 1)
        inserted = "".join(self._line(statement, self._record(c, k)) for k in range(len(c.poses) - 1))
        if inserted:
            self.edits.append(Edit(start, start, inserted))
        target = self._span(c.move, "target_start", "target_end")
        changed = statement
        if c.moved and (self.uses[target[0]] > 1 or target[0] < 0):
            number = self._record(c, len(c.poses) - 1)
            self._note(c.move, "a position that other moves use, too, or of joint angles, was split", 1)
            changed = self._with_number(statement, number)
        elif c.moved:
            values = self._values(c, len(c.poses) - 1)
            self.edits.append(Edit(*target, self._with_values(self.text[slice(*target)], values)))
        if arc:
            changed = self._as_line(changed)
        if changed != statement:
            self.edits.append(Edit(start, end, changed))

    def text_out(self) -> str:
        """The file with its edits, the new records and the marker."""
        if not self.edits:
            return self.text
        mn = re.search(r"^/MN\b[^\r\n]*(?:\r\n|\r|\n)", self.text, re.M)
        last = re.search(r"^/END\b", self.text, re.M)
        if mn is None or last is None:
            raise WriteError(f"{self.path}: there is no /MN or /END")
        marker = f"    :  !compensated by ;{self.eol}    :  !toolpath-compensator ;{self.eol}"
        ends = [Edit(mn.end(), mn.end(), marker), Edit(last.start(), last.start(), "".join(self.records))]
        return edited(self.text, [*ends, *self.edits])

    def _span(self, move: int, first: str, last: str) -> tuple[int, int]:
        return int(self.moves.mark[first][move]), int(self.moves.mark[last][move])

    def _note(self, move: int, what: str, count: int) -> None:
        place = f"{self.path.name}:{int(self.moves.mark['line'][move])}"
        self.changes.append(Finding(WARNING, place, what, "", count))

    def _record(self, c: Correction, k: int) -> int:
        """A new record like that of the move's end; its number."""
        number = self.next
        self.next += 1
        start, end = self._span(c.move, "target_start", "target_end")
        old = self._with_values(self.text[start:end], self._values(c, k)) if start >= 0 else self._cartesian(c, k)
        self.records.append(re.sub(r"P\[\d+(?::[^\]\r\n]*)?\]", f"P[{number}]", old, count=1) + self.eol)
        return number

    def _cartesian(self, c: Correction, k: int) -> str:
        """The record of a straight move to joint angles, as a position."""
        statement = self.text[slice(*self._span(c.move, "start", "end"))]
        number = (_NUMBER.findall(statement) or ["?"])[-1]
        found = re.search(rf"^P\[{number}(?::[^\]\r\n]*)?\]\s*\{{.*?\}}\s*;", self.text, re.M | re.S)
        if found is None or self.program.configuration is None:
            place = f"{self.path}:{int(self.moves.mark['line'][c.move])}"
            raise WriteError(f"{place}: a straight move to joint angles. Record P[{number}] as a position")
        at = [c.poses[k]]
        config = config_texts(self.program.joints[at], self.program.configuration[at])[0]
        fields = [f"{key} = {value:.4f}" for key, value in zip("XYZWPR", self._values(c, k).tolist(), strict=True)]
        units = ["mm"] * 3 + ["deg"] * 3
        body = f",{self.eol}\t".join(f"{f}  {u}" for f, u in zip(fields, units, strict=True))
        return _JOINTS.sub(f"CONFIG : '{config}',{self.eol}\t{body}", found[0], count=1)

    def _values(self, c: Correction, k: int) -> Floats:
        """X, Y, Z mm and W, P, R deg."""
        return np.concatenate((c.position[k] * 1e3, self.angles[c.poses[k]]))

    def _with_values(self, record: str, values: Floats) -> str:
        """The record with other numbers, as wide as they were, with no fewer digits and at least 0.0001 mm."""
        new = dict(zip("XYZWPR", values.tolist(), strict=True))
        done: set[str] = set()

        def put(m: re.Match[str]) -> str:
            key, sign, space, old = m.groups()
            if key in done:
                return m[0]
            done.add(key)
            value, digits = new[key], max(len(old.partition(".")[2]), 4 if key in "XYZ" else 5)
            if key in "WPR":
                value = float(old) + (value - float(old) + 180.0) % 360.0 - 180.0
            if abs(value - float(old)) < 0.5 * 10.0**-digits:
                return m[0]
            text = f"{round(value, digits) + 0.0:.{digits}f}"
            return f"{key}{sign}{text.rjust(len(space) + len(old)) if space else text}"

        head, brace, body = record.partition("{")
        return head + brace + _FIELD.sub(put, body)

    def _with_number(self, statement: str, number: int) -> str:
        """The statement with another position at its end."""
        found = list(re.finditer(r"P\[\d+(?::[^\]]*)?\]", statement))[-1]
        return f"{statement[: found.start()]}P[{number}]{statement[found.end() :]}"

    def _line(self, statement: str, number: int) -> str:
        """A line in front of the move with its speed, passed without a stop and without a number of its own."""
        text = self._with_number(self._as_line(statement), number)
        body = text[text.index(":") + 1 :] if re.match(r"\s*\d*\s*:", text) else text
        return f"    :{_TERM.sub('CNT100', body, count=1)}{self.eol}"

    def _as_line(self, statement: str) -> str:
        """C P[via] P[end] as L P[end], on one line."""
        found = re.match(r"(\s*\d*\s*:\s*)?C\s+P\[.*?\]\s*(?:\d*\s*:\s*)?(?=P\[)", statement, re.S)
        return f"{found[1] or ''}L {statement[found.end() :]}" if found else statement
