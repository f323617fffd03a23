"""Doubt: what is wrong with a measurement, or looks so, and has to be looked at before its result is believed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Doubt:
    """One finding about sessions.

    Attributes:
        where: the file, and the rows or the column in it.
        what: what was found, with its size, and what to do.
        count: of the rows that it is about.
        first: is the line of samples.csv that it begins with; None where it is about the whole file.
    """

    where: str
    what: str
    count: int = 1
    first: int | None = None

    def __str__(self) -> str:
        return f"{self.where}: {self.what}"
