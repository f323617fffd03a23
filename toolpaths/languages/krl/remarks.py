"""Lines of KRL that move nothing and set nothing that moves depend on, and what they must not hold."""

from __future__ import annotations

import re

from toolpaths.reading.swallowed import Swallowing, shown, without_quotes

#: First words of such lines.
REMARKS = (
    "WAIT HALT CONTINUE INTERRUPT EXT EXTFCT EXTFCTP SIGNAL PULSE TRIGGER BRAKE IMPORT ANOUT ANIN CONFIRM RESUME "
    "CWRITE CLEAR"
)
HARMLESS = re.compile(rf"(GLOBAL\s+INTERRUPT|{'|'.join(REMARKS.split())})(?![\w$])", re.I)
#: Of these, and of BAS.SRC, what is about how the program runs: another language has its own.
QUIET = re.compile(
    r"(CONTINUE|(GLOBAL\s+)?INTERRUPT|EXT|EXTFCT|EXTFCTP|SIGNAL|IMPORT|CONFIRM|RESUME|CWRITE|BAS|IR_STOPM)(?![\w$])",
    re.I,
)
#: The subprogram that an interrupt or a trigger runs.
RUNS = re.compile(r"(?:(?:GLOBAL\s+)?INTERRUPT|TRIGGER)\s.*(?<!\w)DO\s+([A-Za-z_][\w$]*)\s*\(", re.I | re.S)
SWALLOWING = Swallowing(re.compile(r"(?<![\w$#.])(?:S?(?:PTP|LIN|CIRC)(?:_REL)?|SPLINE)(?![\w$])", re.I))
_WORDS = re.compile(r"[A-Za-z_$][\w$]*|[0-9.]+|\S")
_ALONE = frozenset(("HALT", "CONTINUE", "WAIT", "PULSE", "CONFIRM", "RESUME", "BRAKE", "CWRITE", "CLEAR"))
_BETWEEN = frozenset(("WAIT", "SEC", "FOR", "AND", "OR", "EXOR", "NOT", "B_AND", "B_OR", "B_EXOR", "B_NOT"))


def swallowed(text: str) -> str:
    """What is wrong with a line that holds another one behind its first word; empty: nothing."""
    first = _WORDS.match(text)
    if problem := SWALLOWING.problem(text, first.end() if first else 0):
        return problem
    if first is None or first[0].upper() not in _ALONE:
        return ""
    ended = first[0].upper() in ("HALT", "CONTINUE")
    for word in _WORDS.findall(without_quotes(text)[first.end() :]):
        name = (word[0].isalpha() or word[0] in "_$") and word.upper() not in _BETWEEN
        if ended and name:
            return f"{shown(text)!r} is more than one statement"
        ended = name or word[0].isdigit() or word in (")", "]")
    return ""
