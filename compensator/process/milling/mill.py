"""Mill: a path through a stock, and what is engaged and which force acts at every pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.process.milling.grid import empty_field, grown
from compensator.process.milling.kernels.chip import AP, AREA, ENTRY, EXIT, OUT_COLUMNS, PEAK, SUMS, VOLUME
from compensator.process.milling.kernels.field import DONE, Field
from compensator.process.milling.kernels.hits import SIDEWAYS
from compensator.process.milling.kernels.walk import IDLE, Tools, walk
from compensator.process.milling.kernels.writing import room_for, write_move
from compensator.process.milling.outline import envelope_of, lattice_for
from compensator.process.milling.path import MillingPath, Prepared, arriving_axes, axes_with, prepared
from compensator.process.milling.remains import Remains
from compensator.process.milling.stock import Stock
from toolpaths.columns import blocks
from toolpaths.spilled_rows import SpilledRows

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Progress = Callable[[int, int], None]

BLOCK = 2000  # poses that are walked at one time, between two reports of progress
ACROSS = 1e-3  # share of the feed: less is the rounding of a file


@dataclass(frozen=True, repr=False)
class Cut:
    """What a path does to a stock, N poses; rapids, the first pose and moves without feed have no engagement.

    Attributes:
        path: what was asked.
        ap: (N,) m, height of the highest engaged point above the tip.
        entry, exit: (N,) rad, smallest and largest engaged angle; NaN in the air.
        area: (N,) m2 of the envelope that is engaged.
        removed: (N,) m3 that the move takes away.
        wrench: (N, 6) N and N*m on the tool, mean over a turn, about the TCP, in path axes or those asked for.
        force: (N,) N, size of the mean force.
        peak: (N,) N, largest over a turn.
        hits: (N,) bits of kernels/hits.py.
        shares: (N, 6, 6) ``wrench`` per coefficient: ktc, krc, kac (m2, m3), kte, kre, kae (m, m2); on the disk, as few
            of them are read. None: not kept.
        remains: of the stock; None where no move cuts.
    """

    path: MillingPath
    ap: Floats
    entry: Floats
    exit: Floats
    area: Floats
    removed: Floats
    wrench: Floats
    force: Floats
    peak: Floats
    hits: npt.NDArray[np.int32]
    shares: SpilledRows | None
    remains: Remains | None

    def __len__(self) -> int:
        return len(self.path)

    def __repr__(self) -> str:
        return f"Cut({len(self)} poses, {int(np.sum(self.engaged))} engaged)"

    @property
    def axes(self) -> Floats:
        """(N, 3, 3) path axes in the work object, columns x, y, z; x is the feed that arrives; made anew."""
        return arriving_axes(self.path)

    @property
    def engaged(self) -> npt.NDArray[np.bool_]:
        """(N,) whether anything is cut."""
        return self.area > 0.0

    @property
    def feed_per_tooth(self) -> Floats:
        """(N,) m."""
        return self.path.feed_per_tooth_at(slice(None))

    @property
    def removal_rate(self) -> Floats:
        """(N,) m3/s, mean over the move."""
        return self.removal_rate_at(np.arange(len(self)))

    def removal_rate_at(self, rows: Rows) -> Floats:
        """(K,) of ``removal_rate``, at poses."""
        way, feed = self.path.length_at(rows), self.path.feed[rows]
        time = np.divide(way, feed, out=np.full(len(way), np.inf), where=(way > 0) & (feed > 0))
        return np.asarray(self.removed[rows] / time)


def mill(
    path: MillingPath, stock: Stock, coefficients: Floats, *, cell: float, only: npt.NDArray[np.intp] | None = None,
    axes: Floats | None = None, shares: bool = False, progress: Progress | None = None,
) -> Cut:  # fmt: skip
    """Cut a stock along a path.

    Args:
        coefficients: (6,) ktc, krc, kac N/m2, kte, kre, kae N/m.
        cell: m, spacing of the grid.
        only: poses where the engagement is asked for; None: all.
        axes: (3, 3), or (N, 3, 3) of every pose, that turns the work object into the axes of ``wrench`` and ``shares``;
            None: these are path axes.
        shares: whether they are kept.
        progress: called with the number of poses that are done, and of all.
    """
    ready, count = prepared(path, cell), len(path)
    asked = np.ones(count, dtype=np.bool_)
    if only is not None:
        asked[:], asked[only] = False, True
        ready.kind[~asked] = IDLE
    cut = _nothing(path, shares=shares)
    if not len(ready.moves):
        return cut
    field = empty_field(stock.solid, ready.moves, cell)
    envelope = envelope_of(path.cutters, cell)
    grid, tools = lattice_for(envelope), _tools(path, coefficients)
    for b in blocks(count, BLOCK):
        if asked[b].any():
            first = max(b.start - 1, 0)  # what a move removes depends on the one before
            poses, stretch = ready.poses(slice(first, b.stop)), b.stop - first
            out, hits = np.zeros((stretch, OUT_COLUMNS)), np.zeros(stretch, dtype=np.int32)
            if first < b.start:
                out[0, VOLUME] = cut.removed[first]
            done = b.start - first
            while done < stretch:
                done = walk(
                    field, envelope, grid, poses=poses, tools=tools, begin=done, end=stretch, out=out, hits=hits
                )
                if done < stretch:
                    field = grown(field)
            new = slice(b.start - first, None)
            _keep(cut, ready, b, out=out[new], hits=hits[new], coefficients=coefficients, turn=axes)
        if progress is not None:
            progress(b.stop, count)
    return replace(cut, remains=Remains(_finished(field), stock, ready.last))


def _nothing(path: MillingPath, *, shares: bool) -> Cut:
    """A cut in the air, to be filled in stretch by stretch."""
    n = len(path)
    return Cut(
        path, ap=np.zeros(n), entry=np.full(n, np.nan), exit=np.full(n, np.nan), area=np.zeros(n), removed=np.zeros(n),
        wrench=np.zeros((n, 6)), force=np.zeros(n), peak=np.zeros(n), hits=np.zeros(n, dtype=np.int32),
        shares=SpilledRows(n, (6, 6)) if shares else None, remains=None,
    )  # fmt: skip


def _keep(
    cut: Cut, ready: Prepared, b: slice, *, out: Floats, hits: npt.NDArray[np.int32], coefficients: Floats,
    turn: Floats | None,
) -> None:  # fmt: skip
    """Fill in what ``walk`` found along a stretch: (K, 42) and hits (K,); ``turn``: as ``axes`` of ``mill``."""
    path, engaged = cut.path, out[:, AREA] > 0.0
    shares = out[:, SUMS:].reshape(-1, 6, 6)
    shares *= (np.array([c.flutes for c in path.cutters])[path.cutter[b]] / (2.0 * np.pi))[:, None, None]
    # with the spindle turning left the axes of the stand are left-handed: y back, and moments are axial vectors
    s = path.sense[b, None]
    shares[:, [1]] *= s[:, :, None]
    shares[:, [3, 5]] *= s[:, :, None]
    wrench = shares @ coefficients
    cut.force[b] = np.linalg.norm(wrench[:, :3], axis=1)
    if turn is not None:
        rotation = (turn if turn.ndim == 2 else turn[b]) @ axes_with(ready.feed[b], path.axis[b])
        shares = np.einsum("nij,nkjc->nkic", rotation, shares.reshape(-1, 2, 3, 6)).reshape(-1, 6, 6)
        wrench = shares @ coefficients
    cut.wrench[b] = wrench
    if cut.shares is not None:
        cut.shares.put(b, shares)
    cut.ap[b], cut.area[b], cut.removed[b], cut.peak[b] = (out[:, c] for c in (AP, AREA, VOLUME, PEAK))
    cut.entry[b] = np.where(engaged, np.maximum(out[:, ENTRY], -np.pi * (1 - 1e-6)), np.nan)
    cut.exit[b] = np.where(engaged, out[:, EXIT], np.nan)
    cut.hits[b] = hits | np.where(engaged & _sideways(path, ready.feed, b), SIDEWAYS, 0).astype(np.int32)


def _finished(field: Field) -> Field:
    """The field with the moves that no pose asked for any more."""
    while field.state[DONE] < len(field.moves):
        if room_for(field, field.state[DONE]):
            write_move(field, field.state[DONE])
        else:
            field = grown(field)
    return field


def _sideways(path: MillingPath, feed: Floats, b: slice) -> npt.NDArray[np.bool_]:
    """(K,) where a drill goes across its axis, along a stretch; ``feed``: (N, 3) x of the path axes."""
    drill, way = np.array([c.shape == "drill" for c in path.cutters])[path.cutter[b]], path.way_at(b)
    across = np.abs(np.sum(way * feed[b], axis=1))
    return np.asarray(drill & (across > ACROSS * np.linalg.norm(way, axis=1)))


def _tools(path: MillingPath, coefficients: Floats) -> Tools:
    cutters = path.cutters
    teeth = np.array([c.flutes for c in cutters], dtype=np.int32)
    step = np.zeros((len(cutters), int(teeth.max())))
    stack = np.zeros((len(cutters), max(1, *(len(c.stack) for c in cutters)), 4))
    for i, c in enumerate(cutters):
        step[i, : c.flutes] = c.tooth_steps
        stack[i, : len(c.stack)] = c.cylinders
    lag = np.array([c.lag for c in cutters])
    return Tools(teeth, lag, step=step, coefficients=np.asarray(coefficients, dtype=float), stack=stack)
