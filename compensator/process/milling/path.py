"""Milling path: the poses that a cut is computed for, and what the kernels take of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.kernels.profile import PROFILE_COLUMNS
from compensator.process.milling.kernels.rows import complete_rows, look_back, runs_of_path
from compensator.process.milling.kernels.sweep import RADIUS, REACH
from compensator.process.milling.kernels.walk import CUTTING, IDLE, RAPID_MOVE, PathPoses
from toolpaths.columns import blocks

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]
Rows = npt.NDArray[np.intp]

LOOK_BACK = 0.25e-3  # m of path: an engaged depth above NONE is left to within 0.5 deg of the flank of the cutter
ALONG = 1e-6  # share of the feed across the axis: less is a plunge


@dataclass(frozen=True, repr=False)
class MillingPath:
    """N poses in the work object; what belongs to a move stands at the pose where it ends.

    Attributes:
        position: (N, 3) m, tip of the cutter; axis: (N, 3) unit, from the tip to the spindle.
        feed: (N,) m/s; spindle: (N,) rev/s, above 0; sense: (N,) 1 for M3, -1 for M4.
        rapid: (N,) whether the move is a rapid.
        cutter: (N,) index into ``cutters``.
        programmed: (N, 3) m of the moves without the deflection that is in ``position``; None: it has none. They turn
            the path axes: from one side of a corner to the other the deflection moves the tool farther than its feed.
    """

    position: Floats
    axis: Floats
    feed: Floats
    spindle: Floats
    sense: npt.NDArray[np.int8]
    rapid: npt.NDArray[np.bool_]
    cutter: Ints
    cutters: tuple[Cutter, ...]
    programmed: Floats | None = None

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"MillingPath({len(self)} poses, {len(self.cutters)} cutters)"

    def way_at(self, b: slice) -> Floats:
        """(K, 3) m of the moves that end at the poses of a stretch, as they are programmed; 0 at the first pose."""
        if self.programmed is not None:
            return self.programmed[b]
        return self.position[b] - self.position[_before(b)]

    @property
    def way(self) -> Floats:
        """(N, 3) m of the move that ends at the pose, as it is programmed; 0 at the first one."""
        return self.way_at(slice(0, len(self)))

    @property
    def length(self) -> Floats:
        """(N,) m of the move that ends at the pose, as it is programmed."""
        return np.concatenate([np.linalg.norm(self.way_at(b), axis=1) for b in blocks(len(self))])

    def length_at(self, rows: Rows) -> Floats:
        """(K,) of ``length``, at poses."""
        way = self.position[rows] - self.position[np.maximum(rows - 1, 0)]
        return np.asarray(np.linalg.norm(way if self.programmed is None else self.programmed[rows], axis=1))

    def teeth_at(self, rows: slice | Rows) -> Floats:
        """(K,) teeth per second at poses."""
        return np.asarray(self.spindle[rows] * np.array([c.flutes for c in self.cutters])[self.cutter[rows]])

    def feed_per_tooth_at(self, rows: slice | Rows) -> Floats:
        """(K,) m at poses; 0 at rapids."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(~self.rapid[rows], self.feed[rows] / self.teeth_at(rows), 0.0)


def _before(b: slice) -> Rows:
    """The pose before each of a stretch; the first one before itself."""
    return np.asarray(np.maximum(np.arange(b.start, b.stop) - 1, 0))


def arriving_axes(path: MillingPath) -> Floats:
    """(N, 3, 3) columns x, y, z: z of the TCP, x the feed that arrives, normal to z, y = z cross x.

    Along z the last x of a cutting move is kept; poses before any take the first that comes.
    """
    return axes_with(arriving_feed(path), path.axis)


def axes_with(feed: Floats, axis: Floats) -> Floats:
    """(K, 3, 3) path axes of ``arriving_feed`` (K, 3) and tool axis (K, 3)."""
    z = -axis
    return np.stack([feed, np.cross(z, feed), z], axis=2)


def arriving_feed(path: MillingPath) -> Floats:
    """(N, 3) unit, x of ``arriving_axes``."""
    x, good = np.empty((len(path), 3)), np.empty(len(path), dtype=np.bool_)
    for b in blocks(len(path)):
        way, z = path.way_at(b), -path.axis[b]
        across = way - z * np.sum(way * z, axis=1, keepdims=True)
        size = np.linalg.norm(across, axis=1)
        good[b] = ~path.rapid[b] & (size > ALONG * np.linalg.norm(way, axis=1)) & (size > 0)
        x[b] = across / np.where(good[b], size, 1.0)[:, None]
    if not good.any():
        x[0], good[0] = _some_normal(-path.axis[0]), True
    held = x[np.argmax(good)].copy()  # the last one that is good, of the blocks before
    for b in blocks(len(path)):
        last = np.maximum.accumulate(np.where(good[b], np.arange(b.start, b.stop), -1))
        mine = np.where((last < 0)[:, None], held, x[np.maximum(last, b.start)])
        if last[-1] >= 0:
            held = x[last[-1]].copy()
        x[b] = _normal_to(-path.axis[b], mine)
    return x


def _normal_to(z: Floats, x: Floats) -> Floats:
    """(K, 3) unit, the part of ``x`` (K, 3) across ``z`` (K, 3)."""
    x = x - z * np.sum(x * z, axis=1, keepdims=True)
    for k in np.flatnonzero(np.linalg.norm(x, axis=1) < 1e-9):  # kept from a pose where z stood along it
        x[k] = _some_normal(z[k])
    return np.asarray(x / np.linalg.norm(x, axis=1, keepdims=True))


def _some_normal(z: Floats) -> Floats:
    n = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    return np.asarray(n / np.linalg.norm(n))


@dataclass(frozen=True, repr=False)
class Prepared:
    """A path as kernels take it.

    Attributes:
        path: what was asked.
        kind: (N,) of the move that ends at a pose, see PathPoses.
        feed: (N, 3) unit, x of the path axes.
        begun: (N,) first pose whose move does not count as made; ahead: (N,) m that the cutter is moved on instead.
        moves: (M, 29) that cut; last: (M,) pose at which each is done.
        move: (N,) row of moves under way at a pose; share: (N,) of it that is done.
    """

    path: MillingPath
    kind: npt.NDArray[np.uint8]
    feed: Floats
    begun: Ints
    ahead: Floats
    moves: Floats
    last: npt.NDArray[np.int64]
    move: Ints
    share: Floats

    def poses(self, b: slice) -> PathPoses:
        """A stretch of the path."""
        path, kind = self.path, self.kind[b]
        stand = np.ascontiguousarray(np.swapaxes(axes_with(self.feed[b], path.axis[b]), 1, 2))  # rows x, y, z
        stand[:, 1] *= path.sense[b, None]
        way = path.way_at(b)
        turn = np.cross(path.axis[_before(b)], path.axis[b]) * path.sense[b, None]
        motion = np.concatenate([np.einsum("nij,nj->ni", stand, v) for v in (way, turn)], axis=1)
        size = np.linalg.norm(way, axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            per_tooth = np.where((kind == CUTTING) & (size > 0), path.feed[b] / path.teeth_at(b) / size, 0.0)
        feed = motion[:, [0, 2]] * per_tooth[:, None]
        plunge = np.abs(motion[:, 0]) <= ALONG * size
        feed[plunge, 0] = 0.0
        return PathPoses(
            kind, path.cutter[b].copy(), tip=path.position[b].copy(), axes=stand, feed=feed, motion=motion,
            ahead=self.ahead[b], begun=self.begun[b].astype(np.int64), move=self.move, share=self.share, last=self.last,
        )  # fmt: skip


def prepared(path: MillingPath, cell: float) -> Prepared:
    """Rows of moves and poses for the kernels, with a grid of ``cell`` m."""
    cutting = np.zeros(len(path), dtype=np.uint8)
    for b in blocks(len(path)):
        turn = np.linalg.norm(path.axis[b] - path.axis[_before(b)], axis=1)
        cutting[b] = ~path.rapid[b] & ((np.linalg.norm(path.way_at(b), axis=1) > 0) | (turn > 0))
    cutting[0] = 0
    radius = np.array([c.largest_radius for c in path.cutters])
    reach = np.minimum(min(LOOK_BACK, cell), radius / 20)
    # copies: machine code for arrays that do not change would be made a second time
    position, axis, cutter = path.position.copy(), path.axis.copy(), path.cutter.copy()
    row, last, of, share = runs_of_path(position, axis, cutting, cutter)
    begun, ahead = look_back(position, cutting, cutter, reach)
    del position, axis
    cutter = cutter[last]
    row[:, :PROFILE_COLUMNS] = np.array([c.profile for c in path.cutters])[cutter]
    row[:, RADIUS] = radius[cutter]
    row[:, REACH] = (np.array([c.length for c in path.cutters]) + radius)[cutter]
    complete_rows(row)
    kind = np.where(path.rapid, RAPID_MOVE, np.where(cutting, CUTTING, IDLE)).astype(np.uint8)
    kind[0] = IDLE
    return Prepared(
        path, kind, arriving_feed(path), begun=begun, ahead=ahead, moves=row, last=last.astype(np.int64), move=of,
        share=share,
    )  # fmt: skip
