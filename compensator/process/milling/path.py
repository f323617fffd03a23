"""Milling path: the poses that a cut is computed for, and what the kernels take of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.kernels.profile import PROFILE_COLUMNS
from compensator.process.milling.kernels.rows import complete_rows, look_back, rows_needed, runs_of_path
from compensator.process.milling.kernels.sweep import RADIUS, REACH
from compensator.process.milling.kernels.walk import CUTTING, IDLE, RAPID_MOVE, PathPoses

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]

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
    """

    position: Floats
    axis: Floats
    feed: Floats
    spindle: Floats
    sense: npt.NDArray[np.int8]
    rapid: npt.NDArray[np.bool_]
    cutter: Ints
    cutters: tuple[Cutter, ...]

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"MillingPath({len(self)} poses, {len(self.cutters)} cutters)"

    @property
    def way(self) -> Floats:
        """(N, 3) m of the move that ends at the pose; 0 at the first one."""
        return np.asarray(np.diff(self.position, axis=0, prepend=self.position[:1]))

    @property
    def teeth_per_second(self) -> Floats:
        """(N,)"""
        return np.asarray(self.spindle * np.array([c.flutes for c in self.cutters])[self.cutter])


def arriving_axes(path: MillingPath) -> Floats:
    """(N, 3, 3) columns x, y, z: z of the TCP, x the feed that arrives, normal to z, y = z cross x.

    Along z the last x of a cutting move is kept; poses before any take the first that comes.
    """
    z, way = -path.axis, path.way
    across = way - z * np.sum(way * z, axis=1, keepdims=True)
    size = np.linalg.norm(across, axis=1)
    good = ~path.rapid & (size > ALONG * np.linalg.norm(way, axis=1)) & (size > 0)
    x = np.zeros_like(z)
    x[good] = across[good] / size[good, None]
    if not good.any():
        x[:] = _some_normal(z[0])
        good[0] = True
    kept = np.maximum.accumulate(np.where(good, np.arange(len(z)), -1))
    x = x[np.where(kept < 0, int(np.argmax(good)), kept)]
    x = x - z * np.sum(x * z, axis=1, keepdims=True)
    for k in np.flatnonzero(np.linalg.norm(x, axis=1) < 1e-9):  # kept from a pose where z stood along it
        x[k] = _some_normal(z[k])
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)


def _some_normal(z: Floats) -> Floats:
    n = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    return np.asarray(n / np.linalg.norm(n))


@dataclass(frozen=True, repr=False)
class Prepared:
    """A path as kernels take it: ``moves`` (M, 29) that cut, ``poses``, path ``axes`` (N, 3, 3) in columns x, y, z."""

    moves: Floats
    poses: PathPoses
    axes: Floats


def prepared(path: MillingPath, cell: float) -> Prepared:
    """Rows of moves and poses for the kernels, with a grid of ``cell`` m."""
    way = path.way
    turn = np.linalg.norm(np.diff(path.axis, axis=0, prepend=path.axis[:1]), axis=1)
    cutting = (~path.rapid & ((np.linalg.norm(way, axis=1) > 0) | (turn > 0))).astype(np.uint8)
    cutting[0] = 0
    row, last, of, share = runs_of_path(
        path.position, path.axis, cutting, path.cutter, count=rows_needed(path.axis, cutting)
    )
    cutter = path.cutter[last]
    row[:, :PROFILE_COLUMNS] = np.array([c.profile for c in path.cutters])[cutter]
    radius = np.array([c.largest_radius for c in path.cutters])
    row[:, RADIUS] = radius[cutter]
    row[:, REACH] = (np.array([c.length for c in path.cutters]) + radius)[cutter]
    complete_rows(row)
    axes = arriving_axes(path)
    reach = np.minimum(min(LOOK_BACK, cell), radius / 20)
    begun, ahead = look_back(path.position, cutting, path.cutter, reach)
    kind = np.where(path.rapid, RAPID_MOVE, np.where(cutting, CUTTING, IDLE)).astype(np.uint8)
    kind[0] = IDLE
    return Prepared(row, _poses(path, axes, kind, ahead=Ahead(begun, ahead), under=Under(of, share, last)), axes)


@dataclass(frozen=True)
class Ahead:
    """First pose (N,) whose move does not count as made, and m (N,) that the cutter is moved on instead."""

    begun: Ints
    distance: Floats


@dataclass(frozen=True)
class Under:
    """Row (N,) under way at a pose and its share (N,) that is done; last pose (M,) of a row."""

    move: Ints
    share: Floats
    last: Ints


def _poses(path: MillingPath, axes: Floats, kind: npt.NDArray[np.uint8], ahead: Ahead, under: Under) -> PathPoses:
    stand = np.ascontiguousarray(np.swapaxes(axes, 1, 2))  # rows x, y, z
    stand[:, 1] *= path.sense[:, None]
    way = path.way
    before = np.concatenate([path.axis[:1], path.axis[:-1]])
    turn = np.cross(before, path.axis) * path.sense[:, None]
    motion = np.concatenate([np.einsum("nij,nj->ni", stand, v) for v in (way, turn)], axis=1)
    size = np.linalg.norm(way, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        per_tooth = np.where((kind == CUTTING) & (size > 0), path.feed / path.teeth_per_second / size, 0.0)
    feed = motion[:, [0, 2]] * per_tooth[:, None]
    plunge = np.abs(motion[:, 0]) <= ALONG * size
    feed[plunge, 0] = 0.0
    return PathPoses(
        kind, path.cutter, tip=path.position, axes=stand, feed=feed, motion=motion, ahead=ahead.distance,
        begun=ahead.begun.astype(np.int64), move=under.move, share=under.share, last=under.last.astype(np.int64),
    )  # fmt: skip
