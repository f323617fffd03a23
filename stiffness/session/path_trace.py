"""Path trace: what a program that ran commanded, and at which of its rows each reading of a session was taken.

Readings of a trace belong to a commanded path: the memory of the joints comes from the walk along all of its rows, and
not from the approach to a set-up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from stiffness.session.turning import turning_rows

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
TraceKind = Literal["positions", "ballbar", "surface"]
FAR = 1.0  # rad: a move to the first row is longer than any gap


@dataclass(frozen=True, repr=False, eq=False)
class CommandedRows:
    """The R rows of a program, rapids included; arrays read-only.

    Attributes:
        q: (R, n) rad. position: (R, 3) m, commanded TCP in the base. nominal: (R, 3) m, where it has to be.
        wrench: (R, 6) N and N*m on the robot, base axes, about the TCP, as the process has it; zero in a dry run.
        path_axes: (R, 3, 3) along the feed, across it and along the tool, in the base.
        cut: (R,) of the move that ends at a row. feed: (R,) m/s, NaN where not known.
        first: (n,) -1, 0 (not known), +1: sign of the last rotation of each joint before row 0.
    """

    q: Floats
    position: Floats
    nominal: Floats
    wrench: Floats
    path_axes: Floats
    cut: Bools
    feed: Floats
    first: Ints

    def __post_init__(self) -> None:
        for f in fields(self):
            getattr(self, f.name).setflags(write=False)

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"CommandedRows({len(self)} rows, {int(self.cut.sum())} of cuts)"

    def at(self, column: Floats, index: Floats) -> Floats:
        """(N, ...) a column of the rows at fractions of rows (N,), linear between two."""
        low = np.clip(np.floor(index).astype(np.int64), 0, max(len(column) - 2, 0))
        high = np.minimum(low + 1, len(column) - 1)
        share = (index - low).reshape(-1, *[1] * (column.ndim - 1))
        # a whole index is its row: no rounding in what the row has exactly
        return np.where(share == 0, column[low], np.where(share == 1, column[high],
                        (1 - share) * column[low] + share * column[high]))  # fmt: skip


@dataclass(frozen=True, repr=False, eq=False)
class PathTrace:
    """A trace of a program that ran.

    Attributes:
        kind: ``positions``: three coordinates of the TCP; ``ballbar``: its distance from a centre; ``surface``: the
            deviation of a point of the part along its normal.
        rows: what was commanded.
        index: (N,) row of every reading, counted from 0; a fraction lies between two rows. run: (N,) of it.
        length: (N,) m, arc length of the commanded path from row 0 to the reading.
        stretch: (N,) which of equal parts of the path it lies in.
        gravity: (3,) m/s2 in the base.
        normal: (N, 3) outward, base axes; of a surface, else zero. point: (N, 3) m in the base, the same.
        centre: (3,) m in the base, roughly known; radius: m, nominal. calibrated: the length has no error; of a
            ball-bar. length_sd: m, of its length as calibrated.
        probe_sd: m, of an offset along all normals that is estimated, of a touch probe; 0: there is none.
        latency: s, by which readings show the arm earlier than their rows; None: not given. lagging: it is estimated,
            where readings were taken in motion and have a time.
        process: names of ``material`` and ``cutter`` that effects of the process hold for; "": not told.
        as_said: no effect of the process acts: what was cut is another material, or with another cutter, than theirs.
        gravity_told: whether the cell says who takes the sag off; else it is as in the model.
        given: readings in the file, before it was thinned.
        sources: file -> sha256 of what was read beside trace and samples.
        notes: in words, for reports.
    """

    kind: TraceKind
    rows: CommandedRows
    index: Floats
    run: Ints
    length: Floats
    stretch: Ints
    gravity: Floats
    normal: Floats
    point: Floats
    centre: Floats
    radius: float = 0.0
    calibrated: bool = True
    length_sd: float = 0.0
    probe_sd: float = 0.0
    latency: float | None = None
    lagging: bool = False
    process: tuple[str, str] = ("", "")
    dry: bool = False
    as_said: bool = False
    gravity_told: bool = True
    given: int = 0
    sources: Mapping[str, str] | None = None
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"PathTrace({self.kind}, {len(self.index)} readings of {len(self.rows)} rows)"

    @property
    def scalar(self) -> bool:
        """Whether a reading is one number, the first of its position; else it is a point."""
        return self.kind != "positions"

    @property
    def force(self) -> Floats:
        """(N, 3) N, programmed, base axes."""
        return self.rows.at(self.rows.wrench, self.index)[:, :3]

    @property
    def joint_speed(self) -> Floats:
        """(N, n) rad/s of every joint by the programmed feed, at 1 m/min where there is none."""
        rows = self.rows
        into = np.clip(np.ceil(self.index).astype(np.int64), 1, len(rows) - 1)
        feed = np.where(np.isfinite(rows.feed[into]), rows.feed[into], 1 / 60)
        step = np.linalg.norm(rows.position[into] - rows.position[into - 1], axis=1)
        turned = rows.q[into] - rows.q[into - 1]
        return np.asarray(turned * (feed / np.maximum(step, 1e-9))[:, None])

    @property
    def since_turning(self) -> Floats:
        """(N, n) rad that every joint has travelled since it turned last."""
        rows, out = self.rows, np.zeros((len(self.index), self.rows.q.shape[1]))
        for j, turned in enumerate(turning_rows(rows.q)):
            q, turns = rows.q[:, j], np.concatenate([[0], turned]).astype(np.int64)
            last = turns[np.searchsorted(turns, self.index, side="right") - 1]
            out[:, j] = np.abs(rows.at(q, self.index) - q[last])
        return out

    @property
    def feeds(self) -> Floats:
        """(F,) m/s, the feeds of the readings."""
        feed = self.rows.feed[np.minimum(np.ceil(self.index).astype(np.int64), len(self.rows) - 1)]
        return np.unique(feed[np.isfinite(feed)])

    @property
    def axes_at_readings(self) -> Floats:
        """(N, 9) path axes, column after column."""
        low = np.floor(self.index).astype(np.int64)  # axes turn at rows: between two, those of the feed that leaves
        return np.swapaxes(self.rows.path_axes[low], 1, 2).reshape(-1, 9)

    @property
    def whole_runs(self) -> bool:
        """Whether there are so many runs that whole ones are held out."""
        return len(np.unique(self.run)) >= MANY_RUNS

    def take(self, some: Ints | Bools) -> PathTrace:
        """Of some of the readings."""
        per_reading = ("index", "run", "length", "stretch", "normal", "point")
        return replace(self, **{name: getattr(self, name)[some] for name in per_reading})


TRAVEL = 1e-6  # rad: less is the rounding of a file
MANY_RUNS = 5  # the contract of traces (docs/traces.md): whole runs are held out where there are five or more


def first_signs(rows: CommandedRows) -> Floats:
    """(n,) -1, 0 (not known), +1: the way that every joint came to row 0; one that came from nowhere keeps the sign of
    its first move."""
    out = rows.first.astype(float)
    if not out.any():
        return out
    for j in np.flatnonzero(out == 0):
        travel = rows.q[:, j] - rows.q[0, j]
        moved = np.flatnonzero(np.abs(travel) > TRAVEL)
        out[j] = np.sign(travel[moved[0]]) if len(moved) else 0.0
    return out
