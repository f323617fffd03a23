"""Evidence: one session against the statics: predicted readings, their noise, and where the tracker stands.

Positions are compared as they were read, in the tracker's frame. Displacements need no differences: an unknown
offset for every reflector of a set-up, as large as the kinematics may be wrong, takes the absolute position out
of a reading and leaves what changes from state to state, with the noise of the reference counted once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers
from stiffness.least_squares import Whitened, whitened
from stiffness.preload import PreloadState, unknown, walk
from stiffness.reading import Kind, Reader
from stiffness.robot import STANDARD_GRAVITY
from stiffness.session import Session
from stiffness.station import Station
from stiffness.unknowns import Unknowns

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

FAR = 1.0  # rad: an approach of unknown size is taken to be longer than any gap
STATE_ROUNDS = 4


@dataclass(frozen=True, repr=False)
class Prediction:
    """Predicted readings of a session: ``position`` (N, 3) m in the tracker's frame, and derivatives."""

    position: Floats
    by_parameter: Floats  # (N, 3, P)
    by_station: Floats  # (N, 3, S)
    by_wrench: Floats  # (N, 3, 6)
    torque: Floats  # (N, n)


class Evidence:
    """One session, ready to be compared with a model.

    Args:
        unknowns, fixed: the model's free and fixed numbers.
    """

    def __init__(self, session: Session, unknowns: Unknowns, fixed: Mapping[str, Numbers]) -> None:
        self.session, self.unknowns, self.fixed = session, unknowns, fixed
        self.reader = Reader(
            session.robot,
            unknowns,
            fixed,
            session.tool.tool(),
            gravity=np.array(STANDARD_GRAVITY),
            calibrated_out=session.gravity == "calibrated-out",
        )
        self.station = Station(session)
        self.kinds = _kinds(session)
        self._x = np.zeros((len(session), self.reader.n_x))
        self._sequences = _Sequences(session)
        self.used = np.ones(len(session), dtype=bool)

    def __repr__(self) -> str:
        return f"Evidence({self.session!r}, {int(self.used.sum())} used)"

    def predict(self, p: Floats, station: Floats) -> Prediction:
        """Readings for parameters ``p`` (P,) and station numbers (S,)."""
        values = self.unknowns.values(p, self.fixed)
        state = np.zeros((len(self.session), self.reader.statics.n_state))
        read = self._read(p, station, state)
        for _ in range(STATE_ROUNDS if state.shape[1] else 1):
            new = self._sequences.state(self.unknowns.effects, values, read[1])
            if np.array_equal(new, state) and np.any(self._x):
                break
            state = new
            read = self._read(p, station, state)
        base, torque, by_p, by_w, by_reflector = read
        return self.station.seen(station, base, by_reflector, by_p, by_w, torque)

    def _read(self, p: Floats, station: Floats, state: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        s, n = self.session, len(self.session)
        base, torque = np.empty((n, 3)), np.empty((n, s.robot.n))
        by_p, by_w = np.empty((n, 3, len(p))), np.empty((n, 3, 6))
        link = np.empty((n, 3, 3))
        reflector, point = self.station.reflectors(station)[s.reflector], self.station.load_points(station)
        for kind, rows in self.kinds.items():
            out = self.reader.read(
                kind, p, s.q[rows], s.wrench[rows], point[rows], reflector[rows], state[rows],
                s.payload[rows, None], s.warm[rows, None], self._x[rows],
            )  # fmt: skip
            self._x[rows] = out.x
            base[rows], torque[rows], link[rows] = out.position, out.torque, out.rotation
            by_p[rows], by_w[rows] = out.by_parameter, out.by_wrench
        return base, torque, by_p, by_w, link

    def blocks(self, p: Floats, station: Floats, offset: float) -> list[Whitened]:
        """Whitened residuals set-up by set-up.

        Args:
            offset: m, how far a reflector of a set-up may be off as a whole (kinematics); what the readings say
                of absolute positions has this standard deviation, displacements keep their own.
        """
        seen = self.predict(p, station)
        residual = self.session.position - seen.position
        jacobian = np.concatenate([seen.by_parameter, seen.by_station], axis=2)
        out = []
        for rows in self._setups():
            covariance = self.noise(rows, seen.by_wrench[rows], offset)
            reduce = self.station.independent(rows)
            r, j = residual[rows].reshape(-1), jacobian[rows].reshape(3 * len(rows), -1)
            if reduce is not None:
                r, j, covariance = reduce @ r, reduce @ j, reduce @ covariance @ reduce.T
            out.append(whitened(rows, r, j, covariance))
        return out

    def _setups(self) -> list[npt.NDArray[np.intp]]:
        key = self.session.setup
        order = np.argsort(key, kind="stable")
        order = order[self.used[order]]
        edges = np.flatnonzero(np.diff(key[order])) + 1
        return [part for part in np.split(order, edges) if len(part)]

    def noise(self, rows: npt.NDArray[np.intp], by_wrench: Floats, offset: float) -> Floats:
        """Covariance (3k, 3k) of some readings: tracker, wrench sensor, and the offset of each reflector."""
        s, k = self.session, len(rows)
        c = np.diag((s.sd[rows] ** 2).reshape(-1))
        if s.has_wrench:
            sd = np.array([s.instruments.force] * 3 + [s.instruments.torque] * 3)
            d = (by_wrench * sd).reshape(3 * k, 6)
            shared = s.sensor_reading[rows]  # readings of one state that show one and the same wrench
            same = np.repeat(shared, 3)
            c += (d @ d.T) * (same[:, None] == same[None, :])
        if offset > 0:
            group = np.repeat(s.reflector[rows], 3)
            axis = np.tile(np.arange(3), k)
            together = (group[:, None] == group[None, :]) & (axis[:, None] == axis[None, :])
            c += offset**2 * together
        return c


def _kinds(session: Session) -> dict[Kind, npt.NDArray[np.intp]]:
    link = session.reflector_link[session.reflector]
    tool, base = session.wrench_frame == "tool", session.wrench_about == "base"
    out: dict[Kind, npt.NDArray[np.intp]] = {}
    for pair in np.unique(np.stack([link, session.load_link], axis=1), axis=0):
        rows = np.flatnonzero((link == pair[0]) & (session.load_link == pair[1]))
        at_point = ~session.load_is_tool[rows]
        for named in (False, True):
            chosen = rows[at_point == named]
            if len(chosen):
                kind = Kind(int(pair[0]), int(pair[1]), tool, base and not named)
                out[kind] = np.sort(np.concatenate([out[kind], chosen])) if kind in out else chosen
    return out


class _Sequences:
    """The load history of every set-up: states side by side, one after the other."""

    def __init__(self, session: Session) -> None:
        self.session = session
        keys = np.stack([session.setup, session.state], axis=1)
        unique, first, back = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        self._first, self._back = first, back.ravel()
        setups, self._setup = np.unique(unique[:, 0], return_inverse=True)
        begin = np.searchsorted(unique[:, 0], setups)
        self._step = np.arange(len(unique)) - begin[self._setup]
        self._shape = (int(self._step.max()) + 1, len(setups))
        self._begin = first[begin]

    def state(self, effects: tuple[object, ...], values: Mapping[str, Numbers], torque: Floats) -> Floats:
        """(N, m) memory of every reading as a share of its half range, from approach and load history."""
        from stiffness.effects.effect import Effect

        real = [e for e in effects if isinstance(e, Effect)]
        values = {e: {k: _wide(k, v) for k, v in p.items()} for e, p in values.items()}
        s, n = self.session, self.session.robot.n
        tau = np.zeros((*self._shape, n))
        tau[self._step, self._setup] = torque[self._first]
        last = np.maximum.accumulate(np.where(self._filled()[:, :, None], np.arange(self._shape[0])[:, None, None], 0), 0)
        tau = np.take_along_axis(tau, np.broadcast_to(last, tau.shape), axis=0)
        approach = s.approach[self._begin] * np.where(np.isnan(s.step[self._begin]), FAR, np.abs(s.step[self._begin]))
        move = np.concatenate([approach[None], np.zeros((*self._shape, n))])
        load = np.concatenate([np.zeros((1, *tau.shape[1:])), tau])
        none = unknown(real, values)
        start = PreloadState(*(np.broadcast_to(b, (self._shape[1], len(b))) for b in (none.low, none.high)))
        walked = walk(real, values, move, load, start).middle[1:]
        share = walked / np.where(none.high > 0, none.high, 1.0)
        return np.asarray(share[self._step, self._setup][self._back])

    def _filled(self) -> Bools:
        filled = np.zeros(self._shape, dtype=bool)
        filled[self._step, self._setup] = True
        return filled


def _wide(name: str, value: Floats) -> Floats:
    """A gap of zero still has sides: the share of the range has to be defined where the range shrinks to nothing."""
    return np.maximum(value, 1e-12) if name == "gap_rad" else value
