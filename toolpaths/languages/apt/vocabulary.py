"""The words of APT/CL, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.languages.apt import words
from toolpaths.languages.apt.reader import AptReader
from toolpaths.languages.apt.words import EVENTS, PASSED

#: Words that the reader looks at, and keeps as remarks.
REMARKS = ("$$", "PARTNO", "SETUP", "CALSUB", "GOHOME")
VOCABULARY: dict[str, Vocabulary] = {
    "major words": Vocabulary(
        {
            HONOURED: [word for word in AptReader("").acts if word not in REMARKS],
            SETTING: sorted(PASSED),
            REMARK: [*REMARKS, *sorted(EVENTS)],
            REFUSED: sorted(words.REFUSED),
        }
    )
}
