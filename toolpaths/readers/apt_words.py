"""The words of APT/CL and NX CLSF: what the reader keeps, lets pass and refuses; statements out of lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from toolpaths.errors import ReadError

# Text for people or for the machine between two moves: kept as events.
EVENTS = frozenset(
    {"PARTNO", "PPRINT", "TPRINT", "INSERT", "REMARK", "MACHIN", "TLDATA", "CUTTER", "COOLNT"}
    | {"STOP", "OPSTOP", "DELAY"}
)
# Words that neither move the tool nor change what a later word means: let pass on purpose.
PASSED = frozenset(
    {"PAINT", "DISPLY", "PPLOT", "CLPRNT", "NOPOST", "SEQNO", "LEADER", "SELECT", "SELCTL"}
    | {"INTOL", "OUTTOL", "TOLER", "CSI_SET_FLUTE_LENGTH", "CSI_SET_EXTENSION_LENGTH"}
)
REFUSED: dict[str, str] = {
    "CYCLE": "a canned cycle; output the drilling moves as GOTO",
    "CUTCOM": "cutter compensation; output the compensated path",
    "GODLTA": "relative moves are not read yet; output GOTO",
    "GOHOME": "the place of home is not in the file",
    "ARCMOV": "arcs in this form are not read yet; output GOTO points",
    "MOVARC": "arcs in this form are not read yet; output GOTO points",
    "INDIRV": "arcs in this form are not read yet; output GOTO points",
    "NURBS": "splines are not read; output GOTO points",
    "COPY": "copied moves are not read yet; output them in full",
    "ORIGIN": "it moves the origin; output in one coordinate system",
    "TRANS": "it moves the coordinates; output in one coordinate system",
    "ROTABL": "a turning table; output the tool axis i, j, k instead",
    "ROTATE": "a turning table; output the tool axis i, j, k instead",
    "RETRCT": "the retract plane is the machine's; output a GOTO",
    "CALL": "a macro: it is computed when the program is processed",
    "MACRO": "a macro: it is computed when the program is processed",
    "GOFWD": "a motion along geometry: this is APT source; give the CL file that its processor writes",
}
MM, INCH = 1e-3, 25.4e-3
UNIT_WORDS = {"MM": MM, "MILLIMETER": MM, "MILLIMETERS": MM, "INCH": INCH, "INCHES": INCH, "IN": INCH}
FEED_WORDS: dict[str, tuple[float | None, bool]] = {  # m of the length unit (None: of UNITS), per revolution?
    "MMPM": (MM, False),
    "MMPR": (MM, True),
    "IPM": (INCH, False),
    "IPR": (INCH, True),
    "PERMIN": (None, False),
    "PERREV": (None, True),
}

LARGEST = 1e9

_STATEMENT = re.compile(r"\s*(TOOL\s+PATH|END-OF-PATH|[A-Z][A-Z0-9_]*)\s*(?:/(.*)|(\s.*))?$", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[ED][-+]?\d+)?")
_NUMBERS = re.compile(r"[-+0-9.eEdD, \t]*")


@dataclass(frozen=True)
class Statement:
    """One statement, continuation lines joined.

    Attributes:
        word: major word in upper case.
        text: what follows it, as written.
        line: line it begins on, counted from 1.
    """

    word: str
    text: str
    line: int

    @property
    def minor(self) -> list[str]:
        """What follows, split at commas, upper case."""
        parts = [part.strip().upper() for part in self.text.split(",")]
        return [] if parts == [""] else parts

    def __str__(self) -> str:
        return f"{self.word}/{self.text.strip()}" if self.text.strip() else self.word


def statements(lines: list[str], source: str) -> Iterator[Statement]:
    """Statements and comments (word ``$$``) in their order.

    Raises:
        ReadError: a line that is no statement, or a continuation that the file ends in.
    """
    pending, begin = "", 0
    for number, raw in enumerate(lines, 1):
        text, mark, comment = raw.partition("$$")
        if mark and comment.strip():
            yield Statement("$$", comment.strip(), number)
        text = text.strip()
        if not text:
            continue
        if text.endswith("$"):
            pending, begin = pending + text[:-1], begin or number
            continue
        text, first = pending + text, begin or number
        pending, begin = "", 0
        match = _STATEMENT.match(text)
        if match is None:
            problem = f"{text[:60]!r}: not an APT statement"
            raise ReadError(source, first, problem, "Give the CL or CLSF file as CAM wrote it.")
        word = " ".join(match[1].upper().split())
        yield Statement(word, match[2] if match[2] is not None else (match[3] or ""), first)
    if pending:
        problem = "the file ends inside a statement continued with '$'"
        raise ReadError(source, begin, problem, "Output it again.")


def number(text: str) -> float | None:
    """The number that ``text`` (upper case) is, or None."""
    return float(text.replace("D", "E")) if _NUMBER.fullmatch(text) else None


def numbers(statement: Statement, counts: tuple[int, ...], source: str) -> list[float]:
    """All that follows the word as numbers, as many as one of ``counts``.

    Raises:
        ReadError: something else than numbers, or another count.
    """
    text = statement.text
    try:
        if not _NUMBERS.fullmatch(text):
            raise ValueError
        values = [float(part) for part in text.replace("D", "E").replace("d", "e").split(",")]
    except ValueError:
        values = []
    if len(values) not in counts or not all(-LARGEST < v < LARGEST for v in values):
        wanted = " or ".join(map(str, counts))
        raise ReadError(
            source, statement.line, f"{str(statement)[:80]}: {wanted} numbers below {LARGEST:g} are expected"
        )
    return values
