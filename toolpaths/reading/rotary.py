"""Rotary axes of a CNC program: moves that turn become poses, so that the tip stays on its way."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.machine import Machine
from toolpaths.reading.track import most_poses
from toolpaths.toolpath import CUT, Floats, Toolpath

WIDEST = np.radians(2.0)  # a turn of the axes is followed in steps of at most this
MOST_STEPS = 100_000


@dataclass(frozen=True)
class RotaryTrace:
    """What a reader noted of the rotary axes, a row per move.

    Attributes:
        angles: (M, k) rad.
        tip: (M,) tool centre point control was on.
        time: (M,) s that the move takes, NaN where its feed is that of the tip.
        given: (M,) place and tool axis are in the work object already, as in a tilted working plane.
    """

    angles: Floats
    tip: npt.NDArray[np.bool_]
    time: Floats
    given: npt.NDArray[np.bool_]


def in_work(path: Toolpath, machine: Machine, turns: RotaryTrace, chord: float) -> Toolpath:
    """The poses of a machine with rotary axes: ``path`` holds X, Y, Z as programmed.

    Moves that turn get poses in between, so that the tip stays within ``chord`` (m) of its way.

    Raises:
        ReadError: more poses than a file of this size may become.
    """
    move = np.ceil(path.row).astype(np.intp)
    tip, given = turns.tip[move], turns.given[move]
    angles = turns.angles[move]
    angles = np.where(given[:, None], np.nan_to_num(angles), angles)  # not needed there, and not known perhaps
    count = _steps(path.position, angles=angles, tip=tip, machine=machine, chord=chord)
    count = np.where(given | np.roll(given, 1), 1, count)
    if (total := int(count.sum())) > (most := len(path) + most_poses(len(turns.angles))):
        problem = f"its turns make {total} poses; at most {most}"
        raise ReadError(path.source, int(path.line[np.argmax(count)]), problem, "Check the angles.")
    to = np.repeat(np.arange(len(path)), count)
    first = np.cumsum(count) - count
    share = (np.arange(len(to)) - first[to] + 1) / count[to]
    rest, before = (1.0 - share)[:, None], np.maximum(to - 1, 0)
    xyz = share[:, None] * path.position[to] + rest * path.position[before]
    xyz[first + count - 1] = path.position  # ends to the last digit
    position, axis = machine.poses(xyz, share[:, None] * angles[to] + rest * angles[before], tip[to])
    position = np.where(given[to][:, None], xyz, position)
    axis = np.where(given[to][:, None], path.axis[to], axis)
    row = share * path.row[to] + (1.0 - share) * path.row[before]
    row[first + count - 1] = path.row
    feed = _feeds(position, to=to, feed=path.feed, time=turns.time[move], kind=path.kind)
    return replace(path.take(to), position=position, axis=axis, row=row, feed=feed)


def _steps(
    xyz: Floats, angles: Floats, tip: npt.NDArray[np.bool_], machine: Machine, chord: float
) -> npt.NDArray[np.intp]:
    """(N,) into how many parts the move to each pose is cut."""
    turn = np.nan_to_num(np.abs(np.diff(angles, axis=0, prepend=angles[:1])).sum(axis=1))
    way = np.linalg.norm(np.diff(xyz, axis=0, prepend=xyz[:1]), axis=1)
    centres = [a.centre for a in machine.axes if a.centre is not None] or [(0.0, 0.0, 0.0)]
    radius = np.max([np.linalg.norm(xyz - np.array(c), axis=1) for c in centres], axis=0)
    radius = np.maximum(radius, np.roll(radius, 1)) + (machine.pivot or 0.0)
    # the chord of a curve p(s), 0 <= s <= 1, cut into n parts misses it by at most |p''| / (8 n^2)
    bend = np.where(tip, 0.0, turn**2 * radius + 2.0 * turn * way)
    count = np.maximum(np.ceil(turn / WIDEST), np.ceil(np.sqrt(bend / (8.0 * chord))))
    switched = np.diff(tip, prepend=tip[:1])
    return np.asarray(np.clip(np.where(switched, 1, count), 1, MOST_STEPS), dtype=np.intp)


def _feeds(
    position: Floats, to: npt.NDArray[np.intp], feed: Floats, time: Floats, kind: npt.NDArray[np.uint8]
) -> Floats:
    """(P,) m/s of the tip; where it stands still while the axes turn, the feed of the cut before."""
    way = np.bincount(to, np.linalg.norm(np.diff(position, axis=0, prepend=position[:1]), axis=1), len(feed))
    out = np.where(np.isnan(time), feed, way / np.where(np.isnan(time), 1.0, time))
    still = np.flatnonzero((kind == CUT) & ~(out > 1e-9))
    moving = np.flatnonzero((kind == CUT) & (out > 1e-9))
    if len(still):
        last = np.searchsorted(moving, still) - 1
        out[still] = np.where(last >= 0, out[moving[np.maximum(last, 0)]], 1e-3) if len(moving) else 1e-3
    return np.asarray(out[to], dtype=np.float64)
