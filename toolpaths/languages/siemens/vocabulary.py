"""The words of SINUMERIK programs, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.languages.siemens import words
from toolpaths.languages.siemens.actions import ACTED, CALLED, G_ACTED, G_RETRACTS
from toolpaths.languages.siemens.words import EVENT_CALLS, G_REFUSED, G_SETTINGS, SETTING_VALUES, SETTINGS

VOCABULARY: dict[str, Vocabulary] = {
    "G words": Vocabulary(
        {
            HONOURED: [f"G{g}" for g in sorted(G_ACTED)],
            SETTING: [f"G{g}" for g in sorted(G_SETTINGS)],
            REMARK: [f"G{g}" for g in sorted(G_RETRACTS)],
            REFUSED: [f"G{g}" for g in sorted(G_REFUSED)],
        }
    ),
    "words and calls": Vocabulary(
        {
            HONOURED: sorted(ACTED | CALLED),
            SETTING: [*sorted(SETTINGS), *(f"{word}=" for word in sorted(SETTING_VALUES))],
            REMARK: sorted(EVENT_CALLS),
            REFUSED: sorted(words.REFUSED),
        }
    ),
}
