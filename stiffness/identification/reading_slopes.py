"""Reading slopes: derivatives of readings by numbers, small where these are tables of which a reading meets a few.

By the chain rule the derivative of a reading by a number of a table is its derivative by the joint's angle, times that
of the angle error by the number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt
from scipy import sparse

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

FEW = 4  # numbers of a joint: no more are no table


class Slopes(Protocol):
    """Derivatives of readings by ``count`` numbers, block by block; ``tabled``: a block has few of them."""

    @property
    def count(self) -> int: ...

    @property
    def tabled(self) -> bool: ...

    def block(self, rows: Index) -> tuple[Floats, Index]:
        """Of k readings (3k, c), and which numbers (c,)."""


@dataclass(frozen=True, repr=False, eq=False)
class SlopesOfRows:
    """Derivatives of K readings alone, asked for by their rows among all; ``place`` (N,): which of the K a row is."""

    slopes: Slopes
    place: Index

    @classmethod
    def of(cls, slopes: Slopes, rows: Index, readings: int) -> SlopesOfRows:
        """Of the ``rows`` (K,) of so many readings."""
        place = np.full(readings, -1)
        place[rows] = np.arange(len(rows))
        return cls(slopes, place)

    @property
    def count(self) -> int:
        """Numbers in all."""
        return self.slopes.count

    @property
    def tabled(self) -> bool:
        """Whether a block has few of the numbers."""
        return self.slopes.tabled

    def block(self, rows: Index) -> tuple[Floats, Index]:
        """As ``Slopes.block``."""
        return self.slopes.block(self.place[rows])


@dataclass(frozen=True, repr=False, eq=False)
class ReadingSlopes:
    """Derivatives of N readings by C numbers of any kind and by T numbers of tables.

    Attributes:
        count: numbers in all, those included that move nothing.
        core: (C,) which numbers ``dense`` (N, 3, C) belongs to.
        own: (T,) which numbers are those of tables; ``joint``: (T,) the joint that each acts on.
        by_angle: (N, 3, n) by an error of the joints' angles.
        slope: (M, T) of the error of its joint by each number, at M postures; ``of``: (N,) the posture of a reading.
    """

    count: int
    core: Index
    dense: Floats
    own: Index
    joint: Index
    by_angle: Floats
    slope: Floats
    of: Index

    @classmethod
    def plain(cls, dense: Floats) -> ReadingSlopes:
        """Of (N, 3, C) derivatives without tables."""
        n, _, count = dense.shape
        none = np.empty(0, dtype=np.intp)
        return cls(
            count=count,
            core=np.arange(count),
            dense=dense,
            own=none,
            joint=none,
            by_angle=np.empty((n, 3, 0)),
            slope=np.empty((0, 0)),
            of=np.zeros(n, dtype=np.intp),
        )

    def __repr__(self) -> str:
        return f"ReadingSlopes({len(self.dense)} readings, {len(self.core)} + {len(self.own)} numbers)"

    @property
    def tabled(self) -> bool:
        """Whether a block has few of the numbers."""
        return len(self.own) > FEW * int(self.by_angle.shape[2])

    def whole(self) -> Floats:
        """(N, 3, count) all of them."""
        out = np.zeros((*self.dense.shape[:2], self.count))
        out[:, :, self.core] = self.dense
        if len(self.own):
            out[:, :, self.own] = self.by_angle[:, :, self.joint] * self.slope[self.of][:, None]
        return out

    def turned(self, rotation: Floats) -> ReadingSlopes:
        """In other axes: ``rotation`` (N, 3, 3) or any other product from the left."""
        return replace(self, dense=rotation @ self.dense, by_angle=rotation @ self.by_angle)

    def block(self, rows: Index) -> tuple[Floats, Index]:
        """Of k readings (3k, c), the numbers of tables that none of them meets left out; and which numbers (c,)."""
        dense = self.dense[rows].reshape(3 * len(rows), -1)
        if not len(self.own):
            return dense, self.core
        slope = self.slope[self.of[rows]]
        met = np.flatnonzero(slope.any(axis=0))
        tabled = self.by_angle[rows][:, :, self.joint[met]] * slope[:, None, met]
        return np.hstack([dense, tabled.reshape(len(dense), -1)]), np.concatenate([self.core, self.own[met]])

    def over(self, sd: Floats, rows: Bools) -> Floats | sparse.csr_array:
        """(3K, count) of the K ``rows``, row by row over ``sd`` (K, 3)."""
        if not self.tabled:
            return np.asarray((self.whole()[rows] / sd[:, :, None]).reshape(3 * len(sd), -1))
        blocks, row, column = [], [], []
        for k, i in enumerate(np.flatnonzero(rows).tolist()):
            block, numbers = self.block(np.array([i]))
            blocks.append((block / sd[k][:, None]).ravel())
            row.append(np.repeat(np.arange(3 * k, 3 * k + 3), len(numbers)))
            column.append(np.tile(numbers, 3))
        triplets = np.concatenate(blocks), (np.concatenate(row), np.concatenate(column))
        return sparse.csr_array(triplets, shape=(3 * len(sd), self.count))

    def taken(self, numbers: Sequence[int], at: Sequence[int], count: int) -> ReadingSlopes:
        """Of some ``numbers``, which stand ``at`` these places among ``count``."""
        place, tabled = {int(k): i for i, k in enumerate(self.core)}, {int(k): i for i, k in enumerate(self.own)}
        core = [(place[k], to) for k, to in zip(numbers, at, strict=True) if k in place]
        own = [(tabled[k], to) for k, to in zip(numbers, at, strict=True) if k in tabled]
        first, second = (np.array([k for k, _ in some], dtype=np.intp) for some in (core, own))
        return replace(
            self,
            count=count,
            core=np.array([to for _, to in core], dtype=np.intp),
            dense=self.dense[:, :, first],
            own=np.array([to for _, to in own], dtype=np.intp),
            joint=self.joint[second],
            slope=self.slope[:, second],
        )
