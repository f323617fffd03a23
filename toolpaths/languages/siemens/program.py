"""SiemensProgram: the programs of one file, their labels, and which IF, FOR, WHILE, LOOP and REPEAT ends where."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from toolpaths.errors import ReadError

_UNIT = re.compile(r"\s*%_N_([A-Z0-9_]+?)_([A-Z0-9]{3})\s*(?:;.*)?$", re.I)
_OLD_UNIT = re.compile(r"\s*%\s*(MPF|SPF)\s*(\d+)\s*(?:;.*)?$", re.I)
_PROC = re.compile(r"\s*(?:N\d+\s*)?PROC\s+([A-Z_][A-Z0-9_]*)", re.I)
_HEAD = r"\s*/?\d?\s*(?:[N:]\s*\d+\s*)?"
_LABEL = re.compile(rf"{_HEAD}([A-Z_][A-Z0-9_]+)\s*:(?!=)", re.I)
_NUMBER = re.compile(r"\s*/?\d?\s*([N:])\s*(\d+)", re.I)
_NESTS = re.compile(
    rf"{_HEAD}(?:[A-Z_]\w+\s*:\s*)?(IF|ELSE|ENDIF|FOR|ENDFOR|WHILE|ENDWHILE|LOOP|ENDLOOP|REPEAT|UNTIL)(?![A-Z0-9_])(.*)",
    re.I,
)
_JUMPS = re.compile(r"GOTO[FBC]?(?![A-Z0-9_])", re.I)
#: What each end, and ELSE, may close.
_BEGINS: dict[str, tuple[str, ...]] = {
    "ELSE": ("IF",), "ENDIF": ("IF", "ELSE"), "ENDFOR": ("FOR",), "ENDWHILE": ("WHILE",), "ENDLOOP": ("LOOP",),
    "UNTIL": ("REPEAT",),
}  # fmt: skip
PROGRAMS = ("MPF", "SPF")


@dataclass
class SiemensUnit:
    """One program.

    Attributes:
        name: in capitals; empty where the file gives none.
        kind: MPF, SPF or another kind of data (INI, TOA).
        source: file, as messages name it.
        lines: of the program, without the header line.
        first: line of the file, counted from 1, of the first of them.
        caller: line that its poses carry where it stands in another file; 0: their own.
        ran: which lines were executed.
    """

    name: str
    kind: str
    source: str
    lines: list[str]
    first: int
    caller: int = 0
    ran: bytearray = field(default_factory=bytearray)
    _labels: dict[str, list[int]] | None = None
    _partners: dict[int, int] | None = None

    def __post_init__(self) -> None:
        self.ran = bytearray(len(self.lines))

    def refusal(self, at: int, problem: str, remedy: str = "") -> ReadError:
        """The error that names a line."""
        return ReadError(self.source, self.first + at, problem, remedy)

    def find(self, label: str, at: int, way: str) -> int | None:
        """The line with a label or block number (N100), forward, backward or first forward then backward."""
        if self._labels is None:
            self._labels = self._read_labels()
        places = self._labels.get(label, [])
        forward = [p for p in places if p > at]
        backward = [p for p in places if p <= at]
        if way != "B" and forward:
            return forward[0]
        return backward[-1] if way != "F" and backward else None

    def partner(self, at: int) -> int:
        """Of IF: its ELSE or ENDIF; of ELSE: ENDIF; of FOR, WHILE, LOOP, REPEAT: the end; of an end: the begin.

        Raises:
            ReadError: there is none.
        """
        if self._partners is None:
            self._partners = self._match()
        if at not in self._partners:
            raise self.refusal(at, f"{self.lines[at].strip()[:40]!r}: its other end is missing")
        return self._partners[at]

    def _read_labels(self) -> dict[str, list[int]]:
        out: dict[str, list[int]] = {}
        for at, text in enumerate(self.lines):
            if (match := _LABEL.match(text)) and match[1].upper() not in ("DEFAULT",):
                out.setdefault(match[1].upper(), []).append(at)
            if match := _NUMBER.match(text):
                out.setdefault(f"{match[1].upper()}{int(match[2])}", []).append(at)
        return out

    def _match(self) -> dict[int, int]:
        out: dict[int, int] = {}
        open_: list[tuple[str, int]] = []
        for at, text in enumerate(self.lines):
            match = _NESTS.match(text)
            if not match:
                continue
            word, rest = match[1].upper(), match[2].split(";")[0].strip()
            if (word == "REPEAT" and rest) or (word == "IF" and _JUMPS.search(rest)):
                continue  # the repeat of a section; a jump
            if word in _BEGINS:
                opened = open_.pop() if open_ else ("", at)
                if opened[0] not in _BEGINS[word]:
                    raise self.refusal(at, f"{word} without its begin")
                out[opened[1]] = at
                if word == "ELSE":
                    open_.append((word, at))
                elif word != "ENDIF":
                    out[at] = opened[1]
            else:
                open_.append((word, at))
        if open_:
            raise self.refusal(open_[-1][1], f"{open_[-1][0]}: its end is missing", "Is a part of the program missing?")
        return out


class SiemensProgram:
    """The programs of one file.

    Args:
        lines: of the file.
        source: its name in messages.

    Attributes:
        units: in their order.
        main: the one that runs.

    Raises:
        ReadError: it holds none, or more than one main program.
    """

    def __init__(self, lines: list[str], source: str) -> None:
        self.source = source
        self.units = split(lines, source)
        programs = [u for u in self.units if u.kind in PROGRAMS]
        mains = [u for u in programs if u.kind == "MPF"] or programs[:1]
        if not mains:
            raise ReadError(
                source, None, "there is no program (MPF or SPF) in the file", "Give the archive of the program."
            )
        if len(mains) > 1:
            problem = f"{mains[1].name or 'a second program'}: two main programs, {mains[0].name} is the first"
            raise mains[1].refusal(
                -1 if mains[1].first > 1 else 0, problem, "Two programs in one file? Give one file each."
            )
        self.main = mains[0]

    def called(self, name: str) -> SiemensUnit | None:
        """The program of a name."""
        return next((u for u in self.units if u.name == name and u.kind in PROGRAMS), None)


def split(lines: list[str], source: str) -> list[SiemensUnit]:
    """The units of a file, at the headers of an archive; a file without headers is one program."""
    heads: list[tuple[int, str, str]] = []
    for at, text in enumerate(lines):
        if "%" not in text:
            continue
        if match := _UNIT.match(text):
            heads.append((at, match[1].upper(), match[2].upper()))
        elif match := _OLD_UNIT.match(text):
            heads.append((at, f"{'L' if match[1].upper() == 'SPF' else ''}{int(match[2])}", match[1].upper()))
    if not heads:
        named = next((m for text in lines[:50] if (m := _PROC.match(text))), None)
        return [SiemensUnit(named[1].upper() if named else "", "MPF", source, lines, first=1)]
    before = next((at for at, text in enumerate(lines[: heads[0][0]]) if text.split(";")[0].strip()), None)
    if before is not None:
        problem = "words before the first program header %_N_..._MPF"
        raise ReadError(source, before + 1, problem, "Two programs in one file?")
    ends = [*(at for at, _, _ in heads[1:]), len(lines)]
    return [
        SiemensUnit(name, kind, source, lines[at + 1 : end], first=at + 2)
        for (at, name, kind), end in zip(heads, ends, strict=True)
    ]
