"""The text of a Fanuc .ls file as statements and position records, each with its place.

Sources: programs as controllers and RoboDK's and Autodesk's posts print them; FANUC R-30iB operator's manual
(position data, motion statements).
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass

from toolpaths.errors import ReadError
from toolpaths.languages.fanuc.config import bits_of

_SECTION = re.compile(r"(?:^|(?<=\r))(?:\xef\xbb\xbf)?/(PROG|ATTR|APPL|MN|POS|END)\b", re.M)
_LINE = re.compile(r"([^\r\n]*+)(\r\n|\r|\n|\Z)")
_LINE_END = re.compile(r"\r\n|\r|\n|\Z")
_NUMBERED = re.compile(r"\s*+(\d*+)\s*+:")
#: A line that is no part of the statement before it: it moves, calls, jumps, or sets what moves depend on.
_OWN = re.compile(r"[JLCA]\s+PR?\[|(?:CALL|RUN|JMP|IF|FOR|END|ENDIF|ELSE)\b|U(?:FRAME|TOOL)|P?R\[[^\]]*\]\s*=")
#: A line that goes on for sure.
_OPEN = re.compile(r"(?:\b(?:AND|OR)|[-+*/=(,<>])$")
LARGEST = 1e9  # mm or deg: beyond, a number is no position
_RECORD = re.compile(r"P\[(\d+)(?::[^\]\r\n]*)?\]\s*+\{([^{}]*+)\}\s*+;")
_GROUP = r"\s*GP1\s*:\s*UF\s*:\s*(\w+)\s*,\s*UT\s*:\s*(\w+)\s*,"
_NUMBER = r"\s*+=\s*+(-?(?:\d++\.?\d*+|\.\d++))\s*+"
_END = r"\s*+(?=,|GP|E1|$)"
_POSE = re.compile(
    _GROUP + r"\s*+CONFIG\s*+:\s*+'([^',]*)[^']*'\s*+,\s*+"
    + r",\s*+".join(rf"{k}{_NUMBER}{'mm' if k in 'XYZ' else 'deg'}\s*+" for k in "XYZWPR") + _END
)  # fmt: skip
_JOINTS = re.compile(_GROUP + r"\s*+" + r",\s*+".join(rf"J{i}{_NUMBER}deg\s*+" for i in range(1, 7)) + _END)
_FRAMES = re.compile(r"F|\d{1,3}")
#: An axis of what stands behind the six numbers, and the group that it belongs to.
_EXTERNAL = re.compile(r"(GP\d)\s*:|([A-Z]\d?)\s*=\s*(-?(?:\d+\.?\d*|\.\d+))\s*(?:mm|deg)")
#: Between two records: nothing but space.
_SPACE = re.compile(r"\s*")
FREE = -1  # a frame or tool number given as F: whatever is active


@dataclass(frozen=True, slots=True)
class TpStatement:
    """One instruction without its number; ``start`` is where its line begins, ``end`` behind its semicolon."""

    text: str
    line: int
    start: int
    end: int


External = tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class TpRecord:
    """A position of group 1: numbers as mm and deg (X Y Z W P R), or J1 ... J6 with ``bits`` -1.

    ``external``: E1 to E3 and the axes of other groups, such as ("E1", 600.0), ("GP2 J1", -30.0), mm or deg.
    """

    start: int
    end: int
    frame: int
    tool: int
    bits: int
    numbers: tuple[float, ...]
    external: External = ()


class Listing:
    """A .ls file in its sections.

    Attributes:
        text: one character a byte.
        records: number -> Record; None: never taught.
    """

    def __init__(self, text: str, source: str) -> None:
        self.text, self.source = text, source
        self._configs: dict[str, int] = {}
        self._numbers = {"F": FREE}
        self._externals: dict[str, External] = {"": ()}
        self._starts = [m.end() for m in _LINE_END.finditer(text)]
        at = self._sections()
        self.body = (self._next_line(at["MN"]), at.get("POS", at["END"]))
        self.records: dict[int, TpRecord | None] = {}
        if "POS" in at:
            self._read_records(self._next_line(at["POS"]), at["END"])

    def external(self) -> tuple[str, ...]:
        """Names of the external axes of all records."""
        return tuple(dict.fromkeys(name for values in self._externals.values() for name, _ in values))

    def line(self, offset: int) -> int:
        """Number of the line at an offset, counted from 1."""
        return bisect_right(self._starts, offset) + 1

    def refuse(self, offset: int, problem: str, remedy: str) -> ReadError:
        """The refusal of what stands at an offset."""
        return ReadError(self.source, self.line(offset), problem, remedy)

    def statements(self) -> Iterator[TpStatement]:
        """Instructions of /MN; a statement may go on over several lines until its semicolon."""
        parts: list[str] = []
        first = start = 0
        for m in _LINE.finditer(self.text, *self.body):
            raw = m[1]
            numbered = _NUMBERED.match(raw)
            piece = (raw[numbered.end() :] if numbered else raw).strip()
            if "  " in piece or "\t" in piece:
                piece = " ".join(piece.split())
            if parts and ((numbered and numbered[1]) or (_OWN.match(piece) and not _OPEN.search(parts[-1]))):
                problem = f"{' '.join(parts)[:40]!r} without ';' goes on into {piece[:40]!r}"
                raise self.refuse(start, problem, "End each statement with ';'.")
            if not parts:
                if not piece or piece == ";":
                    continue
                start, first = m.start(), self.line(m.start())
            parts.append(piece)
            if piece.endswith(";"):
                yield TpStatement(" ".join(parts)[:-1].rstrip(), first, start, m.start() + len(raw.rstrip()))
                parts = []
        if parts:
            raise self.refuse(start, f"{' '.join(parts)[:40]!r} without ';'", "The file may be cut off.")

    def _sections(self) -> dict[str, int]:
        at: dict[str, int] = {}
        for m in _SECTION.finditer(self.text):
            if m[1] == "PROG" and "PROG" in at:
                raise self.refuse(m.start(), "a second /PROG: two programs in one file", "Give each its own file.")
            if m[1] in at:
                raise self.refuse(m.start(), f"/{m[1]} stands twice", "Give the file that was posted.")
            at[m[1]] = m.start()
        for name in ("PROG", "MN", "END"):
            if name not in at:
                remedy = "Give a whole .ls file; it may be cut off."
                raise ReadError(self.source, None, f"there is no /{name}: not a Fanuc program", remedy)
        order = [at[n] for n in ("PROG", "ATTR", "APPL", "MN", "POS", "END") if n in at]
        if order != sorted(order):
            raise ReadError(self.source, None, "the sections are out of order", "Expected: /PROG /ATTR /MN /POS /END.")
        if rest := self.text[self._next_line(at["END"]) :].strip("\x1a \t\r\n"):
            raise ReadError(self.source, None, f"text behind /END: {rest[:30]!r}", "Give each program its own file.")
        return at

    def _next_line(self, offset: int) -> int:
        return self._starts[min(bisect_right(self._starts, offset), len(self._starts) - 1)]

    def _read_records(self, start: int, end: int) -> None:
        at = start
        for m in _RECORD.finditer(self.text, start, end):
            if _SPACE.fullmatch(self.text, at, m.start()) is None:
                break
            number = int(m[1])
            if number in self.records:
                raise self.refuse(m.start(), f"P[{number}] stands twice", "Keep one of them.")
            self.records[number] = self._record(m)
            at = m.end()
        if rest := self.text[at:end].strip():
            offset = at + len(self.text[at:end]) - len(self.text[at:end].lstrip())
            raise self.refuse(offset, f"{rest[:30]!r} is no position", "Expected: P[n]{ GP1: ... };")

    def _record(self, m: re.Match[str]) -> TpRecord | None:
        body = m[2]
        if found := _POSE.match(body):
            frame, tool, config, *texts = found.groups()
            bits = self._bits(m, config)
        elif found := _JOINTS.match(body):
            frame, tool, *texts = found.groups()
            bits = -1
        elif "**" in body:
            return None
        else:
            what = f"P[{m[1]}] is neither X Y Z W P R with CONFIG nor J1 to J6 of group 1"
            raise self.refuse(m.start(), what, "Record the position again, or delete it.")
        numbers = tuple(map(float, texts))
        if not all(abs(v) < LARGEST for v in numbers):
            raise self.refuse(m.start(), f"P[{m[1]}]: a number beyond {LARGEST:g}", "Record the position again.")
        external = self._external(body[found.end() :].strip())
        return TpRecord(
            start=m.start(),
            end=m.end(),
            frame=self._number(m, frame),
            tool=self._number(m, tool),
            bits=bits,
            numbers=numbers,
            external=external,
        )

    def _external(self, rest: str) -> External:
        if rest not in self._externals:
            group, out = "", []
            for named, axis, value in _EXTERNAL.findall(rest):
                group = f"{named} " if named else group
                out += [] if named else [(group + axis, float(value))]
            self._externals[rest] = tuple(out)
        return self._externals[rest]

    def _bits(self, m: re.Match[str], config: str) -> int:
        if config not in self._configs:
            try:
                self._configs[config] = bits_of(config)
            except ValueError:
                remedy = "Expected letters such as 'N U T, 0, 0, 0'."
                raise self.refuse(m.start(), f"P[{m[1]}]: CONFIG {config!r}", remedy) from None
        return self._configs[config]

    def _number(self, m: re.Match[str], text: str) -> int:
        if text not in self._numbers:
            if not _FRAMES.fullmatch(text):
                raise self.refuse(m.start(), f"P[{m[1]}]: frame number {text!r}", "Expected a number or F.")
            self._numbers[text] = int(text)
        return self._numbers[text]
