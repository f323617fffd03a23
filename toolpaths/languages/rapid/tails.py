"""Where a RAPID instruction without its ';' swallows the next one, which would vanish with it."""

from __future__ import annotations

import re

from toolpaths.interpreting.program_text import ProgramText

PIECE = re.compile(r'![^\n\r]*+|"(?:[^"\n\r]|"")*+"|[A-Za-z_]\w*|[0-9.]+(?:[eE][-+]?\d+)?|[)\]}]|[^\s]')
OPERATORS = frozenset(["AND", "OR", "XOR", "NOT", "DIV", "MOD"])
#: An instruction without arguments, and below it one that is a name, or sets one.
_BELOW = re.compile(r"[ \t]*(?:![^\n\r]*)?[\r\n]\s*([A-Za-z]\w*)\s*(?:;|:=)")


def is_name(piece: str) -> bool:
    """Whether a piece of text, in capitals, names something, or is an instruction."""
    return piece[0].isalpha() and piece not in OPERATORS


def ends_value(piece: str) -> bool:
    """Whether a value may end with a piece, in capitals."""
    return is_name(piece) or piece[0].isdigit() or piece in (")", "]", "}") or piece[0] == '"'


def second_instruction(text: str, start: int, end: int) -> int:
    """Where, behind the first word of an instruction, another one begins; -1: nowhere.

    Args:
        text: of the module.
        start: behind the first word.
        end: behind its ';'.
    """
    if below := _BELOW.match(text, start, end):
        return below.start(1)
    ended = False
    for piece in PIECE.finditer(text, start, end):
        word = piece[0].upper()
        if word[0] == "!":
            continue
        if ended and (is_name(word) or word[0] in '["' or word[0].isdigit()):
            return piece.start()
        ended = ends_value(word)
    return -1


def refuse_second(module: ProgramText, start: int, behind: int, end: int) -> None:
    """Refuse an instruction, or a declaration, that holds another one.

    Args:
        module: its text.
        start, behind, end: where it begins, what is looked into begins, and its ';' ends.

    Raises:
        ReadError: as it says.
    """
    second = second_instruction(module.text, behind, end)
    if second >= 0:
        first, what = (module.text[at:end].split("\n")[0].strip()[:30] for at in (start, second))
        problem = f"{first!r} has no end (;): {what!r} would be lost in it"
        module.refuse(start, problem, "End each instruction with ';'.")
