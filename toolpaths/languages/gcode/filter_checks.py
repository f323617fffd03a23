"""Whether a G-code file can be filtered in place: rotary words, tool vectors, poses planned elsewhere."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.languages.gcode.codes import BY_DIAMETER, SPINDLE_CYCLES, TIP_CONTROLS, G
from toolpaths.languages.gcode.reader import ROTARY
from toolpaths.languages.gcode.spelling import words_of
from toolpaths.languages.gcode.words import strip_comments
from toolpaths.toolpath import CUT
from toolpaths.writing.program import Floats, Program

LINE = re.compile(r"([^\r\n\f]*)(\r\n|\r|\n|\f|$)")
COMPUTED = re.compile(r"[#\[=]|,\s*[RrCc]|[Mm]\s*0*98(?![\d.])")
WORD = re.compile(r"[Gg]\s*0*(?:4[12]|68|8[469])")
KEPT = SPINDLE_CYCLES | BY_DIAMETER | {G.CUTTER_LEFT, G.CUTTER_RIGHT, G.TILTED_PLANE}
VECTORS = re.compile(r"G\s*0*43\.[45]", re.I)


def check(source: bytes, path: Path) -> None:
    """Refuse a file whose poses cannot be put in place, before anything is solved.

    Raises:
        WriteError: names the line.
    """
    for k, (text, _) in enumerate(LINE.findall(source.decode("latin-1"))):
        if (COMPUTED.search(text) or WORD.search(text)) and (word := _kept(text)):
            why = f"{word} cannot be corrected in place. Write the program in the robot's language"
            raise WriteError(f"{path}:{k + 1}: {why}")
        if ROTARY.search(text) and any(w.letter in "ABC" for w in words_of(text)):
            raise WriteError(
                f"{path}:{k + 1}: rotary words cannot be corrected in place. Write the program in the robot's language"
            )


def _kept(text: str) -> str:
    """The word of a line whose moves are not those that stand in it, or that other words cannot say."""
    words = words_of(text)
    if found := next((w for w in words if w.letter == "G" and w.key in KEPT), None):
        return G(found.key).word
    computed = COMPUTED.search(strip_comments(text)[0])
    return computed[0].upper() if computed else ""


def says_turns(source: bytes) -> bool:
    """Whether the file has words for the tool's axis."""
    lines = (text for text, _ in LINE.findall(source.decode("latin-1")) if VECTORS.search(text))
    return any(w.letter == "G" and w.key in TIP_CONTROLS for text in lines for w in words_of(text))


def refuse_moved(program: Program, row: Floats, ends: Floats, path: Path) -> None:
    """Refuse poses that were planned elsewhere than the file has them."""
    whole = np.flatnonzero((np.abs(row - np.round(row)) < 1e-9) & (program.kind == CUT))
    if program.nominal_position is None or not len(whole):
        return
    away = np.abs(program.nominal_position[whole] - ends[np.round(row[whole]).astype(np.intp)]).max(axis=1)
    if (far := ~(away <= 1e-6)).any():
        k = int(np.argmax(far))
        place = f"{path}:{program.line[whole[k]]}"
        raise WriteError(f"{place}: the pose was planned {away[k] * 1e3:g} mm from where the file has it")
