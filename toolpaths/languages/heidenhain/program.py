"""KlartextUnit: one Klartext program: its blocks, labels and unit; and the programs beside that it may call."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.languages.heidenhain.block import blocks
from toolpaths.languages.heidenhain.motion import INCH, MM
from toolpaths.reading.source_text import load_lines

_BEGIN = re.compile(r"BEGIN\s+PGM\s+(.*?)\s*(MM|INCH)?\s*$")
_END = re.compile(r"END\s+PGM\s.*(?:MM|INCH)\s*$")
_LABEL = re.compile(r'LBL\s*("[^"]*"|\w+)')
_MOVES = re.compile(r"(?:L|LN|LP|C|CP|CR|CT|CTP|CYCL\s+CALL|CALL)(?![A-Z])")
_ROTARY = re.compile(r"(?<![A-Z])I?[ABC]\s*[-+.\dQ]")


@dataclass
class KlartextUnit:
    """One program.

    Attributes:
        source: its file in messages.
        blocks: line, text in capitals and comment of each.
        unit: m of a length.
        begin: block behind BEGIN PGM.
        stop: block of END PGM.
        labels: label -> block.
        ran: which blocks were executed.
    """

    source: str
    blocks: list[tuple[int, str, str]]
    unit: float
    begin: int
    stop: int
    labels: dict[str, int] = field(default_factory=dict)
    ran: bytearray = field(default_factory=bytearray)

    def __post_init__(self) -> None:
        self.ran = bytearray(len(self.blocks))
        for at, (_, text, _) in enumerate(self.blocks):
            if "LBL" in text and (label := _LABEL.match(text)) and label[1] != "0":
                self.labels.setdefault(label[1], at)

    def place(self, label: str) -> int:
        """The block behind a label.

        Raises:
            ValueError: there is none.
        """
        if label not in self.labels:
            raise ValueError(f"LBL {label[:40]}: there is no such label", "Is a part of the program missing?")
        return self.labels[label] + 1

    def turns(self) -> bool:
        """Whether it names rotary axes."""
        return any(_ROTARY.search(text) for _, text, _ in self.blocks if text[:1] == "L")

    def moves_behind(self, at: int) -> int | None:
        """Line of the first block behind one that moves the tool, or may, and stands in no subprogram."""
        inside = False
        for line, text, _ in self.blocks[at + 1 : self.stop]:
            if label := _LABEL.match(text):
                inside = label[1] != "0"
            elif not inside and _MOVES.match(text):
                return line
        return None

    def not_called(self, ended_at: int) -> list[tuple[str, int]]:
        """Labels behind the end of the program that nothing called, with their lines."""
        found = [(self.blocks[k], k) for k in range(ended_at + 1, self.stop) if not self.ran[k]]
        labels = [(_LABEL.match(text), line) for (line, text, _), _ in found]
        return [(label[1], line) for label, line in labels if label and label[1] != "0"]


def unit_of(lines: list[str], source: str) -> KlartextUnit:
    """The program of a file.

    Raises:
        ReadError: it has no begin, no unit or no end, or something behind it.
    """
    read = blocks(lines, source)
    found = [(line, text if text[:1] == "*" else _capitals(text), comment) for line, text, comment in read]
    count = len(found)
    first = next((k for k in range(count) if _code(found[k][1])), count - 1)
    line, text, _ = found[first] if found else (1, "", "")
    match = _BEGIN.match(text)
    if not match:
        problem = f"{text[:40]!r}: no Klartext program begins so, BEGIN PGM is expected"
        raise ReadError(source, line, problem, "Is this a file of another kind (.h of C, or G-code)?")
    if not match[2]:
        raise ReadError(source, line, "BEGIN PGM without MM or INCH: the unit is not known", "Write MM or INCH.")
    stop = next((k for k in range(first, count) if _END.match(found[k][1])), None)
    if stop is None:
        raise ReadError(source, None, "the program looks cut off: END PGM with its unit is missing", "Post it again.")
    if (behind := next((k for k in range(stop + 1, count) if _code(found[k][1])), None)) is not None:
        problem = f"{found[behind][1][:40]!r} behind END PGM"
        raise ReadError(source, found[behind][0], problem, "Two programs in one file?")
    unit = MM if match[2] == "MM" else INCH
    return KlartextUnit(source, found, unit, begin=first + 1, stop=stop)


def program_beside(name: str, path: Path, source: str) -> KlartextUnit:
    """The program of a file in the folder of ``path``.

    Args:
        name: as the caller has it, with or without folders of the control.
        path: the file of the caller.
        source: its name in messages.

    Raises:
        ValueError: there is no such file.
        ReadError: it cannot be read.
    """
    plain = re.split(r"[/\\:]", name.strip('"'))[-1]
    wanted = plain if "." in plain else f"{plain}.H"
    file = next((p for p in sorted(path.parent.iterdir()) if p.name.upper() == wanted.upper()), None)
    if file is None or file.suffix.upper() != ".H":
        raise ValueError(
            f"CALL PGM {name[:60]}: there is no {wanted[:60]} of Klartext beside the file", "Put it there."
        )
    beside = str(Path(source).with_name(file.name))
    return unit_of(load_lines(file, beside), beside)


def _code(text: str) -> str:
    """A block without remarks."""
    return "" if text[:1] in ("*", "%") else text.strip()


def _capitals(text: str) -> str:
    """Capitals, but for what stands in quotes."""
    if '"' not in text:
        return text.upper()
    return '"'.join(part if k % 2 else part.upper() for k, part in enumerate(text.split('"')))
