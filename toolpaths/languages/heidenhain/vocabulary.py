"""The words of HEIDENHAIN Klartext, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.languages.heidenhain import words
from toolpaths.languages.heidenhain.actions import KlartextActions
from toolpaths.languages.heidenhain.words import (
    CYCLES_OFF,
    CYCLES_PASSED,
    CYCLES_REFUSED,
    FUNCTIONS_REFUSED,
    M_REFUSED,
    M_SETTINGS,
    REMARKS,
)

_CYCLES_READ = (7, 10, 19, 200, 201, 203, 205, 240, 247)
VOCABULARY: dict[str, Vocabulary] = {
    "first words of blocks": Vocabulary(
        {
            HONOURED: [*KlartextActions("", None).acts, "LBL", "CALL", "FN", "BEGIN", "END"],
            REMARK: [*sorted(REMARKS), "*", ";"],
            REFUSED: sorted(words.REFUSED),
        }
    ),
    "M functions": Vocabulary(
        {
            HONOURED: [f"M{m}" for m in (2, 3, 4, 5, 13, 14, 30, 89, 99, 103, 126, 127, 128, 129, 136, 137)],
            SETTING: [f"M{m}" for m in sorted(M_SETTINGS)],
            REMARK: ["M91", "M92", "M140", "any other"],
            REFUSED: [f"M{m}" for m in sorted(M_REFUSED)],
        }
    ),
    "cycles and functions": Vocabulary(
        {
            HONOURED: [f"CYCL DEF {n}" for n in _CYCLES_READ],
            SETTING: [f"CYCL DEF {n}" for n in sorted(CYCLES_PASSED)],
            REFUSED: [
                *(f"CYCL DEF {n}" + " (but its end)" * (n in CYCLES_OFF) for n in sorted(CYCLES_REFUSED)),
                *(f"FN {n}" for n in sorted(FUNCTIONS_REFUSED)),
            ],
        }
    ),
}
