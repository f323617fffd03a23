"""The text of a VAL3 program (.pgx) and of the data beside it (.dtx): statements with their places, data by name.

Sources: VAL3 XML Format, s7: Program/2, Data/2, Project/3; VAL3 Reference Manual (D28062804A), 3.2 data types.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from html import unescape
from pathlib import Path
from typing import NamedTuple

from toolpaths.interpreting.program_text import ProgramText
from toolpaths.reading.source_text import load_lines

_CODE = re.compile(r"<Code>\s*+(<!\[CDATA\[)?")
_PROGRAM = re.compile(r"<Program\b([^<>]*)>")
_TAG = re.compile(r"<(Data|Value|Local|Parameter)\b([^<>]*?)(/?)>")
_FILE = re.compile(r"<(?:Data|Program)\b[^<>]*\bfile\s*=\s*\"([^\"<>]*)\"")
_ATTRIBUTE = re.compile(r"([\w:]+)\s*=\s*\"([^\"]*)\"")
_STATEMENT = re.compile(r"[^\r\n\f]+")
_UNITS = re.compile(r"\bmillimeterUnit\s*=\s*\"([^\"<>]*)\"")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
LARGEST = 1e7  # of a number
Fields = Mapping[str, float | str]


class ValLine(NamedTuple):
    """A statement: its place in the text of the program, and its text."""

    start: int
    end: int
    text: str


@dataclass(frozen=True)
class ValData:
    """Values of one name: type in lower case, and what each element gives: numbers by field, words as text."""

    kind: str
    values: dict[int, Fields] = field(default_factory=dict)


class ValProgram(ProgramText):
    """The text of one program.

    Attributes:
        name: by which others call it.
        lines: the statements between begin and end.
        locals: its own data.
        parameters: whether it takes arguments.

    Raises:
        ReadError: it is no program; names the line.
    """

    def __init__(self, text: str, source: str) -> None:
        super().__init__(text, source)
        found = _PROGRAM.search(text)
        code = _CODE.search(text, found.end() if found else 0)
        if found is None or code is None:
            first = next(m for m in _STATEMENT.finditer(text) if m[0].strip())
            problem = f"{first[0].strip()[:40]!r}: not a VAL3 program, which has <Program> and <Code>"
            self.refuse(first.start(), problem, "Give a .pgx of VAL3 7.")
        if _PROGRAM.search(text, code.end()):
            self.refuse(_PROGRAM.search(text, code.end()).start(), "two programs in one file", "Give one file each.")  # type: ignore[union-attr]
        close = text.find("]]>" if code[1] else "</Code>", code.end())
        if close < 0 or not text.rstrip().endswith("</Programs>"):
            self.refuse(len(text), "the program looks cut off: </Code> or </Programs> is missing", "Save it again.")
        self.name = dict(_ATTRIBUTE.findall(found[1])).get("name", "")
        head = text[found.end() : code.start()]
        self.parameters = "<Parameter " in head
        self.locals = data_of(self, head, found.end())
        self.lines = self._statements(code.end(), close, escaped=not code[1])

    def _statements(self, start: int, end: int, *, escaped: bool) -> list[ValLine]:
        out = []
        for m in _STATEMENT.finditer(self.text, start, end):
            if plain := m[0].strip():
                out.append(ValLine(m.start(), m.end(), unescape(plain) if escaped else plain))
        if not out or out[0].text != "begin" or out[-1].text != "end":
            self.refuse(start if not out else out[-1].start, "a program is begin ... end", "It may be cut off.")
        return out[1:-1]


def data_of(text: ProgramText, part: str, at: int = 0) -> dict[str, ValData]:
    """The data of a part of a text that begins at ``at``: <Data> with values, <Local> with none.

    Raises:
        ReadError: a number that is none, an index twice.
    """
    out: dict[str, ValData] = {}
    into: ValData | None = None
    for m in _TAG.finditer(part):
        given = dict(_ATTRIBUTE.findall(m[2]))
        if m[1] == "Value":
            if into is not None:
                key = given.pop("key", "0")
                if not key.isdecimal() or len(key) > 6 or int(key) in into.values:
                    text.refuse(at + m.start(), f"key = {key[:20]!r}: a number that stands once is expected")
                into.values[int(key)] = {name: _value(text, at + m.start(), v) for name, v in given.items()}
            continue
        name = given.get("name", "").lower()
        if name in out:
            text.refuse(at + m.start(), f"{name[:40]} stands twice", "Keep one of them.")
        into = out[name] = ValData(given.get("type", "").lower())
        if m[1] == "Local":
            into.values[0] = {}
    return out


def _value(text: ProgramText, at: int, word: str) -> float | str:
    if _NUMBER.fullmatch(word):
        number = float(word)
        if abs(number) > LARGEST:
            text.refuse(at, f"{word[:20]!r}: a number that is too large", "Check the number.")
        return number
    return word


def data_beside(path: Path) -> Iterator[tuple[str, ValData]]:
    """Name and data of every .dtx that belongs to a program: those of the projects (.pjx) that list it, else its own.

    Raises:
        ReadError: one of them cannot be read, or lengths are inches.
    """
    beside = {p.name.lower(): p for p in sorted(path.parent.glob("*")) if p.suffix.lower() in (".dtx", ".pjx")}
    names = set()
    for project in (p for p in beside.values() if p.suffix.lower() == ".pjx"):
        text = _text(project)
        files = {Path(name.replace("\\", "/")).name.lower() for name in _FILE.findall(text.text)}
        if path.name.lower() in files:
            names |= {name for name in files if name.endswith(".dtx")}
            if (unit := _UNITS.search(text.text)) and unit[1].lower() != "true":
                text.refuse(unit.start(), f"millimeterUnit = {unit[1][:10]!r}: lengths in inches", "Save it in mm.")
    for name in sorted(names) or [f"{path.stem}.dtx".lower()]:
        if name in beside:
            text = _text(beside[name])
            yield from data_of(text, text.text).items()


def _text(file: Path) -> ProgramText:
    load_lines(file, str(file))
    return ProgramText(file.read_bytes().decode("latin-1"), str(file))
