"""Stream: positions that have a time and no row: where on the commanded path each was read.

The shape of the path tells the place (``shape_match``). Where the arm went at the programmed feed, the feed tells it
better, from the median of all places of a cut: then what the arm does along its path shows as well.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.errors import TraceError
from compensator.trace.shape_match import PointsOnPath, arc_length, placed_by_shape
from compensator.trace.trace_samples import TraceSamples
from stiffness.session.path_trace import CommandedRows

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

FAR = 5e-3  # m, RMS: of another shape than the path
ASIDE = 20e-3  # m, RMS: farther aside than any arm sags
AS_PROGRAMMED = 5e-4  # m, RMS along the path, between feed and shape: what deflection brings about
ALONG = 1e-3  # m: what is not known of a reading along the path where its place comes from the shape
STANDS = 0.2  # of the median speed: the arm stands, or begins to move


@dataclass(frozen=True, repr=False)
class Stream:
    """A stream with its rows.

    Attributes:
        samples: those that were read on cuts, with their index.
        by_feed: whether the programmed feed gave the places; else the shape, and what lies along the path is not known.
        note: for reports.
    """

    samples: TraceSamples
    by_feed: bool
    note: str


def with_rows(samples: TraceSamples, rows: CommandedRows, label: str, *, registered: bool) -> Stream:
    """The rows of positions without ``index``.

    Raises:
        TraceError: they have no times, or do not lie on the path.
    """
    if not np.isfinite(samples.time).all():
        why = "its cells are empty in places" if np.isfinite(samples.time).any() else "there is no column time"
        raise TraceError(
            f"{label}: column index missing: a stream is matched with the path by its times and its shape, but {why}; "
            "add time (s), or the row of the program of every reading, from 0"
        )
    order = np.lexsort((samples.time, samples.run))
    samples = samples.take(order)
    placed = placed_by_shape(samples.read, samples.run, rows.position, registered=registered)
    for off, most, why in (
        (placed.distance, FAR, "are they of this program, mm?"),
        (placed.shift, ASIDE, "are they in the base of the robot, mm? Else set registered = false."),
    ):
        if off > most:
            raise TraceError(
                f"{label}: the readings are {1e3 * off:.3g} mm (RMS) from the commanded path, expected below "
                f"{1e3 * most:g}: {why} Or give the column index"
            )
    moving = _moving(samples, placed)
    by_feed, spread = _by_feed(samples, rows, placed, moving)
    follows = spread < AS_PROGRAMMED
    arc = by_feed if follows else placed.arc
    length = arc_length(rows.position)
    told = np.isfinite(arc) & (arc > 0) & (arc < length[-1])
    index = np.interp(np.where(told, arc, 0.0), length, np.arange(len(rows), dtype=float))
    low, high = np.floor(index).astype(np.int64), np.ceil(index).astype(np.int64)
    kept = np.flatnonzero(moving & told & rows.cut[low] & rows.cut[high])
    if not len(kept):
        raise TraceError(f"{label}: none of its readings lies on a cut of the program: give the column index")
    along = np.zeros_like(samples.read) if follows else ALONG * np.abs(placed.tangent)
    found = replace(samples, index=index, along=along).take(kept)
    return Stream(found, follows, _note(label, len(samples), len(kept), spread, follows=follows))


def _moving(samples: TraceSamples, placed: PointsOnPath) -> Bools:
    """(N,) readings of an arm that moves along its path, by the readings beside them."""
    out = np.zeros(len(samples), dtype=bool)
    for run in np.unique(samples.run):
        mine = np.flatnonzero(samples.run == run)
        if len(mine) < 3:
            continue
        took = np.maximum(samples.time[mine[2:]] - samples.time[mine[:-2]], 1e-9)
        speed = (placed.arc[mine[2:]] - placed.arc[mine[:-2]]) / took
        going = speed[speed > 0]
        out[mine[1:-1]] = speed > STANDS * float(np.median(going)) if len(going) else False
    return out


def _by_feed(samples: TraceSamples, rows: CommandedRows, placed: PointsOnPath, moving: Bools) -> tuple[Floats, float]:
    """(N,) m along the path by the programmed feed, NaN beside cuts that have one; and m RMS from those by shape."""
    length, out = arc_length(rows.position), np.full(len(samples), np.nan)
    off: list[Floats] = []
    for first, last in _cuts(rows):
        way = np.diff(length[first : last + 1])
        clock = np.concatenate([[0.0], np.cumsum(way / rows.feed[first + 1 : last + 1])])
        for run in np.unique(samples.run):
            here = (samples.run == run) & moving & (placed.arc > length[first]) & (placed.arc < length[last])
            at = np.flatnonzero(here)
            if not len(at):
                continue
            begun = float(np.median(samples.time[at] - np.interp(placed.arc[at], length[first : last + 1], clock)))
            then = samples.time[at] - begun
            told = (then > 0) & (then < clock[-1])
            out[at[told]] = np.interp(then[told], clock, length[first : last + 1])
            off.append(out[at[told]] - placed.arc[at[told]])
    every = np.concatenate(off) if off else np.empty(0)
    return out, float(np.sqrt(np.mean(every**2))) if len(every) else np.inf


def _cuts(rows: CommandedRows) -> list[tuple[int, int]]:
    """First and last row of every stretch of cuts with a feed; the move to the first one is of another kind."""
    fed = rows.cut & np.isfinite(rows.feed)
    edge = np.flatnonzero(np.diff(np.concatenate([[False], fed, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in edge.reshape(-1, 2) if b - a > 1]


def _note(label: str, given: int, kept: int, spread: float, *, follows: bool) -> str:
    text = f"{label}: a stream without index: {kept} of {given} readings were taken on cuts in motion; "
    if follows:
        return (
            f"{text}the programmed feed tells their places, {1e3 * spread:.2g} mm (RMS) along the path from those "
            "of the shape; what lag is left is estimated"
        )
    far = "it has none" if not np.isfinite(spread) else f"the arm left it by {1e3 * spread:.2g} mm (RMS) along the path"
    return (
        f"{text}their places come from the shape of the path, not from the programmed feed ({far}): what the arm does "
        f"along its path does not count ({1e3 * ALONG:g} mm in the noise)"
    )
