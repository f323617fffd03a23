"""The words of APT/CL and NX CLSF: what the reader keeps, lets pass and refuses; statements out of lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from toolpaths.errors import ReadError
from toolpaths.reading.swallowed import Swallowing

# Text for people or for the machine between two moves: kept as events.
EVENTS = frozenset(
    {"PPRINT", "TPRINT", "INSERT", "REMARK", "MACHIN", "COOLNT", "STOP", "OPSTOP", "DELAY", "AUXFUN", "PREFUN", "CLAMP"}
    | {"SEQUENCE"}
)
# Words that neither move the tool nor change what a later word means: let pass on purpose.
PASSED = frozenset(
    {"PAINT", "DISPLY", "PPLOT", "PLOT", "PLABEL", "CLPRNT", "NOPOST", "SEQNO", "LEADER", "LETTER", "HEADER", "REWIND"}
    | {"ISN", "SELECT", "SELCTL", "INTOL", "OUTTOL", "TOLER", "LINTOL", "MCHTOL", "OFSTNO", "OPERTN", "AUTOPS"}
    | {"CSI_SET_FLUTE_LENGTH", "CSI_SET_EXTENSION_LENGTH"}
)
_ARC = "arcs in this form are not read; output CIRCLE with its GOTO, or GOTO points"
_TABLE = "a turning table; output the tool axis i, j, k instead"
_MACRO = "a macro: it is computed when the program is processed"
_SOURCE = "a motion along geometry: this is APT source; give the CL file that its processor writes"
_COORDINATES = "it changes the coordinates; output in one coordinate system"
LATHE = "a lathe's word; read are paths of a tool that mills or drills"
REFUSED: dict[str, str] = (
    dict.fromkeys(("ARCMOV", "ARC", "TLON", "ARCDAT"), _ARC)
    | dict.fromkeys(("ROTABL", "ROTATE", "ROTHED", "INDEX"), _TABLE)
    | dict.fromkeys(("CALL", "MACRO", "TERMAC", "IF", "JUMPTO", "LOOPST", "LOOPND", "READ"), _MACRO)
    | dict.fromkeys(("GOFWD", "GOBACK", "GOLFT", "GORGT", "GOUP", "GODOWN", "GO", "PSIS", "POCKET"), _SOURCE)
    | dict.fromkeys(("ORIGIN", "TRANS", "TRACUT", "SCALE", "MCS"), _COORDINATES)
    | dict.fromkeys(("TURRET", "THREAD", "PITCH"), LATHE)
    | {
        "NURBS": "splines are not read; output GOTO points",
        "COPY": "copied moves are not read; output them in full",
        "RETRCT": "the retract plane is the machine's; output a GOTO",
        "OPSKIP": "what is skipped at the machine is not known here; output without optional blocks",
        "SET": "it changes what numbers mean; output absolute coordinates",
    }
)
MM, INCH = 1e-3, 25.4e-3
UNIT_WORDS = {"MM": MM, "MILLIMETER": MM, "MILLIMETERS": MM, "INCH": INCH, "INCHES": INCH, "IN": INCH}

CREO = "->"  # Creo writes statements of its own as comments, and continues them with '$' as well
LARGEST = 1e9
UNIT_TOLERANCE = 1e-3  # how far the length of a direction may be from 1

_GOES_ON = re.compile(r"(?!PPRINT|TPRINT|INSERT|REMARK|PARTNO)[^$]*,\s*\$(?=\s)", re.IGNORECASE)  # a comment behind '$'
_WORD = r"TOOL\s+PATH|END-OF-PATH|TLON\s*,\s*GOFWD|[A-Z][A-Z0-9_]*"
_STATEMENT = re.compile(rf"\s*({_WORD})\s*(?:/(.*)|(\s.*))?$", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[ED][-+]?\d+)?")
_NUMBERS = re.compile(r"[-+0-9.eEdD, \t]*")

#: Words whose text is all of their line, whatever stands in it.
TEXTS = frozenset({"$$", "PPRINT", "TPRINT", "REMARK", "PARTNO", "INSERT"})
_BEGINS = (
    "GOTO|FROM|GODLTA|GOHOME|CIRCLE|MOVARC|INDIRV|CYCLE|FEDRAT|SPINDL|UNITS?|MSYS|CSYS|TRNTYP|TLAXIS|MULTAX|LOADTL|LOAD|"
    r"TOOLNO|CUTTER|TLDATA|CUTCOM|PARTNO|MODE|SETUP|CALSUB|TOOL\s+PATH|END-OF-PATH|GOFWD|TLON|COOLNT|PPRINT|INSERT"
)
#: A line that is no part of the statement before it.
_OWN = re.compile(rf"(?:(?:{_BEGINS})\s*/|(?:RAPID|FINI|END-OF-PATH|GOHOME|END)\s*$)", re.IGNORECASE)
#: A statement inside of another one.
SWALLOWING = Swallowing(re.compile(rf"(?<![\w-])(?:{_BEGINS})\s*/", re.IGNORECASE))
#: A move in the words of the machine, but for a retract.
_SENT = re.compile(
    r"(?!.*G0*(?:28|30|53)(?!\d))(?=.*[XYZ])(?:\s*[A-Z]\s*[-+]?(?:\d+\.?\d*|\.\d+))+\s*;?\s*", re.IGNORECASE
)


@dataclass(frozen=True, slots=True)
class AptStatement:
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


def refusal(source: str, statement: AptStatement, problem: str, remedy: str = "") -> ReadError:
    """The error that names line and statement."""
    return ReadError(source, statement.line, f"{str(statement)[:80]}: {problem}", remedy)


def statements(lines: list[str], source: str) -> Iterator[AptStatement]:
    """Statements and comments (word ``$$``) in their order.

    Raises:
        ReadError: a line is not a statement, a statement goes on into another one, or the file ends inside of one.
    """
    pending: list[str] = []
    begin = 0
    for count, raw in enumerate(lines, 1):
        text, _, comment = raw.partition("$$")
        comment, text = comment.strip(), text.strip()
        if comment.startswith(CREO) and not text and not pending:
            text = f"$${comment}"
        elif comment:
            yield AptStatement("$$", comment, count)
        if not text:
            continue
        begin = begin or count
        if pending and _OWN.match(text):
            problem = f"the statement goes on ('$') into line {count}, {text[:40]!r}, which is a statement of its own"
            raise ReadError(source, begin, problem, "Take the last '$' of the statement away.")
        if "$" in text and (goes_on := _GOES_ON.match(text)):
            text = goes_on[0]
        if text.endswith("$"):
            pending.append(text[:-1])
            continue
        text = "".join([*pending, text])
        yield AptStatement("$$", text[2:], begin) if text.startswith("$$") else _statement(text, begin, source)
        pending, begin = [], 0
    if pending:
        problem = "the file ends inside a statement continued with '$'"
        raise ReadError(source, begin, problem, "Output it again.")


def _statement(text: str, line: int, source: str) -> AptStatement:
    match = _STATEMENT.match(text)
    if match is None:
        problem = f"{text[:60]!r}: not an APT statement"
        raise ReadError(source, line, problem, "Give the CL or CLSF file as CAM wrote it.")
    word = " ".join(match[1].upper().replace(",", " , ").split()).replace(" , ", ",")
    return AptStatement(word, match[2] if match[2] is not None else (match[3] or ""), line)


def refuse_swallowed(source: str, s: AptStatement) -> None:
    """Refuse a statement that holds another one, and an INSERT that moves the machine.

    Raises:
        ReadError: as it says.
    """
    if s.word not in TEXTS and s.word != "TLON,GOFWD" and (problem := SWALLOWING.problem(str(s), len(s.word) + 1)):
        raise ReadError(source, s.line, problem, SWALLOWING.remedy)
    if s.word == "INSERT" and _SENT.fullmatch(s.text):
        raise refusal(source, s, "a block for the machine that moves it, past the path", "Output its moves as GOTO.")


def number(text: str) -> float | None:
    """The number that ``text`` (upper case) is, or None."""
    return float(text.replace("D", "E")) if _NUMBER.fullmatch(text) else None


def numbers(statement: AptStatement, counts: tuple[int, ...], source: str) -> list[float]:
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
        raise refusal(source, statement, f"{wanted} numbers below {LARGEST:g} are expected")
    return values
