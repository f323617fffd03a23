"""Columns of a long path: worked on in blocks, made where they are asked for, kept once where nothing changes."""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Kind = TypeVar("Kind", bound=np.generic)

BLOCK = 65536  # rows at a time


def blocks(count: int, size: int | None = None) -> Iterator[slice]:
    """Ranges of rows that are worked on at one time, so that memory stays bounded; ``size``: None: BLOCK."""
    step = BLOCK if size is None else size
    for first in range(0, count, step):
        yield slice(first, min(first + step, count))


def once(values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
    """A column (N,), kept once where a long one has the same value in all rows, as that of a spindle that goes on."""
    if len(values) < BLOCK or (values[0] != values[-1] and values[0] == values[0]):
        return values
    same = np.broadcast_to(values[0], values.shape)
    return same if np.array_equal(values, same, equal_nan=True) else values


def put_in(values: Floats, chosen: Rows, rows: Rows, others: Floats | None) -> Floats:
    """Values (M, ...) of the rows ``chosen`` (M,), at those that are among ``rows`` (K,), ascending, the ``others`` (K,
    ...); None: there are none."""
    if others is None or not len(rows):
        return values
    at = np.minimum(np.searchsorted(rows, chosen), len(rows) - 1)
    here = rows[at] == chosen
    if not here.any():
        return values
    out = values.copy()
    out[here] = others[at[here]]
    return out


def made_from(base: Callable[[], Floats], values: Floats) -> Callable[[], Floats]:
    """What makes ``values`` (N, ...) from a column that is kept anyway: rows that differ from ``base`` are kept, all of
    them where most do."""
    apart = np.flatnonzero((base() != values).reshape(len(values), -1).any(axis=1))
    if 2 * len(apart) > len(values):
        return lambda: values
    own = values[apart]

    def made() -> Floats:
        out = base()
        if len(apart):
            out = out.copy()
            out[apart] = own
        return out

    return made


class MadeColumn:
    """A column of N rows that are made where they are asked for: ``column[rows]``, ``column[rows, [0, 2]]``, or
    ``np.asarray`` of all.

    Args:
        count: N.
        make: rows (K,) -> (K, ...).
    """

    def __init__(self, count: int, make: Callable[[Rows], Floats]) -> None:
        self._count, self._make = count, make

    def __repr__(self) -> str:
        return f"MadeColumn({self._count} rows)"

    def __len__(self) -> int:
        return self._count

    @property
    def shape(self) -> tuple[int, ...]:
        """As of an array."""
        return (self._count, *self[:1].shape[1:])

    def __getitem__(self, rows: Rows | slice | int | list[int] | tuple[Rows | slice, list[int]]) -> Floats:
        if isinstance(rows, tuple):
            return self[rows[0]][..., rows[1]]
        if isinstance(rows, slice):
            return self._make(np.arange(*rows.indices(self._count)))
        if isinstance(rows, int | np.integer):
            return np.asarray(self._make(np.array([rows], dtype=np.intp))[0])
        return self._make(np.asarray(rows))

    def rows(self, index: Rows) -> MadeColumn:
        """Rows ``index`` (K,) of it, as a column of their own."""
        return MadeColumn(len(index), lambda rows: self._make(index[rows]))

    def __array__(self, dtype: object = None, copy: bool | None = None) -> Floats:
        return np.concatenate([self[b] for b in blocks(self._count)])


Column = Floats | MadeColumn


def give_back() -> None:
    """Let the system have the memory that nobody uses any more: between the stages of a long path it is a fifth of all.

    The C library keeps it for what comes next; where it is not GNU's, this does nothing.
    """
    with contextlib.suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)
