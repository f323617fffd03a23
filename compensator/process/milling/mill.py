"""Mill: a path through a stock, and what is engaged and which force acts at every pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from compensator.process.milling.grid import empty_field, grown
from compensator.process.milling.kernels.chip import AP, AREA, ENTRY, EXIT, OUT_COLUMNS, PEAK, SUMS, VOLUME
from compensator.process.milling.kernels.field import DONE, Field
from compensator.process.milling.kernels.hits import SIDEWAYS
from compensator.process.milling.kernels.walk import IDLE, Tools, walk
from compensator.process.milling.kernels.writing import room_for, write_move
from compensator.process.milling.outline import envelope_of, lattice_for
from compensator.process.milling.path import MillingPath, prepared
from compensator.process.milling.remains import Remains
from compensator.process.milling.stock import Stock

Floats = npt.NDArray[np.float64]
Progress = Callable[[int, int], None]

BLOCK = 2000  # poses between two reports of progress
ACROSS = 1e-3  # share of the feed: less is the rounding of a file


@dataclass(frozen=True, repr=False)
class Cut:
    """What a path does to a stock, N poses; rapids, the first pose and moves without feed have no engagement.

    Attributes:
        path: what was asked.
        axes: (N, 3, 3) path axes in the work object, columns x, y, z; x is the feed that arrives.
        ap: (N,) m, height of the highest engaged point above the tip.
        entry, exit: (N,) rad, smallest and largest engaged angle; NaN in the air.
        area: (N,) m2 of the envelope that is engaged.
        removed: (N,) m3 that the move takes away.
        feed_per_tooth: (N,) m.
        shares: (N, 6, 6) force and moment on the tool about the TCP in path axes, per coefficient: ktc, krc, kac (m2,
            m3), kte, kre, kae (m, m2).
        coefficients: (6,) N/m2, N/m. peak: (N,) N with these.
        hits: (N,) bits of kernels/hits.py.
        remains: of the stock; None where no move cuts.
    """

    path: MillingPath
    axes: Floats
    ap: Floats
    entry: Floats
    exit: Floats
    area: Floats
    removed: Floats
    feed_per_tooth: Floats
    shares: Floats
    coefficients: Floats
    peak: Floats
    hits: npt.NDArray[np.int32]
    remains: Remains | None

    def __len__(self) -> int:
        return len(self.path)

    def __repr__(self) -> str:
        return f"Cut({len(self)} poses, {int(np.sum(self.engaged))} engaged)"

    @property
    def engaged(self) -> npt.NDArray[np.bool_]:
        """(N,) whether anything is cut."""
        return self.area > 0.0

    @cached_property
    def wrench(self) -> Floats:
        """(N, 6) N and N*m on the tool, mean over a turn, path axes, about the TCP."""
        return np.asarray(self.shares @ self.coefficients)

    @property
    def removal_rate(self) -> Floats:
        """(N,) m3/s, mean over the move."""
        way = np.linalg.norm(self.path.way, axis=1)
        moving = (way > 0) & (self.path.feed > 0)
        time = np.divide(way, self.path.feed, out=np.full(len(way), np.inf), where=moving)
        return np.asarray(self.removed / time)


def mill(
    path: MillingPath, stock: Stock, coefficients: Floats, *, cell: float,
    only: npt.NDArray[np.intp] | None = None, progress: Progress | None = None,
) -> Cut:  # fmt: skip
    """Cut a stock along a path.

    Args:
        coefficients: (6,) ktc, krc, kac N/m2, kte, kre, kae N/m.
        cell: m, spacing of the grid.
        only: poses where the engagement is asked for; None: all.
        progress: called with the number of poses that are done, and of all.
    """
    ready = prepared(path, cell)
    if only is not None:
        ready.poses.kind[np.setdiff1d(np.arange(len(path)), only)] = IDLE
    out, hits = np.zeros((len(path), OUT_COLUMNS)), np.zeros(len(path), dtype=np.int32)
    remains = None
    if len(ready.moves):
        field = empty_field(stock.solid, ready.moves, cell)
        envelope = envelope_of(path.cutters, cell)
        grid, tools = lattice_for(envelope), _tools(path, coefficients)
        done = 0
        while done < len(path):
            end = min(done + BLOCK, len(path))
            reached = walk(
                field, envelope, grid, poses=ready.poses, tools=tools, begin=done, end=end, out=out, hits=hits
            )
            if reached < end:
                field = grown(field)
            elif progress is not None:
                progress(reached, len(path))
            done = reached
        remains = Remains(_finished(field), stock, ready.poses.last)
    return _cut(path, ready.axes, out, hits, coefficients=coefficients, remains=remains)


def _finished(field: Field) -> Field:
    """The field with the moves that no pose asked for any more."""
    while field.state[DONE] < len(field.moves):
        if room_for(field, field.state[DONE]):
            write_move(field, field.state[DONE])
        else:
            field = grown(field)
    return field


def _sideways(path: MillingPath, axes: Floats) -> npt.NDArray[np.bool_]:
    """(N,) where a drill goes across its axis."""
    drill = np.array([c.shape == "drill" for c in path.cutters])[path.cutter]
    across = np.abs(np.sum(path.way * axes[:, :, 0], axis=1))
    return np.asarray(drill & (across > ACROSS * np.linalg.norm(path.way, axis=1)))


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


def _cut(
    path: MillingPath, axes: Floats, out: Floats, hits: npt.NDArray[np.int32], *, coefficients: Floats,
    remains: Remains | None,
) -> Cut:  # fmt: skip
    engaged = out[:, AREA] > 0.0
    shares = out[:, SUMS:].reshape(-1, 6, 6)
    shares *= (np.array([c.flutes for c in path.cutters])[path.cutter] / (2.0 * np.pi))[:, None, None]
    # with the spindle turning left the axes of the stand are left-handed: y back, and moments are axial vectors
    s = path.sense[:, None]
    shares[:, [1]] *= s[:, :, None]
    shares[:, [3, 5]] *= s[:, :, None]
    hits = hits | np.where(engaged & _sideways(path, axes), SIDEWAYS, 0).astype(np.int32)
    entry = np.where(engaged, np.maximum(out[:, ENTRY], -np.pi * (1 - 1e-6)), np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        per_tooth = np.where(~path.rapid, path.feed / path.teeth_per_second, 0.0)
    return Cut(
        path, axes, ap=out[:, AP], entry=entry, exit=np.where(engaged, out[:, EXIT], np.nan), area=out[:, AREA],
        removed=out[:, VOLUME], feed_per_tooth=per_tooth, shares=shares, coefficients=coefficients,
        peak=out[:, PEAK], hits=hits, remains=remains,
    )  # fmt: skip
