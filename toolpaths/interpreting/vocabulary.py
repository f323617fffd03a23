"""Vocabulary: the words of a language, and what its reader does with each. The pages are made of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

#: What a reader does with a word.
HONOURED, SETTING, REMARK, REFUSED = "honoured", "a setting", "skipped with a remark", "refused"


class Vocabulary(Mapping[str, str]):
    """Word -> what the reader does with it; a word that is not here is refused, too.

    Args:
        words: what is done -> the words, in one text with blanks between them, or one by one.

    Raises:
        ValueError: a word stands twice.
    """

    def __init__(self, words: Mapping[str, str | Iterable[str]]) -> None:
        self._done: dict[str, str] = {}
        for done, listed in words.items():
            for word in listed.split() if isinstance(listed, str) else listed:
                if word in self._done:
                    raise ValueError(f"{word!r} stands twice: {self._done[word]}, {done}")
                self._done[word] = done

    def __getitem__(self, word: str) -> str:
        return self._done[word]

    def __iter__(self) -> Iterator[str]:
        return iter(self._done)

    def __len__(self) -> int:
        return len(self._done)

    def __repr__(self) -> str:
        return f"Vocabulary({len(self)} words)"

    def those(self, done: str) -> tuple[str, ...]:
        """The words that this is done with, in their order."""
        return tuple(word for word, what in self._done.items() if what == done)
