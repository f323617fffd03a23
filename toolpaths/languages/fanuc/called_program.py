"""What a TP program that another one calls does to the arm, as far as its .ls lies beside."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from toolpaths.languages.fanuc.scan import Listing, TpStatement
from toolpaths.reading.swallowed import Swallowing

#: Instructions that move nothing and change no frame.
_INDEXED = "DO RO AO GO SO UO F M SR TIMER UALM MESSAGE PAYLOAD LBL"
#: As the page shows them -> pattern.
REMARKS: dict[str, str] = {f"{word}[n]": rf"{word}\[" for word in _INDEXED.split()} | {
    "WAIT": r"WAIT\b(?!.*TIMEOUT)",
    "PAUSE": "PAUSE$",
    "OVERRIDE=": r"OVERRIDE\s*=",
    "COL DETECT": "COL DETECT",
    "COL GUARD": "COL GUARD",
    "JOINT_MAX_SPEED": "JOINT_MAX_SPEED",
    "LINEAR_MAX_SPEED": "LINEAR_MAX_SPEED",
    "OFFSET CONDITION": "OFFSET CONDITION",
    "TOOL_OFFSET CONDITION": "TOOL_OFFSET CONDITION",
    "SKIP CONDITION": "SKIP CONDITION",
    "Arc Start, End": "Arc (?:Start|End)",
    "Weld Start, End": "Weld (?:Start|End)",
    "LOCK PREG": "LOCK PREG",
    "UNLOCK PREG": "UNLOCK PREG",
}
_HARMLESS = re.compile("|".join(REMARKS.values()))
#: What a remark must not hold.
SWALLOWING = Swallowing(
    re.compile(
        r"(?<![\w\[:])(?:[JLCA]\s+PR?\[|(?:CALL|RUN|JMP)\s|U(?:FRAME|TOOL)(?:_NUM|\[)|PR\[[^\]]*\]\s*=)|"
        r"(?:(?<==ON)|(?<==OFF)|(?<=[)\]\d]))\s+R\[[^\]]*\]\s*="
    ),
    "End each statement with ';'.",
)
#: Of these the ones that act on more than the program itself.
ACTS = re.compile(r"(?:DO|RO|AO|GO|SO|UO)\[|WAIT\b|PAUSE$|(?:Arc|Weld) (?:Start|End)")
_REGISTER = re.compile(r"P?R\[")
_CHOICE = re.compile(r"U(?:FRAME|TOOL)_NUM")
_FRAME = re.compile(r"U(?:FRAME|TOOL)\[")


@dataclass(frozen=True)
class CalledProgram:
    """A called program.

    Attributes:
        registers: whether it may set registers.
        moves: the first statement that may move the arm, or decides what runs.
        frames: a statement that sets a frame or tool to something.
        chooses: whether it may choose another frame or tool.
    """

    registers: bool = False
    moves: TpStatement | None = None
    frames: TpStatement | None = None
    chooses: bool = False


def harmless(text: str) -> bool:
    """Whether a statement moves nothing and changes no frame, nor any that it swallowed."""
    match = _HARMLESS.match(text)
    return match is not None and not SWALLOWING.problem(text, match.end())


def swallowed(text: str) -> str:
    """What is wrong with a statement that moves nothing itself; empty where nothing is, or it may move."""
    match = _HARMLESS.match(text)
    return SWALLOWING.problem(text, match.end()) if match else ""


def called(folder: Path, name: str) -> CalledProgram | None:
    """The program ``name`` in ``folder``; None where it is not there.

    Raises:
        ReadError: it is not a Fanuc program.
    """
    beside = [p for p in folder.glob("*") if p.suffix.lower() == ".ls" and p.stem.upper() == name.upper()]
    if not beside:
        return None
    registers, chooses = False, False
    moves: TpStatement | None = None
    for s in Listing(beside[0].read_bytes().decode("latin-1"), str(beside[0])).statements():
        if s.text.startswith(("!", "//", "--eg:")) or s.text in ("END", "ABORT") or harmless(s.text):
            continue
        if _FRAME.match(s.text):
            return CalledProgram(True, s, s, True)
        chooses = chooses or _CHOICE.match(s.text) is not None
        registers = registers or _REGISTER.match(s.text) is not None
        if not _CHOICE.match(s.text) and not _REGISTER.match(s.text):
            moves = moves or s
    nested = moves is not None  # a CALL in it, a condition: anything may happen there
    return CalledProgram(registers or nested, moves, None, chooses or nested)
