"""The words of INFORM, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import Vocabulary
from toolpaths.languages.inform.words import HEAD, WORDS

VOCABULARY: dict[str, Vocabulary] = {"head of a job": HEAD, "instructions": WORDS}
