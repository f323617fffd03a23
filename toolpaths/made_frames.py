"""Frames of a long path that are made where they are asked for: kept, rotations would be a third of what it holds."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from toolpaths.columns import Rows, blocks, put_in
from toolpaths.frame import Floats, Frame


def with_others(frames: Frame, rows: Rows, *, rotation: Floats | None = None, origin: Floats | None = None) -> Frame:
    """N frames, those at ``rows`` (K,), ascending, with other ``rotation`` (K, 3, 3), ``origin`` (K, 3), or both."""

    def change(some: Frame, chosen: Rows) -> Frame:
        return Frame(put_in(some.rotation, chosen, rows, rotation), put_in(some.origin, chosen, rows, origin))

    return frames.mapped(change) if len(rows) else frames


class MadeFrames(Frame):
    """N frames, as ``Frame``; ``take`` makes those that are asked for, ``rotation`` and ``origin`` make all.

    Args:
        count: N.
        make: rows (K,) -> K frames; the same for the same row, whatever other rows are asked for.
        origin: (N, 3) m of all, where that costs less than ``make``; None: it does not.
    """

    _count: int
    _make: Callable[[Rows], Frame]
    _origin: Callable[[], Floats] | None

    def __init__(
        self, count: int, make: Callable[[Rows], Frame], origin: Callable[[], Floats] | None = None
    ) -> None:
        self.__dict__.update(_count=count, _make=make, _origin=origin)

    @property
    def count(self) -> int:
        return self._count

    def __repr__(self) -> str:
        return f"MadeFrames({self.count} made poses)"

    @property
    def rotation(self) -> Floats:
        """(N, 3, 3), of all."""
        out = np.empty((self.count, 3, 3))
        for b in blocks(self.count):
            out[b] = self.take(b).rotation
        return out

    @property
    def origin(self) -> Floats:
        """(N, 3), of all."""
        if self._origin is not None:
            return self._origin()
        out = np.empty((self.count, 3))
        for b in blocks(self.count):
            out[b] = self.take(b).origin
        return out

    @property
    def z(self) -> Floats:
        out = np.empty((self.count, 3))
        for b in blocks(self.count):
            out[b] = self.take(b).z
        return out

    @classmethod
    def joined(cls, parts: Sequence[Frame]) -> Frame:
        """Of parts that follow each other."""
        ends = np.cumsum([part.count for part in parts])

        def make(rows: Rows) -> Frame:
            rotation, origin = np.empty((len(rows), 3, 3)), np.empty((len(rows), 3))
            which = np.searchsorted(ends, rows, side="right")
            for k in np.unique(which).tolist():
                here = which == k
                some = parts[k].take(rows[here] - (ends[k] - parts[k].count))
                rotation[here], origin[here] = some.rotation, some.origin
            return Frame(rotation, origin)

        return cls(int(ends[-1]), make, lambda: np.concatenate([part.origin for part in parts]))

    def take(self, rows: Rows | npt.NDArray[np.bool_] | slice | int) -> Frame:
        if isinstance(rows, slice):
            return self._make(np.arange(*rows.indices(self.count)))
        if np.ndim(rows) == 0:
            return self._make(np.array([rows], dtype=np.intp)).take(0)
        chosen = np.asarray(rows)
        return self._make(np.flatnonzero(chosen) if chosen.dtype == np.bool_ else chosen)

    def mapped(self, change: Callable[[Frame, Rows], Frame]) -> Frame:
        return MadeFrames(self.count, lambda rows: change(self._make(rows), rows))

    def turned(self, by: Callable[[Rows], Floats]) -> Frame:
        def made(rows: Rows) -> Frame:
            some = self._make(rows)
            return Frame(some.rotation @ by(rows), some.origin)

        return MadeFrames(self.count, made, self._origin)

    def at_origins(self, origin: Floats) -> Frame:
        return MadeFrames(self.count, lambda rows: Frame(self._make(rows).rotation, origin[rows]), lambda: origin)
