"""A block of G-code as words: letters with numbers, G words and M words; what is none is refused, and why."""

from __future__ import annotations

import re

from toolpaths.errors import ReadError
from toolpaths.languages.gcode.codes import REFUSED, G

# one word: a letter and its number; the third group is anything else
WORD = re.compile(r"\s*(?:(,\s*[CR](?=[\s\d.])|[A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))|(\S))")
COMMENT = re.compile(r"\(([^()]*)\)|;(.*)")
FLOW = "SUB|ENDSUB|CALL|IF|ELSE|WHILE|DO|REPEAT|RETURN"
O_WORD = re.compile(rf"\s*(?:N\d+\s*)?(O\s*[<#\[\d][\w>\].]*\s*(?:{FLOW})|O\s*[<#\[])")
MACRO = re.compile(r"\b(?:IF|WHILE|GOTO|THEN|ENDIF|POPEN|DPRNT|DO\d|END\d)|GOTO")
STRANGER = re.compile(r"\s*([A-Z]{3}[A-Z_]*)")  # a word of another language

# stops, spindle, coolant, tool; clamps of tables (10, 11), spindle position (19), chips (31, 33), overrides (48, 49),
# coolant through the spindle (88, 89)
M_EVENTS = (0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 19, 31, 33, 48, 49, 88, 89)
M_END = (2, 30, 99)  # 99: the end of a program that another one calls
M_CALL, M_RETURN = 98, 99
PRINTER_M = frozenset({82, 83, 84, *range(104, 110), 117, 140, 190, 191, *range(200, 206), 220, 221, 862, 900})

LETTER_REFUSED: dict[str, str] = {
    "E": "an extruder word: this is a file for a 3D printer, not a milling program",
    **dict.fromkeys("UVW", "a second linear axis"),
}
SYMBOLS: dict[str, str] = {
    "#": "a variable: it is computed while the machine runs",
    "[": "an expression: it is computed while the machine runs",
    "=": "an assignment or expression",
    "*": "a checksum: this looks like a file for a 3D printer",
    "/": "block delete: whether the line counts is chosen at the machine; keep it or delete it",
    "(": "a comment that is not closed, or one inside another",
    ")": "a closing bracket without a comment",
    "%": "it stands alone in its line, at the begin and at the end of a program",
}

Words = dict[str, float]
LARGEST = 1e9


def split_block(text: str, source: str, line: int) -> tuple[Words, list[G], list[int]]:
    """Words of a block by letter, its G words and its M numbers.

    Args:
        text: upper case, without comments.

    Raises:
        ReadError: a character, letter or number that is not G-code, or a letter twice.
    """
    values: Words = {}
    gs: list[G] = []
    ms: list[int] = []
    for letter, number, other in WORD.findall(text):
        if other:
            raise ReadError(source, line, _what(other, text))
        if letter == "G":
            gs.append(_g_word(number, source, line))
        elif letter == "M":
            ms.append(_m_number(number, source, line))
        elif (letter := letter[:1] + letter[1:].strip()) in values:
            raise ReadError(source, line, f"the letter {letter} stands twice")
        elif letter in LETTER_REFUSED and not (letter == "E" and G.ACCURACY in gs):
            raise ReadError(source, line, f"{letter}{number[:20]}: {LETTER_REFUSED[letter]}")
        else:
            values[letter] = value = float(number)
            if not -LARGEST < value < LARGEST:
                raise ReadError(source, line, f"{letter}{number[:20]}: beyond {LARGEST:g}")
    return values, gs, ms


def flows(text: str) -> bool:
    """Whether a block has words that control the flow of the program."""
    return O_WORD.match(text) is not None or MACRO.search(text) is not None


def _what(other: str, text: str) -> str:
    """What a character that begins no word is part of."""
    if found := O_WORD.match(text):
        return f"{found[1].strip()[:30]!r}: an O-word, it controls the flow of the program; post without subprograms"
    told = next((c for c in other + text if c in SYMBOLS), other)  # X#1: the '#' is what matters
    found = MACRO.search(text)
    if not found and (stranger := STRANGER.match(text)):
        hint = ", as Fanuc and LinuxCNC have it"
        if "/" in text:
            hint = ": this looks like APT/CL, name the file .apt or .cls"
        return f"{stranger[1][:30]!r} is no word of G-code{hint}"
    if found:
        return f"{told!r} in a macro statement ({found[0]}): it is computed while the machine runs"
    return f"{told!r}: {SYMBOLS.get(told, 'not a G-code word')}"


def strip_comments(text: str) -> tuple[str, list[str]]:
    """The block without its comments, and the comments."""
    found = [(a or b).strip() for a, b in COMMENT.findall(text)]
    return COMMENT.sub(" ", text), [c for c in found if c]


_KNOWN = {int(g): g for g in G}
_G_WORDS: dict[str, G] = {}  # number as written -> word; a file repeats a few


def _g_word(number: str, source: str, line: int) -> G:
    word = _G_WORDS.get(number)
    if word is None:
        tenfold = float(number) * 10
        key = int(tenfold + 0.5) if tenfold < 1e5 else -1
        word = _KNOWN.get(key)
        if word is None or abs(tenfold - key) > 1e-9:
            raise ReadError(source, line, f"G{number[:20]}: {REFUSED.get(key, 'this reader does not know it')}")
        if len(_G_WORDS) < 1000:
            _G_WORDS[number] = word
    return word


def _m_number(number: str, source: str, line: int) -> int:
    value = float(number)
    if value not in M_EVENTS and value not in M_END and value != M_CALL:
        why = "this reader does not know it; take it out or post without it"
        if value in PRINTER_M:
            why = "a word of 3D printers; this is no milling program"
        elif value in (96, 97, 198):
            why = "a subprogram in another file, or from a line number on; post in one piece, or with M98 in one file"
        raise ReadError(source, line, f"M{number[:20]}: {why}")
    return int(value)
