"""The words of CSV poses, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, Vocabulary
from toolpaths.languages.csv.header import AXIS, POSITION, QUATERNION
from toolpaths.languages.csv.reader import OPTIONAL

VOCABULARY: dict[str, Vocabulary] = {
    "columns": Vocabulary({HONOURED: [*POSITION, *AXIS, *QUATERNION, *OPTIONAL], REFUSED: ["any other"]})
}
