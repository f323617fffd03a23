"""The words of VAL3, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import Vocabulary
from toolpaths.languages.val3.words import WORDS

VOCABULARY: dict[str, Vocabulary] = {"instructions, and fields that are assigned": WORDS}
