"""The words of G-code, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.languages.gcode import codes
from toolpaths.languages.gcode.codes import RETRACTS, SETTINGS, G
from toolpaths.languages.gcode.machine_words import SENSES, SPINDLE_STOPS
from toolpaths.languages.gcode.words import LETTER_REFUSED, M_CALL, M_END, M_EVENTS

_SPINDLE = (*SENSES, *sorted(SPINDLE_STOPS))
VOCABULARY: dict[str, Vocabulary] = {
    "G words": Vocabulary(
        {
            HONOURED: [g.word for g in G if g not in SETTINGS | RETRACTS | {G.DWELL}],
            SETTING: [g.word for g in sorted(SETTINGS)],
            REMARK: [g.word for g in sorted(RETRACTS | {G.DWELL})],
            REFUSED: [f"G{key / 10:g}" for key in sorted(codes.REFUSED)],
        }
    ),
    "M words": Vocabulary(
        {
            HONOURED: [f"M{m}" for m in (*_SPINDLE, *M_END, M_CALL)],
            REMARK: [f"M{m}" for m in M_EVENTS if m not in _SPINDLE],
        }
    ),
    "letters": Vocabulary(
        {HONOURED: "X Y Z I J K R F S T N H P Q O L A B C D ,R ,C # [ ]", REFUSED: [*LETTER_REFUSED, "/"]}
    ),
}
