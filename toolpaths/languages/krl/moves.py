"""Motion lines of KRL: target, speed, rounding, tool and base of each."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import numpy as np

from toolpaths.interpreting.program_text import Statement
from toolpaths.interpreting.robot_moves import ARC, JOINTS, LINE, NOWHERE, PTP, Span
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.languages.krl.expressions import AXES, POSE, Value
from toolpaths.languages.krl.frames import MountedFrames
from toolpaths.languages.krl.names import WHERE_IT_STANDS, KrlNames
from toolpaths.languages.krl.program import KrlProgram
from toolpaths.languages.krl.tails import SYSTEM, KrlTails
from toolpaths.rotation import matrix_from_kuka, quaternion_from_matrix
from toolpaths.toolpath import CUT, RAPID, Floats

MOTION = re.compile(
    r"(SLIN_REL|SPTP_REL|SCIRC_REL|LIN_REL|PTP_REL|CIRC_REL|SLIN|SPTP|SCIRC|LIN|PTP|CIRC)(?![\w$])", re.I
)
_N = r"\s+([-+]?[0-9.]+(?:[eE][-+]?\d+)?)\s*"
#: A pose of numbers: groups 1-6 X ... C, group 7 what follows them.
LITERAL = re.compile(r"\{\s*(?:\w+\s*:)?\s*" + ",\\s*".join(k + _N for k in POSE) + r"((?:,[^{}]*)?)\}(?!\s*:)", re.I)
_STATUS = re.compile(r"\bS\s*(?:'B([01]{1,6})'|(?<=\s)(\d+))", re.I)
EXTERNAL = ("E1", "E2", "E3", "E4", "E5", "E6")
_AXIS = re.compile(r"\b(E[1-6])\s+([-+]?[0-9.]+(?:[eE][-+]?\d+)?)", re.I)
_NAME = re.compile(r"\s*([A-Za-z_$][\w$]*)\s*(?=,|$|C_|WITH)", re.I)
_PIECE = re.compile(r"[{}()\[\],]|(?<![\w$])(?:C_\w+|WITH)(?!\w)|\s(?=C_|WITH\b)", re.I)
_NAN = math.nan
_EXACT = 1e-15  # what sine and cosine of right angles leave
_POSES = ("E6POS", "POS", "FRAME")


def quaternions(numbers: Floats) -> Floats:
    """Quaternions (N, 4) of A, B, C deg in the first three columns."""
    matrix = matrix_from_kuka(np.radians(numbers[:, :3]))
    matrix[np.abs(matrix) < _EXACT] = 0.0
    return quaternion_from_matrix(matrix)


class KrlMover:
    """Turns the motion lines of one run into moves of a track.

    Attributes:
        track: the moves.
        mounted: tool and base.
        tails: what stands behind the targets.
        others: move -> the value of a target that does not stand there as numbers.
    """

    def __init__(self, program: KrlProgram, names: KrlNames) -> None:
        self.program, self.names = program, names
        self.track = RobotTrack(program.source, "krl", quaternions, EXTERNAL, text=program)
        self.mounted = MountedFrames(program, names, self.track)
        self.tails = KrlTails(program, names, self.mounted)
        self.others: dict[int, dict[str, Value]] = {}
        self._lost = ""  # the move before, where only the controller knows its target
        self._last: tuple[float, ...] | None = None  # X ... C of the pose before, in the same base and tool
        self._frames: tuple[int, int] | None = None
        self._axes, self._more = dict.fromkeys(EXTERNAL, _NAN), ""  # external axes, and how the pose before gives them

    def move(self, motion: re.Match[str], s: Statement) -> None:
        """Append the move of one line."""
        word = motion[1].upper().removeprefix("S")
        via: tuple[float, ...] = (_NAN,) * 3
        via_span, at = NOWHERE, motion.end()
        if word.endswith("_REL"):
            self._relative(word, s, at)
            return
        if word == "CIRC":
            at, via_span, middle = self._via(s, at)
            via = middle[:3]
        match = LITERAL.match(self.program.text, self._blanks(at, s.end), s.end)
        if match:
            values, span, at = self._literal(match, s), (*match.span(), *match.span()), match.end()
        else:
            at, span, found = self._target(s, at, word)
            if found is None:
                return
            values = found
        self._append(word, s=s, at=at, values=values, span=span, via=via, via_span=via_span)

    def _append(
        self, word: str, s: Statement, at: int, values: tuple[float, ...], span: Span, via: tuple[float, ...],
        via_span: Span,
    ) -> None:  # fmt: skip
        """``values``: X ... C and S."""
        if word != "PTP" and self._lost and self.track.count:
            problem = f"this move starts where {self._lost} leads, which is not in the file"
            remedy = "Give that position in a file, or put a PTP to a pose in front of it."
            self.program.refuse(s.start, problem, remedy)
        self._lost = ""
        feed, zone, tool, base = self.tails.tail(s, self.program.text[at : s.end], word)
        line = self.program.line(s.start)
        kind = RAPID if word == "PTP" else CUT
        code = {"PTP": PTP, "LIN": LINE, "CIRC": ARC}[word]
        if not math.isfinite(sum(values[:3])):
            code = JOINTS
        self.track.move(
            (*values[:6], 0.0, feed, zone, *via),
            (code, int(kind), tool, line, base, _branch(values[6]), s.start, s.end, *span, *via_span),
        )
        self._last, self._frames = tuple(values[:6]) if code != JOINTS else None, (tool, base)

    def _blanks(self, at: int, end: int) -> int:
        text = self.program.text
        while at < end and text[at] in " \t":
            at += 1
        return at

    def _literal(self, match: re.Match[str], s: Statement) -> tuple[float, ...]:
        try:
            values = [float(v) for v in match.groups()[:6]]
        except ValueError:
            self.program.refuse(s.start, f"{match[0][:60]!r} holds something that is no number")
        if not math.isfinite(sum(values)) or max(map(abs, values)) > 1e7:
            self.program.refuse(s.start, "a coordinate that is not a finite number")
        status = _STATUS.search(match[7]) if match[7] else None
        if match[7] != self._more:
            try:
                self._stand(s, {name.upper(): float(v) for name, v in _AXIS.findall(match[7])})
            except ValueError:
                self.program.refuse(s.start, f"{match[0][-60:]!r} holds something that is no number")
            self._more = match[7]
        bits = -1.0 if status is None else float(status[2] if status[1] is None else int(status[1], 2))
        return (*values, bits)

    def _stand(self, s: Statement, values: Mapping[str, Value]) -> None:
        """Note where the external axes stand; those that a pose does not give stay."""
        self._more = ""
        given = {k: values[k] for k in EXTERNAL if isinstance(values.get(k), float)}
        if not all(map(math.isfinite, given.values())):
            self.program.refuse(s.start, "an external axis at a number that is not finite")
        if given:
            self._axes |= given
            self.track.stand(tuple(self._axes.values()))

    def _argument_end(self, s: Statement, at: int) -> int:
        """Where a target ends: at a comma outside brackets, at C_..., at WITH, at the end of the line."""
        depth = 0
        for found in _PIECE.finditer(self.program.text, at, s.end):
            mark = found[0]
            if mark in ("{", "(", "["):
                depth += 1
            elif mark in ("}", ")", "]"):
                depth -= 1
            elif depth == 0 and found.start() > at:
                return found.start()
        return s.end

    def _via(self, s: Statement, at: int) -> tuple[int, Span, tuple[float, ...]]:
        begin = self._blanks(at, s.end)
        if match := LITERAL.match(self.program.text, begin, s.end):
            end, span, values = match.end(), (*match.span(), *match.span()), self._literal(match, s)
        else:
            end, span, found = self._target(s, at, "LIN")
            if found is None or not math.isfinite(found[0]):
                self.program.refuse(s.start, "the via point of a circle has to be a pose")
            values = found
        comma = re.compile(r"\s*,").match(self.program.text, end, s.end)
        if not comma:
            self.program.refuse(s.start, "CIRC needs a via point and an end", "The line may be cut off.")
        return comma.end(), span, values

    def _target(self, s: Statement, at: int, word: str) -> tuple[int, Span, tuple[float, ...] | None]:
        """Where the line goes on, the place of the target, and X ... C and S; None where no move is known."""
        text = self.program.text
        if (match := _NAME.match(text, at, s.end)) and (variable := self.names.get(match[1].upper())):
            d = variable.declaration
            if d is not None and d.type in _POSES:
                literal = LITERAL.match(text, d.value[0], d.end) if d.value[0] >= 0 else None
                if literal and literal.end() == d.end:
                    return match.end(), (*literal.span(), *match.span(1)), self._literal(literal, s)
        end = self._argument_end(s, at)
        piece = text[at:end]
        first, last = self._blanks(at, end), at + len(piece.rstrip())
        span = (first, last, first, last)
        try:
            value = self.names.value(piece)
        except ExpressionError as e:
            self.program.refuse(s.start, f"{piece.strip()[:40]!r}: {e}")
        if isinstance(value, Runtime):
            if word == "PTP":  # HOME of the controller, or where the arm stands anyway
                shown, line = f"PTP {piece.strip()}", self.program.line(s.start)
                where_it_stands = piece.strip().upper() in WHERE_IT_STANDS
                instruction = "" if where_it_stands else shown
                self.track.event(shown, line, instruction, self.program.part(s.start))
                if not where_it_stands:
                    self._lost = f"{shown} (line {line})"
                self._axes, self._more = dict.fromkeys(EXTERNAL, _NAN), ""
                return end, span, None
            there = ", there in place of $POS_ACT" if "$POS_ACT" in value.reason else ""
            remedy = f"Give the poses as numbers{there}."
            self.program.refuse(s.start, f"the target is known only at run time: {value.reason}", remedy)
        if not isinstance(value, dict):
            self.program.refuse(s.start, f"{piece.strip()[:40]!r} is no pose")
        return end, span, self._values(s, value, word)

    def _values(self, s: Statement, value: dict[str, Value], word: str) -> tuple[float, ...]:
        numbers = {k: v for k, v in value.items() if isinstance(v, float)}
        self._stand(s, numbers)
        if any(k in value for k in AXES):
            if word != "PTP" or not all(k in numbers for k in AXES):
                self.program.refuse(s.start, "axis angles need PTP and all of A1 ... A6")
            angles = np.radians([numbers[k] for k in AXES])
            if not np.isfinite(angles).all() or np.abs(angles).max() > 100.0:
                self.program.refuse(s.start, "joint angles that no arm has")
            self.track.joints[self.track.count] = angles
            return (*(_NAN,) * 6, -1.0)
        missing = [k for k in POSE if k not in numbers]
        last = self._before(s) if missing else (0.0,) * 6
        if last is None:
            problem = f"{', '.join(missing)} missing: what is kept of the pose before is not known"
            self.program.refuse(s.start, problem, "Give all of X, Y, Z, A, B and C.")
        pose = [numbers.get(k, last[i]) for i, k in enumerate(POSE)]
        if not math.isfinite(sum(pose)) or max(map(abs, pose)) > 1e7:
            self.program.refuse(s.start, "a coordinate that is not a finite number")
        self.others[self.track.count] = value
        return (*pose, numbers.get("S", -1.0))

    def _relative(self, word: str, s: Statement, at: int) -> None:
        if word != "LIN_REL":
            self.program.refuse(s.start, f"{word}: relative to where the arm stands", "Give the pose as numbers.")
        in_tool = re.compile(r"#TOOL\s*", re.I).search(self.program.text, at, s.end) is not None
        end = self._argument_end(s, at)
        try:
            value = self.names.value(SYSTEM.sub("", self.program.text[at:end]))
        except ExpressionError as e:
            self.program.refuse(s.start, str(e))
        if not isinstance(value, dict) or not all(isinstance(v, float) for v in value.values()):
            self.program.refuse(s.start, "LIN_REL: the step is known only at run time")
        before = self._before(s)
        if before is None:
            self.program.refuse(s.start, "LIN_REL: where the arm stands before is not known")
        if any(value.get(k, 0.0) for k in POSE[3:]):
            self.program.refuse(s.start, "LIN_REL with a turn is not read", "Give the pose as numbers.")
        step = np.array([value.get(k, 0.0) for k in POSE[:3]])
        if not np.isfinite(step).all():
            self.program.refuse(s.start, "a coordinate that is not a finite number")
        turn = matrix_from_kuka(np.radians(before[3:])) if in_tool else np.eye(3)
        pose = [*(np.array(before[:3]) + turn @ step).tolist(), *before[3:]]
        self.others[self.track.count] = dict(zip(POSE, pose, strict=True))
        first, last = self._blanks(at, end), at + len(self.program.text[at:end].rstrip())
        span = (first, last, first, last)
        self._append("LIN", s=s, at=end, values=(*pose, -1.0), span=span, via=(_NAN,) * 3, via_span=NOWHERE)

    def _before(self, s: Statement) -> tuple[float, ...] | None:
        """X ... C of the pose before; None where it is not known, or of another tool or base."""
        frames = self.mounted.tool(s, None), self.mounted.base(s, None)
        return self._last if self._frames == frames else None


def _branch(status: float) -> int:
    """Configuration bits as in Program of S; -1 where it is not given."""
    if not 0.0 <= status < 64.0:
        return -1
    s = int(status)
    return ((s & 1) << 2) | ((1 - ((s >> 1) & 1)) << 1) | ((s >> 2) & 1)
