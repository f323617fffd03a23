"""ThinnedPath: a path before poses were put in, made from the one that has them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np
import numpy.typing as npt

from compensator.path.planned_path import PlannedPath
from toolpaths.columns import blocks, made_from
from toolpaths.frame import Frame
from toolpaths.made_frames import MadeFrames
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


class ThinnedPath(PlannedPath):
    """The poses of a path that were there before others were put in; what both share is kept once.

    Args:
        path: the one before.
        finer: the one that is kept, of which ``path`` has the poses, bit by bit. put_in: (K,) the others of it.
    """

    _finer: PlannedPath
    _put_in: Rows
    _q: Callable[[], Floats]

    def __init__(self, path: PlannedPath, finer: PlannedPath, put_in: Rows) -> None:
        self.__dict__.update(
            _finer=finer, _put_in=put_in, turn=path.turn, branch=path.branch, programmed=path.programmed,
            chosen=path.chosen, instead=path.instead, axes=path.axes,
        )  # fmt: skip
        self.__dict__["_q"] = made_from(lambda: finer.q[self.rows], path.q)

    @property
    def rows(self) -> Rows:
        """(N,) where the poses stand in the finer path."""
        stand = np.ones(len(self._finer), dtype=np.bool_)
        stand[self._put_in] = False
        return np.flatnonzero(stand)

    @property
    def toolpath(self) -> Toolpath:
        """The poses, sampled."""
        return self._finer.toolpath.take(self.rows)

    @property
    def tcp(self) -> Frame:
        """(N) TCP in the base."""
        finer = self._finer.tcp
        return MadeFrames(len(self), lambda rows: finer.take(self.rows[rows]), lambda: finer.origin[self.rows])

    @property
    def q(self) -> Floats:
        """(N, n) rad, nominal inverse kinematics."""
        return self._q()

    def __len__(self) -> int:
        return len(self._finer) - len(self._put_in)


def thinned_path(path: PlannedPath, finer: PlannedPath) -> ThinnedPath | None:
    """``path`` as poses of ``finer``, which has more; None where one of them is another one, be it by a last digit."""
    at = np.searchsorted(finer.toolpath.row, path.toolpath.row)
    stands = np.zeros(len(finer), dtype=np.bool_)
    stands[np.minimum(at, len(finer) - 1)] = True
    rows = np.flatnonzero(stands)
    if len(rows) != len(path) or not _same(path.toolpath, finer.toolpath.take(rows)):
        return None
    for b in blocks(len(path)):
        one, other = path.tcp.take(b), finer.tcp.take(rows[b])
        if not (np.array_equal(one.rotation, other.rotation) and np.array_equal(one.origin, other.origin)):
            return None
    return ThinnedPath(path, finer, np.flatnonzero(~stands))


def _same(one: Toolpath, other: Toolpath) -> bool:
    """Whether two toolpaths are one and the same."""
    for f in fields(Toolpath):
        a, b = getattr(one, f.name), getattr(other, f.name)
        if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
            if a.dtype != b.dtype or not np.array_equal(a, b, equal_nan=a.dtype.kind == "f"):
                return False
        elif a is not b and (f.name == "setting" or a != b):
            return False
    return True
