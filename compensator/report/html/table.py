"""A table of a page, as plain text: the template escapes every cell."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

DASH = "\u2013"  # no value


@dataclass(frozen=True)
class Strong:
    """A cell with some words in bold, and the rest behind them."""

    strong: str
    rest: str = ""


Cell = str | Strong


@dataclass(frozen=True)
class PageTable:
    """Rows of cells under a head; ``right``: columns of figures, which are set flush right."""

    rows: Sequence[Sequence[Cell]]
    head: Sequence[str] = ()
    right: Collection[int] = ()
    caption: str = ""


@dataclass(frozen=True)
class OutlierRows:
    """Rows that were left out: how many, the first of them, and how many more there are ("" for none)."""

    count: str
    listed: PageTable
    more: str


def outlier_rows(rows: Sequence[Sequence[Cell]], most: int, head: Sequence[str], right: Collection[int]) -> OutlierRows:
    """The first ``most`` of the rows that were left out."""
    more = len(rows) - most
    listed = PageTable(rows[:most], head, right)
    return OutlierRows(f"{len(rows):,}" if rows else "", listed, f"{more:,}" if more > 0 else "")
