"""Weighting: residuals of a session made independent and of unit variance, set-up by set-up.

Positions are compared as they were read, in the tracker's frame. Displacements need no differences: a free offset of
every reflector of a set-up, as large as the kinematics may be wrong, takes the absolute position out of a reading and
leaves what changes from state to state, with the noise of the reference counted once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.identification.reading_slopes import ReadingSlopes, Slopes
from stiffness.numerics.whitened import Whitened, deletion_statistics, whitened
from stiffness.rotation import skew
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/identification/test_weighting.py
LARGEST_BLOCK = 900  # readings of a set-up that are whitened together; more are cut, which costs some weight
PROBE_ANGLE = 1e-3  # rad, noise of a probe's orientation where the session gives none
IN_LINE = 0.05  # of a probe's size: reflectors that are nearer to one line do not tell its rotation about the line


@dataclass(frozen=True, repr=False, eq=False)
class Weighting:
    """Noise of one session.

    Attributes:
        offset: m, standard deviation of the position of a reflector of a set-up as a whole; 0: it is trusted.
    """

    session: Session
    offset: float
    # what of a set-up's weighting no parameter changes, by its rows
    _constant: dict[bytes, tuple[Floats | None, Floats]] = field(default_factory=dict, init=False)

    def __repr__(self) -> str:
        return f"Weighting({self.session.source!r}, offset {self.offset:g} m)"

    def blocks(
        self, seen: PredictedReadings, own: slice, width: int, more: Sequence[Slopes] = ()
    ) -> list[Whitened]:
        """Whitened residuals, set-up by set-up, of the readings in use.

        Args:
            own: where the session's own numbers stand in the whole vector of ``width`` numbers; the parameters stand
                at its front.
            more: derivatives by further numbers, whose columns follow.
        """
        residual = self.session.samples.position - seen.position
        station = ReadingSlopes.plain(seen.by_station)
        every: list[tuple[Slopes, int]] = [(seen.by_number, 0), (station, own.start), *((m, width) for m in more)]
        compact = any(slopes.tabled for slopes, _ in every)
        out = []
        for rows in self._setups(seen.state.used):
            jacobian, columns = _beside(rows, every)
            if not compact:
                jacobian = _in_order(jacobian, columns, width + (more[0].count if more else 0))
            reduce, covariance = self._constant_part(rows)
            covariance = covariance + self._other_noise(rows, seen.by_wrench[rows])
            r = residual[rows].reshape(-1)
            if reduce is not None:
                r, jacobian, covariance = reduce @ r, reduce @ jacobian, reduce @ covariance @ reduce.T
            out.append(whitened(rows, r, jacobian, covariance, columns=columns if compact else None))
        return out

    def spent(self, used: Bools) -> int:
        """Numbers that the free offsets of reflectors take up."""
        if not self.offset > 0:
            return 0
        samples = self.session.samples
        return 3 * len(np.unique(np.column_stack([samples.setup, samples.reflector])[used], axis=0))

    def deletion(self, block: Whitened) -> tuple[list[Index], Floats, Floats]:
        """Readings of a block: their rows, the chi-square of leaving each out, and its degrees of freedom."""
        probes = self._probes(block.rows)
        free = np.ones(len(block.rows), dtype=bool)
        for members, _ in probes:
            free[members] = False
        rows = [block.rows[k : k + 1] for k in np.flatnonzero(free)] + [block.rows[m] for m, _ in probes]
        sizes = [self.session.numbers_each] * int(free.sum()) + [len(_told(lever)) for _, lever in probes]
        return rows, deletion_statistics(block, sizes), np.array(sizes, dtype=float)

    def _setups(self, used: Bools) -> list[Index]:
        order = np.argsort(self.session.samples.setup, kind="stable")
        order = order[used[order]]
        edges = np.flatnonzero(np.diff(self.session.samples.setup[order])) + 1
        parts = [part for part in np.split(order, edges) if len(part)]
        return [piece for part in parts for piece in np.array_split(part, -(-len(part) // LARGEST_BLOCK))]

    def _constant_part(self, rows: Index) -> tuple[Floats | None, Floats]:
        """``_independent`` and the tracker's noise."""
        key = rows.tobytes()
        if key not in self._constant:
            self._constant[key] = self._independent(rows), self._tracker_noise(rows)
        return self._constant[key]

    def _other_noise(self, rows: Index, by_wrench: Floats) -> Floats:
        """Covariance (3k, 3k) that the wrench sensor and the offset of each reflector add."""
        k = len(rows)
        c = np.zeros((3 * k, 3 * k))
        sensor = self.session.instruments
        if self.session.has_wrench and (sensor.force or sensor.torque):
            sd = np.array([sensor.force] * 3 + [sensor.torque] * 3)
            d = (by_wrench * sd).reshape(3 * k, 6)
            same = np.repeat(self.session.sensor_reading[rows], 3)
            c += (d @ d.T) * (same[:, None] == same[None, :])
        if self.offset > 0:
            group = np.repeat(self.session.samples.reflector[rows], 3)
            axis = np.tile(np.arange(3), k)
            c += self.offset**2 * ((group[:, None] == group[None, :]) & (axis[:, None] == axis[None, :]))
        return c

    def _tracker_noise(self, rows: Index) -> Floats:
        """Covariance (3k, 3k) of the tracker alone; a probe's reflectors share its six numbers."""
        sd = self.session.samples.sd
        c = np.diag((sd[rows] ** 2).reshape(-1))
        angle = self.session.instruments.tracker_angle or PROBE_ANGLE
        for members, lever in self._probes(rows):
            at = (3 * members[:, None] + np.arange(3)).ravel()
            six = np.concatenate([sd[rows[members[0]]], np.full(3, angle)])
            c[np.ix_(at, at)] = (lever * six) @ (lever * six).T
        return c

    def _probes(self, rows: Index) -> list[tuple[Index, Floats]]:
        """For every pose reading of a probe: its readings (m,) within ``rows``, and their lever (3m, 6)."""
        s, group = self.session.samples, self.session.group
        inside = np.flatnonzero(group[s.reflector[rows]] >= 0)
        if not len(inside):
            return []
        key = np.column_stack([s.state[rows], s.block[rows], s.repeat[rows], group[s.reflector[rows]]])[inside]
        _, of = np.unique(key, axis=0, return_inverse=True)
        out = []
        for k in range(int(of.max()) + 1):
            members = inside[of.ravel() == k]
            members = members[np.argsort(s.reflector[rows[members]], kind="stable")]
            arm = s.position[rows[members]] - s.position[rows[members[0]]]
            lever = np.concatenate([np.tile(np.eye(3), (len(arm), 1, 1)), skew(-arm)], axis=2)
            out.append((members, lever.reshape(-1, 6)))
        return out

    def _independent(self, rows: Index) -> Floats | None:
        """(m, 3k) that makes of every reading the numbers that it tells: of the pose of a probe fewer than its points
        have, of a reading of one number the first; None where these are all."""
        if self.session.numbers_each == 1:
            return np.eye(3 * len(rows))[::3]
        probes = self._probes(rows)
        if not probes:
            return None
        out: list[Floats] = []
        free = np.ones(len(rows), dtype=bool)
        for members, lever in probes:
            free[members] = False
            told = _told(lever)
            part = np.zeros((len(told), 3 * len(rows)))
            at = (3 * members[:, None] + np.arange(3)).ravel()
            part[:, at] = told
            out.append(part)
        single = np.zeros((3 * int(free.sum()), 3 * len(rows)))
        at = (3 * np.flatnonzero(free)[:, None] + np.arange(3)).ravel()
        single[np.arange(len(at)), at] = 1.0
        return np.concatenate([single, *out])


def _beside(rows: Index, every: Sequence[tuple[Slopes, int]]) -> tuple[Floats, Index]:
    """Jacobian (3k, c) of k readings by numbers that stand from the given places on, and where they stand (c,)."""
    parts = [(*slopes.block(rows), first) for slopes, first in every]
    return np.hstack([j for j, _, _ in parts]), np.concatenate([at + first for _, at, first in parts])


def _in_order(jacobian: Floats, columns: Index, width: int) -> Floats:
    """The same (3k, width) with a column for every number."""
    out = np.zeros((len(jacobian), width))
    out[:, columns] = jacobian
    return out


def _told(lever: Floats) -> Floats:
    """(r, 3m): combinations of the positions of a probe's m reflectors that its pose moves: six, five for reflectors
    on one line, three for a single one. ``lever`` (3m, 6): position by pose."""
    if len(lever) == 3:
        return np.eye(3)
    size = float(np.linalg.norm(lever[:, 3:].reshape(-1, 3, 3), axis=(1, 2)).max()) / np.sqrt(2)
    axes, moved, _ = np.linalg.svd(lever, full_matrices=False)
    rank = int(np.sum(moved > IN_LINE * size))
    return np.asarray(np.linalg.pinv(lever) if rank == 6 else axes[:, :rank].T)
