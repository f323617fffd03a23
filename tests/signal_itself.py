"""The command line with a signal at a certain place: `python -m tests.signal_itself PLACE NUMBER ARGUMENTS...`.

PLACE is what --verbose says there, or the audit event of Python that is raised there, such as os.rename.
"""

from __future__ import annotations

import os
import signal
import sys
from typing import TextIO

from compensator.cli import main


class Listening:
    """A stream that watches for a word."""

    def __init__(self, stream: TextIO, word: str, number: int) -> None:
        self.stream, self.word, self.number = stream, word, number

    def __getattr__(self, name: str) -> object:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        if text.startswith(self.word):
            os.kill(os.getpid(), self.number)
        return self.stream.write(text)


if __name__ == "__main__":
    place, number, *arguments = sys.argv[1:]
    signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background of a shell it would be ignored
    if place.startswith("os."):
        sys.addaudithook(lambda event, _: os.kill(os.getpid(), int(number)) if event == place else None)
    else:
        sys.stderr = Listening(sys.stderr, place, int(number))  # type: ignore[assignment]
    main(arguments, prog_name="compensator")
