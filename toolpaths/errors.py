"""What goes wrong with files that describe motion."""

from __future__ import annotations


class ToolpathError(Exception):
    """A toolpath or program is refused. The message names file, line, value and remedy."""


class ReadError(ToolpathError):
    """A line of an input file is refused.

    Args:
        source: file as the user named it.
        line: line number, counted from 1; None when the file as a whole is meant.
        problem: what stands there and what was expected.
        remedy: what to do about it.
    """

    def __init__(self, source: str, line: int | None, problem: str, remedy: str = "") -> None:
        self.source, self.line, self.problem, self.remedy = source, line, problem, remedy
        place = source if line is None else f"{source}:{line}"
        super().__init__(f"{place}: {problem}" + (f". {remedy}" if remedy else ""))


class WriteError(ToolpathError):
    """A robot program cannot be written as asked."""
