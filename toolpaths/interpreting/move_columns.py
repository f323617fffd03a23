"""MoveColumns: numbers and marks of moves as they come, row by row, kept in few bytes a move."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpaths import columns
from toolpaths.columns import once

Floats = npt.NDArray[np.float64]
Marks = npt.NDArray[np.integer[Any]]


class MoveColumns:
    """Rows of named numbers and marks; those of a block become columns, of which one that does not change is one value.

    Args:
        numbers, marks: names of the columns.
    """

    def __init__(self, numbers: Sequence[str], marks: Sequence[str]) -> None:
        self._names, self._mark_names = tuple(numbers), tuple(marks)
        self._numbers, self._marks = array("d"), array("q")
        self._pieces: dict[str, list[npt.NDArray[np.generic]]] = {name: [] for name in (*numbers, *marks)}
        self.count = 0

    def __repr__(self) -> str:
        return f"MoveColumns({self.count} rows)"

    def append(self, numbers: tuple[float, ...], marks: tuple[int, ...]) -> None:
        """One row."""
        self._numbers.extend(numbers)
        self._marks.extend(marks)
        self.count += 1
        if self.count % columns.BLOCK == 0:
            self._put_away()

    def numbers(self, *names: str) -> Floats:
        """(N, K) of K columns, which are given away."""
        taken = [self._taken(name) for name in names]
        pieces = [p for column in taken for p in column]
        if self.count >= columns.BLOCK and all(p.strides == (0,) and np.isnan(p[0]) for p in pieces):
            return np.broadcast_to(np.nan, (self.count, len(names)))  # such as the points that arcs pass, without arcs
        out = np.empty((self.count, len(names)))
        for k in range(len(names)):
            np.concatenate(taken[k], out=out[:, k])
            taken[k] = []
        return out

    def number(self, name: str) -> Floats:
        """(N,) a column, which is given away."""
        return once(np.concatenate(self._taken(name), dtype=np.float64))

    def mark(self, name: str) -> Marks:
        """(N,) a column, which is given away."""
        return once(np.concatenate(self._taken(name)))

    def _taken(self, name: str) -> list[npt.NDArray[np.generic]]:
        self._put_away()
        pieces, self._pieces[name] = self._pieces[name], []
        return pieces

    def _put_away(self) -> None:
        for names, rows in ((self._names, self._numbers), (self._mark_names, self._marks)):
            table = np.array(rows, dtype=rows.typecode).reshape(-1, len(names))
            for name, values in zip(names, table.T, strict=True):
                if len(values):
                    self._pieces[name].append(_small(values))
        self._numbers, self._marks = array("d"), array("q")


def _small(values: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """A column of its own, places in four bytes where they are small enough."""
    kept = once(values)
    if kept.dtype == np.int64 and abs(int(kept.max())) < 2**31 and abs(int(kept.min())) < 2**31:
        kept = np.broadcast_to(np.int32(kept[0]), kept.shape) if kept.strides == (0,) else kept.astype(np.int32)
    return kept if kept is not values else values.copy()
