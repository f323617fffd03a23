"""KlartextActions: what the blocks of a Klartext program do: moves, M functions, tools, cycle calls."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from toolpaths.languages.heidenhain.block import SWALLOWING, KlartextBlock, expected, words
from toolpaths.languages.heidenhain.cycles import KlartextCycles
from toolpaths.languages.heidenhain.drilling import KlartextDrilling
from toolpaths.languages.heidenhain.formula import NUMBER, PARAMETER
from toolpaths.languages.heidenhain.motion import MM, PLACES, POLAR, ROTARY
from toolpaths.languages.heidenhain.words import M_REFUSED, M_SETTINGS
from toolpaths.machine import Machine
from toolpaths.reading.cnc_feed import PER_MINUTE, PER_TURN
from toolpaths.reading.machine_words import machine_commands
from toolpaths.reading.source_text import comment_word
from toolpaths.reading.tool_numbers import ToolNumbers
from toolpaths.reading.track import CUT_MARK, RAPID_MARK

_VALUE = rf"[-+]?\s*(?:{NUMBER}|{PARAMETER})"
_TOOL = re.compile(rf'(?:("[^"]*")|({NUMBER}|{PARAMETER}))?\s*(?:([XYZUVW])(?![A-Z]))?\s*(.*)')
_TOOL_WORD = re.compile(rf"\s*(?:(S|F|DL|DR2|DR)\s*({_VALUE})|(\S))")
_CORNER = re.compile(rf"R?\s*({_VALUE})\s*(.*)")
ENDS = frozenset((2, 30))


class KlartextActions(KlartextCycles):
    """Acts on the blocks of one file.

    Attributes:
        deltas: the tool was called with DR or DR2.
        acts: first word -> what is done about what stands behind it.
    """

    def __init__(self, source: str, machine: Machine | None) -> None:
        super().__init__(source, machine)
        self.deltas = False
        self._tools = ToolNumbers()
        self.acts: dict[str, Callable[[str, int], None]] = {
            "L": self._line, "LN": self._line, "LP": self._polar, "C": self._circle, "CP": self._polar_circle,
            "CC": self._pole, "CR": self._radius, "CT": self._tangential, "CTP": self._tangential_polar,
            "RND": self._rounding, "CHF": self._chamfer, "TOOL": self._tool, "CYCL": self._cycl, "PLANE": self._plane,
            "FUNCTION": self._function, "TRANS": self._trans, "M": self._functions,
        }  # fmt: skip

    # Moves

    def _line(self, text: str, line: int) -> None:
        block = words(text, self.q)
        self._check(block, PLACES | ROTARY | {"NX", "NY", "NZ", "TX", "TY", "TZ", "S"})
        if self.deltas and "NX" in block.values:
            raise ValueError("LN with a normal NX NY NZ while the tool has DR or DR2", "Let CAM compensate.")
        if 91 in block.ms or 92 in block.ms:
            self._retract(block, line)
        else:
            self._before(block, line)
            self.line_to(block, line)
        self._after(block, line, placed=not PLACES.isdisjoint(block.values))

    def _polar(self, text: str, line: int) -> None:
        self._moved(text, line, PLACES | POLAR, self.polar_line)

    def _circle(self, text: str, line: int) -> None:
        self._moved(text, line, PLACES, self.circle)

    def _polar_circle(self, text: str, line: int) -> None:
        self._moved(text, line, PLACES | POLAR, self.polar_circle)

    def _radius(self, text: str, line: int) -> None:
        self._moved(text, line, PLACES | {"R"}, self.circle_by_radius, radius=True)

    def _tangential(self, text: str, line: int) -> None:
        self._moved(text, line, PLACES, lambda block, at: self.tangential(block, at, polar=False))

    def _tangential_polar(self, text: str, line: int) -> None:
        self._moved(text, line, PLACES | POLAR, lambda block, at: self.tangential(block, at, polar=True))

    def _moved(
        self,
        text: str,
        line: int,
        allowed: frozenset[str] | set[str],
        act: Callable[[KlartextBlock, int], None],
        *,
        radius: bool = False,
    ) -> None:
        block = words(text, self.q, radius=radius)
        self._check(block, allowed)
        if block.unknown:
            raise ValueError("rotary words in an arc or polar line")
        self._before(block, line)
        act(block, line)
        self._after(block, line, placed=True)

    def _pole(self, text: str, line: int) -> None:
        block = words(text, self.q)
        self._check(block, PLACES)
        self.set_pole(block)

    def _rounding(self, text: str, line: int) -> None:
        self._corner("RND", text, line)

    def _chamfer(self, text: str, line: int) -> None:
        self._corner("CHF", text, line)

    def _corner(self, kind: str, text: str, line: int) -> None:
        match = expected(text, _CORNER, f"{kind} with its size")
        block = words(match[2], self.q)
        self._check(block, frozenset())
        self.corner_between(kind, self.q.number(match[1]), block, line)
        self._before(block, line)

    def _check(self, block: KlartextBlock, allowed: frozenset[str] | set[str]) -> None:
        if strange := block.values.keys() - allowed:
            raise ValueError(f"{', '.join(sorted(strange))}: this block does not have it")
        if block.compensation in ("RL", "RR"):
            problem = f"{block.compensation}: cutter compensation; let CAM compensate ('in computer')"
            raise ValueError(problem, "Post the path of the tool's centre with R0.")

    # M functions

    def _functions(self, text: str, line: int) -> None:
        """A block of M functions alone."""
        block = words(f"M{text}", self.q)
        self._check(block, frozenset(("S",)))
        self._before(block, line)
        self._after(block, line, placed=False)

    def _before(self, block: KlartextBlock, line: int) -> None:
        """M functions that act at the begin of a block."""
        said = []
        for m, given in block.ms.items():
            if m in M_REFUSED:
                raise ValueError(f"M{m}: {M_REFUSED[m]}")
            if m in (128, 129):
                self.choose_tip(on=m == 128, text=f"M{m}", line=line)
            elif m in (126, 127):
                self.shortest = m == 126
            elif m in (136, 137):
                if m == 136 and self.unit != MM:
                    raise ValueError("M136 in a program in inch")
                self.feed.choose(PER_TURN if m == 136 else PER_MINUTE)
            elif m == 103:
                self.plunge = given["F"] / 100.0 if "F" in given else None
                if self.plunge is not None and not self.plunge > 0:
                    raise ValueError("M103: a factor F above 0 is expected")
            elif m == 89:
                self.modal = True
            elif m == 140:
                self._draw_back(given, block, line)
            elif m not in M_SETTINGS and m not in (91, 92, 99):
                said.append(m)
        said = [m for m in said if m not in ENDS]
        if said:
            self.track.event(" ".join(f"M{m}" for m in said), line, *machine_commands(self.track, said))

    def _after(self, block: KlartextBlock, line: int, *, placed: bool) -> None:
        """M functions that act at the end of a block: M99, M89, the end of the program."""
        if 99 in block.ms or (self.modal and placed):
            self._drill(line)
            self.modal = self.modal and 99 not in block.ms
        if ENDS & block.ms.keys():
            self.end(line, f"M{min(ENDS & block.ms.keys())}")

    def end(self, line: int, word: str) -> None:
        """The program ends."""
        raise NotImplementedError

    def _draw_back(self, given: dict[str, float], block: KlartextBlock, line: int) -> None:
        """M140 MB: back along the tool axis, to the end of the travel or by a distance."""
        if not block.values.keys().isdisjoint(PLACES):
            raise ValueError("M140 beside coordinates", "Write it into a block of its own.")
        by = given.get("MB", math.inf)
        if by == math.inf:
            self.lose(("Z",), comment_word(self.text), line)
            return
        end = (self.at[0], self.at[1], self.at[2] + by * self.unit)
        feed = given["F"] * self.feed_unit / 60.0 if 0 < given.get("F", 0.0) < math.inf else math.nan
        self.go(RAPID_MARK if feed != feed else CUT_MARK, end, feed, line)

    def _retract(self, block: KlartextBlock, line: int) -> None:
        """M91, M92: coordinates of the machine."""
        text = comment_word(self.text)
        if block.feed != "MAX":
            raise ValueError(f"{text}: a feed move to a place of the machine", "Read is only a rapid: L Z.. FMAX M91.")
        self._before(block, line)
        if ROTARY & block.values.keys() or block.unknown:
            self._turn(block, alone=True)
        self.lose(sorted({name[-1] for name in PLACES & block.values.keys()}), text, line)

    # Tools

    def _tool(self, text: str, line: int) -> None:
        kind, _, rest = text.strip().partition(" ")
        if kind == "DEF":
            SWALLOWING.refuse(rest)
            self.track.event(comment_word(self.text), line)
            return
        match = _TOOL.match(rest.strip())
        if kind != "CALL" or not match:
            raise ValueError(f"TOOL {text.strip()[:40]}: TOOL CALL or TOOL DEF is expected")
        name, number, axis, more = match.groups()
        if axis not in (None, "Z"):
            raise ValueError(f"TOOL CALL with the tool axis {axis}: only Z is read")
        said = []
        if name or number:
            self.no_corner()
            self.tool = self._tools.of(name[1:-1] if name else self.q.number(number))
            said.append(f"T{self.tool}" if number else f"T={name} (tool {self.tool})")
            self.deltas = False
        for word, value, other in _TOOL_WORD.findall(more):
            if other:
                raise ValueError(f"{other!r} in TOOL CALL: no word that is read")
            if said_word := self._tool_word(word, self.q.number(value)):
                said.append(said_word)
        called = self.tool if name or number else None
        ms = () if called is None else (6,)  # the spindle stands
        speed = self.feed.speed if any(word.startswith("S") for word in said) else None
        if said:
            self.track.event(" ".join(said), line, *machine_commands(self.track, ms, speed=speed, tool=called))

    def _tool_word(self, word: str, value: float) -> str:
        if word == "S":
            self.feed.spin(value)
            return f"S{value:g}"
        if word == "F":
            self.tool_feed = value
            self.feed.give(value)
        elif word == "DL" and value:
            raise ValueError(f"DL{value:+g}: a length of the tool that is not that of the cell", "Let CAM compute it.")
        elif value:
            self.deltas = True
        return ""

    # Cycle calls

    def _cycl(self, text: str, line: int) -> None:
        kind, _, rest = text.strip().partition(" ")
        if kind == "CALL":
            self._call(rest.strip(), line)
        elif kind == "DEF":
            self.define(rest.strip(), line)
        else:
            raise ValueError(f"CYCL {text.strip()[:40]}: CYCL DEF or CYCL CALL is expected")

    def _call(self, text: str, line: int) -> None:
        """CYCL CALL, CYCL CALL POS X Y Z."""
        if text.startswith("PAT"):
            raise ValueError("CYCL CALL PAT: a pattern of the control", "Post each place.")
        at_place = text.startswith("POS")
        block = words(text[3:] if at_place else text, self.q)
        self._check(block, PLACES if at_place else frozenset())
        self._before(block, line)
        if at_place:
            if self.cycle is None:
                raise ValueError("CYCL CALL, but no drilling cycle is defined")
            self._go_over(block, line)
        self._drill(line)
        if ENDS & block.ms.keys():
            self.end(line, "M30")

    def _go_over(self, block: KlartextBlock, line: int) -> None:
        """To the place of CYCL CALL POS, at least at the clearance above its surface: up first, down last."""
        x, y, z = self._end(block)
        q = self.cycle.q if self.cycle else {}
        surface = z if {"Z", "IZ"} & block.values.keys() else q[203]
        if self.cycle:
            self.cycle = KlartextDrilling(self.cycle.number, {**q, 203: surface})
        high = max(self.at[2], surface + max(q[200], q.get(204, 0.0)))
        feed = self.rate(block)
        mark = RAPID_MARK if feed != feed else CUT_MARK
        if high != self.at[2]:
            self.go(mark, (self.at[0], self.at[1], high), feed, line)
        self.go(mark, (x, y, high), feed, line)
