"""RereadText: the text of a program of many files, of which those are held that are looked at.

A million moves are a sixth of a gigabyte of text, in hundreds of modules: each is looked at when it is read, when its
moves run, and when it is written.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.interpreting.program_text import LinkedText, ProgramText

HELD = 16_000_000  # characters; a file that is let go is read again


class RereadText(LinkedText):
    """As LinkedText; files beside the main one are read again where they are asked for."""

    def __init__(self, main: ProgramText) -> None:
        self.parts: tuple[ProgramText, ...] = (main,)
        self.source, self.begins = main.source, [0]
        self._held = {0: main.text}  # the one that was looked at last comes last
        self._sizes, self._sums = [len(main.text)], [0]
        self._near = (0, len(main.text), main.text)

    def add(self, part: ProgramText) -> None:
        """One more file; places in the others stay what they are."""
        k = len(self.parts)
        self.begins.append(self.length + 1)
        self.parts = (*self.parts, part)
        self._sizes.append(len(part.text))
        self._sums.append(zlib.crc32(part.text.encode("latin-1")))
        self._hold(k, part.text)

    @property
    def length(self) -> int:
        """Of the whole."""
        return self.begins[-1] + self._sizes[-1]

    def piece(self, start: int, end: int) -> str:
        """The text from one place to another in one file."""
        text, begin = self.around(start)
        return text[start - begin : end - begin]

    def around(self, at: int) -> tuple[str, int]:
        """The text of the file that holds a place, and where it begins."""
        begin, end, text = self._near
        if not begin <= at <= end:
            k = self.part(at)
            begin, text = self.begins[k], self.text_of(k)
            self._near = begin, begin + self._sizes[k], text
        return text, begin

    def pieces(self, start: int, end: int) -> Iterator[str]:
        """What stands from one place to another, file by file."""
        for k in range(self.part(start), len(self.parts)):
            begin = self.begins[k]
            if begin >= end:
                return
            yield self.text_of(k)[max(start - begin, 0) : end - begin]

    def text_of(self, k: int) -> str:
        """The text of a part.

        Raises:
            ReadError: its file is another one by now.
        """
        if k in self._held:
            text = self._held.pop(k)
        else:
            file = self.parts[k].source
            try:
                text = Path(file).read_bytes().decode("latin-1")
            except OSError as problem:
                raise ReadError(file, None, f"cannot be read again: {problem.strerror}") from None
            if zlib.crc32(text.encode("latin-1")) != self._sums[k]:
                raise ReadError(file, None, "the file was changed while it was read", "Run it again.")
        self._hold(k, text)
        return text

    def _hold(self, k: int, text: str) -> None:
        self._held[k] = text
        for old in [j for j in self._held if j not in (0, k)]:
            if sum(map(len, self._held.values())) <= HELD:
                break
            del self._held[old]
