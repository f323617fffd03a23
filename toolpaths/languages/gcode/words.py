"""The words of G-code: which the reader acts on, which it lets pass, which it refuses, and why."""

from __future__ import annotations

import re

from toolpaths.errors import ReadError

# one word: a letter and its number; the third group is anything else
WORD = re.compile(r"\s*(?:([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))|(\S))")
COMMENT = re.compile(r"\(([^()]*)\)|;(.*)")
FLOW = "SUB|ENDSUB|CALL|IF|ELSE|WHILE|DO|REPEAT|RETURN"
O_WORD = re.compile(rf"\s*(?:N\d+\s*)?(O\s*[<#\[\d][\w>\].]*\s*(?:{FLOW})|O\s*[<#\[])")
MACRO = re.compile(r"\b(?:IF|WHILE|GOTO|THEN|ENDIF|POPEN|DPRNT|DO\d|END\d)|GOTO")
STRANGER = re.compile(r"\s*([A-Z]{3}[A-Z_]*)")  # a word of another language

CYCLES = (730, 810, 820, 830, 850)
SYSTEMS = {540: "G54", 550: "G55", 560: "G56", 570: "G57", 580: "G58", 590: "G59", 591: "G59.1", 592: "G59.2",
           593: "G59.3", 541: "G54.1"}  # fmt: skip
TIP_CONTROL = (434, 435)

# modal group -> its words; a block may hold one of each group. Keys are ten times the number: G91.1 -> 911
GROUPS: dict[str, tuple[int, ...]] = {
    "non-modal": (40, 280, 300, 520, 530, 920, 921, 922, 923),
    "motion": (0, 10, 20, 30, *CYCLES),
    "cycle end": (800,),  # a group of its own, as Fanuc has it: G0 G80 in one block is common
    "plane": (170, 180, 190),
    "units": (200, 210),
    "distance": (900, 910),
    "arc distance": (901, 911),
    "feed mode": (930, 940, 950),
    "cutter compensation": (400,),
    "tool length": (430, *TIP_CONTROL, 490),
    "work offset": tuple(SYSTEMS),
    "path control": (610, 611, 640),
    "smoothing": (51, 50, 80, 1870),
    "exact stop": (90,),
    "scaling": (500,),
    "mirror": (501,),
    "polar coordinates": (150,),
    "polar interpolation": (131,),
    "modal macro": (670,),
    "rotation": (690,),
    "spindle mode": (970,),
    "cycle return": (980, 990),
}
GROUP = {key: name for name, keys in GROUPS.items() for key in keys}

# Let pass on purpose: they choose what this reader does anyway (G13.1, G15, G40, G50, G50.1, G67, G69, G97), what the
# cell file says (G43 H: tool length), or how a machine rounds corners (G5 P, G5.1 Q, G8 P, G9, G61, G64, G187).
LONE = (50, 80, 131, 501, 1870)  # of them those that stand without coordinates

G_REFUSED: dict[int, str] = {
    **dict.fromkeys((410, 420, 411, 421), "cutter compensation; let CAM compensate ('in computer')"),
    **dict.fromkeys(
        (740, 760, 840, 860, 870, 880, 890),
        "a canned cycle other than G73, G81, G82, G83, G85; post with expanded cycles",
    ),
    100: "it writes offsets or data into the controller; post without it",
    **dict.fromkeys((52, 53), "a spline; post arcs or lines"),
    **dict.fromkeys((650, 660, 661), "a macro call"),
    **dict.fromkeys((680, 510, 511, 160, 681), "it turns, scales or bends the coordinates; post without it"),
    **dict.fromkeys((682, 683, 684, 531), "a tilted work plane; post with tool vectors (G43.4 I J K) or APT/CL"),
    **dict.fromkeys((431, 432, 440), "a tool length that this reader does not know; post with G43 H"),
    **dict.fromkeys((382, 383, 384, 385, 310), "probing"),
    70: "diameter mode of lathes",
    700: "inch on some controls, a turning cycle on others; write G20 for inch",
    710: "mm on some controls, a turning cycle on others; write G21 for mm",
    **dict.fromkeys((330, 331, 320), "threading"),
    960: "constant surface speed of lathes; post with G97",
}

# stops, spindle, coolant, tool; clamps of tables (10, 11), spindle position (19), chips (31, 33), overrides (48, 49),
# coolant through the spindle (88, 89)
M_EVENTS = (0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 19, 31, 33, 48, 49, 88, 89)
M_END = (2, 30, 99)  # 99: the end of a file that another one calls
PRINTER_M = frozenset({82, 83, 84, *range(104, 110), 117, 140, 190, 191, *range(200, 206), 220, 221, 862, 900})

LETTER_REFUSED: dict[str, str] = {
    "E": "an extruder word: this is a file for a 3D printer, not a milling program",
    **dict.fromkeys("UVW", "a second linear axis"),
    "D": "a tool radius offset; let CAM compensate ('in computer')",
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


def split_block(text: str, source: str, line: int) -> tuple[Words, list[int], list[int]]:
    """Words of a block by letter, its G keys (ten times the number) and its M numbers.

    Args:
        text: upper case, without comments.

    Raises:
        ReadError: a character, letter or number that is no G-code, or a letter twice.
    """
    values: Words = {}
    gs: list[int] = []
    ms: list[int] = []
    for letter, number, other in WORD.findall(text):
        if other:
            raise ReadError(source, line, _what(other, text))
        if letter == "G":
            gs.append(_g_key(number, source, line))
        elif letter == "M":
            ms.append(_m_number(number, source, line))
        elif letter in values:
            raise ReadError(source, line, f"the letter {letter} stands twice")
        elif letter in LETTER_REFUSED:
            raise ReadError(source, line, f"{letter}{number[:20]}: {LETTER_REFUSED[letter]}")
        else:
            values[letter] = value = float(number)
            if not -LARGEST < value < LARGEST:
                raise ReadError(source, line, f"{letter}{number[:20]}: beyond {LARGEST:g}")
    return values, gs, ms


def _what(other: str, text: str) -> str:
    """What a character that begins no word is part of."""
    if found := O_WORD.match(text):
        return f"{found[1].strip()[:30]!r}: an O-word, it controls the flow of the program; post without subprograms"
    told = next((c for c in other + text if c in SYMBOLS), other)  # X#1: the '#' says more than the X
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


_KEYS: dict[str, int] = {}  # number as written -> key; a file repeats a few


def _g_key(number: str, source: str, line: int) -> int:
    key = _KEYS.get(number)
    if key is None:
        tenfold = float(number) * 10
        key = int(tenfold + 0.5) if tenfold < 1e5 else -1
        if abs(tenfold - key) > 1e-9 or key not in GROUP:
            raise ReadError(source, line, f"G{number[:20]}: {G_REFUSED.get(key, 'this reader does not know it')}")
        if len(_KEYS) < 1000:
            _KEYS[number] = key
    return key


def _m_number(number: str, source: str, line: int) -> int:
    value = float(number)
    if value not in M_EVENTS and value not in M_END:
        why = "this reader does not know it; take it out or post without it"
        if value in PRINTER_M:
            why = "a word of 3D printers; this is no milling program"
        elif value in (96, 97, 98, 198):
            why = "a subprogram; post in one piece"
        raise ReadError(source, line, f"M{number[:20]}: {why}")
    return int(value)
