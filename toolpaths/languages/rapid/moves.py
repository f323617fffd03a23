"""Move instructions of RAPID: target, speed, zone, tool and work object of each."""

from __future__ import annotations

import math
import re
from typing import Any, NamedTuple, NoReturn

import numpy as np

from toolpaths.interpreting.program_text import Declaration, Statement
from toolpaths.interpreting.robot_moves import ARC, JOINTS, LINE, NOWHERE, PTP, Span
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.languages.rapid.expressions import RapidExpression
from toolpaths.languages.rapid.frames import DeclaredFrames
from toolpaths.languages.rapid.names import RapidNames
from toolpaths.languages.rapid.program import RapidProgram
from toolpaths.languages.rapid.values import Value, fits
from toolpaths.reading.source_text import comment_word, plain_text
from toolpaths.toolpath import CUT, RAPID, Floats

_N = r"\s*([-+]?[0-9.]+(?:[eE][-+]?\d+)?)\s*"


def _group(n: int) -> str:
    return r"\s*\[" + ",".join([_N] * n) + r"\]\s*"


#: A robtarget of numbers: groups 1-3 position, 4-7 quaternion, 8-11 configuration, 12-17 external axes.
LITERAL = re.compile(r"\s*\[" + ",".join(_group(n) for n in (3, 4, 4, 6)) + r"\]")
_NAME = re.compile(r"\s*([A-Za-z]\w*)\s*(?=[,\\])")
_CONC = re.compile(r"\s*\\\s*Conc\s*,", re.I)
_PIECE = re.compile(r'"[^"\n\r]*"|![^\n\r]*|[\[\](){},]')
EXTERNAL = tuple(f"eax_{k}" for k in "abcdef")
_NONE = 8.9e9  # 9E9 stands for no value
_WORD = {"movel": LINE, "movej": PTP, "movec": ARC, "moveabsj": JOINTS}
Numbers = tuple[float, ...]
_NAN = math.nan
_NO_VIA = (_NAN, _NAN, _NAN)


def quaternions(numbers: Floats) -> Floats:
    """Quaternions (N, 4) as printed, of unit length."""
    return np.asarray(numbers / np.linalg.norm(numbers, axis=1, keepdims=True))


class _Instruction(NamedTuple):
    """An instruction, or a declaration, in the text of its module.

    Attributes:
        text: of the module, from ``begin`` of the whole on. start, end: places in it.
    """

    statement: Any
    text: str
    begin: int
    start: int
    end: int

    @classmethod
    def of(cls, module: RapidProgram, s: Statement | Declaration) -> _Instruction:
        text, begin = module.around(s.start)
        return cls(statement=s, text=text, begin=begin, start=s.start - begin, end=s.end - begin)

    def here(self, start: int, end: int) -> Span:
        """The place of a pose that stands in it, without the blanks around."""
        piece = self.text[start:end]
        first = self.begin + start + len(piece) - len(piece.lstrip())
        last = first + len(piece.strip())
        return first, last, first, last


class RapidMover:
    """Turns the move instructions of one run into moves of a track.

    Attributes:
        track: the moves.
        others: move -> configuration and external axes of a target that does not stand there as numbers.
    """

    def __init__(self, module: RapidProgram, names: RapidNames) -> None:
        self.module, self.names = module, names
        self.track = RobotTrack(module.source, "rapid", quaternions, EXTERNAL, text=module)
        self.others: dict[int, tuple[Value, Value]] = {}
        self._tails: dict[str, tuple[float, float, int, int, bool]] = {}
        self.frames = DeclaredFrames(module, self.track)
        self._axes = ""  # external axes as the move before spells them
        self._lost = ""  # why it is not known where the arm stands

    def forget(self) -> None:
        """Names may mean something else from here on."""
        self._tails.clear()

    def move(self, word: str, s: Statement) -> None:
        """Append the move of one instruction."""
        i = _Instruction.of(self.module, s)
        text, at = i.text, i.start + len(s.word)
        if conc := _CONC.match(text, at, i.end):
            at = conc.end()
        via, via_span = _NO_VIA, NOWHERE
        if word == "movec":
            middle, via_span, at = self._target(i, at)
            if isinstance(middle, Runtime):
                self._refuse_unknown(s, middle)
            via = (middle[0], middle[1], middle[2])
            comma = re.compile(r"(?:\s|![^\n\r]*)*,").match(text, at, i.end)
            if not comma:
                self.module.refuse(s.start, f"{s.word}: a second target is expected")
            at = comma.end()
        if word == "moveabsj":
            values, span, at = self._joints(i, at)
        else:
            values, span, at = self._target(i, at)
        tail = text[at : i.end - 1]
        known = self._tails.get(tail)
        if known is None:
            known = self._tails[tail] = self._tail(s, tail)
        feed, zone, tool, frame, fast = known
        kind = CUT if word in ("movel", "movec") and not fast else RAPID
        line = self.module.line(s.start)
        if isinstance(values, Runtime):
            if kind == CUT or word == "movec":
                self._refuse_unknown(s, values)
            self._leave(s, values, text[i.start : span[1] - i.begin])
            return
        if self._lost and kind == CUT and self.track.count:
            problem = f"{s.word}: where this cut begins is not known: the move before leads to {self._lost}"
            self.module.refuse(s.start, problem, "Declare it in one of the files, or put a MoveJ to a pose before.")
        self._lost = ""
        self.track.move(
            (*values[:7], feed, zone, *via),
            (_WORD[word], int(kind), tool, line, frame, int(values[7]), s.start, s.end, *span, *via_span),
        )

    def _leave(self, s: Statement, unknown: Runtime, shown: str) -> None:
        """The arm goes to where only the controller knows, without cutting: a remark."""
        self.track.event(comment_word(plain_text(shown)), self.module.line(s.start), shown, self.module.part(s.start))
        self._stand([_NONE] * len(EXTERNAL))
        self._lost = unknown.reason

    def _refuse_unknown(self, s: Statement, unknown: Runtime) -> NoReturn:
        remedy = "Give the poses as numbers, in this file or in one that is read with it."
        self.module.refuse(s.start, f"{s.word}: known only at run time: {unknown.reason}", remedy)

    def _target(self, i: _Instruction, at: int) -> tuple[Numbers | Runtime, Span, int]:
        """Position, quaternion and cfx; the place of the target; where the instruction goes on."""
        text, s = i.text, i.statement
        if match := LITERAL.match(text, at, i.end):
            self._stand_literally(match, i.begin)
            return self._literal(match, s, i.begin), i.here(*match.span()), match.end()
        if (match := _NAME.match(text, at, i.end)) and (variable := self.names.variable(match[1])):
            d = variable.declaration
            if d is not None and d.type == "robtarget" and not d.array:
                there = _Instruction.of(self.module, d)
                literal = LITERAL.match(there.text, d.value[0] - there.begin, there.end)
                if literal and not there.text[literal.end() : there.end - 1].strip():
                    self._stand_literally(literal, there.begin)
                    place = *there.here(*literal.span())[:2], match.start(1) + i.begin, match.end(1) + i.begin
                    return self._literal(literal, s, there.begin), place, match.end()
        end = self._argument_end(i, at)
        value = self._constant(s, text[at:end], "robtarget", "a robtarget")
        if isinstance(value, Runtime):
            return value, i.here(at, end), end
        self.others[self.track.count] = (value[2], value[3])
        self._stand(value[3])
        return self._checked([*value[0], *value[1], value[2][3]], s), i.here(at, end), end

    def _literal(self, match: re.Match[str], s: Statement, begin: int) -> Numbers:
        try:
            values = [float(v) for v in match.groups()[:11]]
        except ValueError:
            self.module.refuse(begin + match.start(), f"{match[0].strip()[:60]!r} holds something that is no number")
        return self._checked([*values[:7], values[10]], s)

    def _stand_literally(self, match: re.Match[str], begin: int) -> None:
        axes = match.string[match.start(12) : match.end()]
        if axes != self._axes:
            try:
                self._stand([float(v) for v in match.groups()[11:17]])
            except ValueError:
                self.module.refuse(begin + match.start(), f"{axes.strip()[:60]!r} holds something that is no number")
            self._axes = axes

    def _stand(self, values: list[float]) -> None:
        """Note where the external axes stand."""
        self._axes = ""
        self.track.stand(tuple(v if abs(v) < _NONE else _NAN for v in values))

    def _checked(self, values: list[float], s: Statement) -> Numbers:
        x, y, z, a, b, c, d, branch = values
        if not math.isfinite(x + y + z):
            self.module.refuse(s.start, "a coordinate that is not a finite number")
        length = math.sqrt(a * a + b * b + c * c + d * d)
        if not abs(length - 1.0) < 1e-3:
            self.module.refuse(s.start, f"a quaternion of length {length:.6g}, 1 expected", "Give a unit quaternion.")
        cfx = branch if branch in (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0) else -1.0
        return x, y, z, a, b, c, d, cfx

    def _joints(self, i: _Instruction, at: int) -> tuple[Numbers | Runtime, Span, int]:
        end, s = self._argument_end(i, at), i.statement
        value = self._constant(s, i.text[at:end], "jointtarget", "a jointtarget")
        if isinstance(value, Runtime):
            return value, i.here(at, end), end
        angles = np.radians(value[0])
        if not np.isfinite(angles).all() or np.abs(angles).max() > 100.0:
            self.module.refuse(s.start, f"{s.word}: joint angles that no arm has")
        self.track.joints[self.track.count] = angles
        self._stand(value[1])
        return (*(_NAN,) * 7, -1.0), i.here(at, end), end

    def _argument_end(self, i: _Instruction, at: int) -> int:
        """Where an argument ends: at a comma or option outside brackets."""
        depth, s = 0, i.statement
        for found in _PIECE.finditer(i.text, at, i.end - 1):
            mark = found[0]
            if mark in ("[", "(", "{"):
                depth += 1
            elif mark in ("]", ")", "}"):
                depth -= 1
            elif mark == "," and depth == 0:
                piece = i.text[at : found.start()]
                option = re.search(r"\\[^\\()\[\]]*$", piece)
                return at + option.start() if option and "(" not in piece[option.start() :] else found.start()
        self.module.refuse(s.start, f"{s.word}: target, speed, zone and tool are expected", "The line may be cut off.")

    def _constant(self, s: Statement, text: str, kind: str, shown: str) -> Value:
        try:
            value = self.names.value(text)
        except ExpressionError as e:
            self.module.refuse(s.start, f"{s.word}: {e}")
        if not isinstance(value, Runtime) and not fits(kind, value):
            self.module.refuse(s.start, f"{s.word}: {text.strip()[:40]!r} is not {shown}")
        return value

    def _tail(self, s: Statement, tail: str) -> tuple[float, float, int, int, bool]:
        """Feed mm/s, zone mm, tool, frame, and whether the speed is called a rapid's."""
        try:
            e = RapidExpression(tail, self.names.look_up)
            self._options(e)
            e.take(",")
            name = e.peek()
            speed, options = e.value(), self._options(e)
            e.take(",")
            zone, zone_options = e.value(), self._options(e)
            e.take(",")
            named = e.tokens[e.at][1] if e.at < len(e.tokens) else ""
            tool, tool_options = e.value(), self._options(e)
            if e.peek():
                raise ExpressionError(f"{e.peek()!r} is not expected")
        except ExpressionError as problem:
            self.module.refuse(s.start, f"{s.word}: {problem}")
        if "corr" in {**options, **tool_options}:
            self.module.refuse(s.start, f"{s.word}\\Corr: a path corrected by a sensor", "Take \\Corr away.")
        feed = self._part(s, speed, "speeddata", 0)
        if "t" in options:
            feed = _NAN
        if "v" in options:
            feed = self._part(s, [options["v"]], "", 0)
        if feed == 0.0:
            self.module.refuse(s.start, f"{s.word}: a speed of 0", "Give a speed above 0.")
        corner = 0.0 if isinstance(zone, list) and zone[0] is True else self._part(s, zone, "zonedata", 1)
        if "z" in zone_options:
            corner = self._part(s, [zone_options["z"]], "", 0)
        fast = name == "VMAX" or "RAPID" in name
        number = self.frames.tool(s, named, tool)
        return feed, corner, number, self.frames.workobject(s, tool_options.get("wobj")), fast

    def _options(self, e: RapidExpression) -> dict[str, Value]:
        out: dict[str, Value] = {}
        while e.peek() == "\\" or [word for _, word in e.tokens[e.at : e.at + 2]] == [",", "\\"]:
            e.take()
            if e.peek() == "\\":  # a comma may stand before an option
                e.take()
            name = e.take().lower()
            out[name] = True
            if e.peek() == ":=":
                e.take()
                out[name] = e.value()
        return out

    def _part(self, s: Statement, value: Value, kind: str, place: int) -> float:
        """A number of a record; NaN where only the controller knows it."""
        if isinstance(value, Runtime):
            return _NAN
        if kind and not fits(kind, value):
            self.module.refuse(s.start, f"{s.word}: {kind} expected")
        number = value[place]
        if isinstance(number, Runtime):
            return _NAN
        if not isinstance(number, float) or number < 0.0:
            self.module.refuse(s.start, f"{s.word}: speed or zone {number!r}, a number not below 0 expected")
        return number
