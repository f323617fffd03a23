"""Evidence: one session against the statics: predicted readings, their noise, and where the tracker stands.

Positions are compared as they were read, in the tracker's frame. Displacements need no differences: an unknown
offset for every reflector of a set-up, as large as the kinematics may be wrong, takes the absolute position out
of a reading and leaves what changes from state to state, with the noise of the reference counted once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers
from stiffness.identification.load_history import Histories
from stiffness.identification.readings import Pull, Reader, Rest
from stiffness.identification.station import Station
from stiffness.identification.unknowns import Unknowns
from stiffness.numerics.kernel import Kernel
from stiffness.numerics.least_squares import Whitened, deletion_statistics, whitened
from stiffness.robot.robot import STANDARD_GRAVITY
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

STATE_ROUNDS = 5
SILENT = 4.0  # standard deviations of the sensor
LARGEST_BLOCK = 900  # readings of a set-up that are whitened together; more are cut, which costs some weight


@dataclass(frozen=True, repr=False)
class Predicted:
    """Predicted readings of a session: ``position`` (N, 3) m as read, derivatives, and the arm behind them."""

    position: Floats
    by_parameter: Floats  # (N, 3, P)
    by_station: Floats  # (N, 3, S)
    by_wrench: Floats  # (N, 3, 6)
    back: Floats  # (N, 3, 3) base -> as read
    x: Floats  # (N, n_x) elastic coordinates
    torque: Floats  # (N, n) N*m


class Evidence:
    """One session, ready to be compared with a model whose free numbers are ``unknowns``."""

    def __init__(self, session: Session, unknowns: Unknowns, fixed: Mapping[str, Numbers]) -> None:
        self.session, self.unknowns, self.fixed = session, unknowns, fixed
        self.samples = session.samples
        self.reader = Reader(
            session.robot, unknowns, fixed, session.tool.tool(),
            gravity=np.array(STANDARD_GRAVITY), calibrated_out=session.gravity == "calibrated-out",
        )  # fmt: skip
        self.station = Station(session)
        self.used = np.ones(len(self.samples), dtype=bool)
        self.allowed = np.ones(len(self.samples), dtype=bool)  # readings put aside are not: no search brings them back
        self._x = np.zeros((len(self.samples), self.reader.n_x))
        self.torque = np.zeros((len(self.samples), session.robot.n))  # of the last call: flanks start from it
        self._wrench = _shown(session)
        self.histories = Histories(session)
        self.link = np.array([r.link for r in session.reflectors])[self.samples.reflector]
        self.pulls, self._pull_number = _pulls(session)
        reference = session.reference_temperature
        warm = self.samples.temperature - (20.0 if reference is None else reference)
        self._warm = np.where(np.isfinite(warm), warm, 0.0)
        began = np.nanmin(self.samples.time) if np.isfinite(self.samples.time).any() else 0.0
        self._time = np.where(np.isfinite(self.samples.time), self.samples.time - began, 0.0)[:, None]
        self._show = self._show_kernel()
        self.placed = False
        self._weighting: dict[bytes, tuple[Floats | None, Floats]] = {}
        self.resting = self._without_load()

    def __repr__(self) -> str:
        return f"Evidence({self.session.source!r}, {int(self.used.sum())} readings used)"

    def predict(self, p: Floats, station: Floats) -> Predicted:
        """Readings for parameters ``p`` (P,) and the session's own numbers ``station`` (S,)."""
        values = self.unknowns.values(p, self.fixed)
        effects = self.unknowns.effects
        places = self.station.reflectors(station)
        state = self.histories.state(effects, values, self.torque, self.resting)
        for _ in range(STATE_ROUNDS if state.shape[1] else 1):
            rest = self._rest(p, places, state)
            self.torque = rest.torque
            new = self.histories.state(effects, values, rest.torque, self.resting)
            if np.allclose(new, state, atol=1e-6):
                break
            state = new
        base, by_p, by_w, by_state, link = self._read(p, rest, places)
        moved = self.histories.slopes(effects, values, rest.torque, self.resting, state) if state.shape[1] else {}
        self._add_memory(by_p, by_state, moved)
        if not self.placed:
            self.station.place_trackers(base)
            self.placed = True
        read, back, by_station = self.station.seen(station, base)
        by_reflector = self.station.reflector_derivative(station)[self.samples.reflector]
        by_station = by_station + back @ (link @ by_reflector)
        return self._shown(p, Predicted(read, back @ by_p, by_station, back @ by_w, back, self._x, rest.torque))

    def _rest(self, p: Floats, places: Floats, state: Floats) -> Rest:
        """All readings' arms at rest; readings that share load and posture are worked out once."""
        s, count = self.samples, len(self.samples)
        q, wrench, point, payload, warm = self.inputs(places)
        given = (q, wrench, point, state, payload, warm)
        m, n = self.reader.n_x, self.session.robot.n
        first, of = self.cases(np.concatenate(given, axis=1))
        x, torque = np.empty((len(first), m)), np.empty((len(first), n))
        tables = self.reader.tables
        widths = (len(tables.core), 6, state.shape[1], n if tables else 0)
        slopes = [np.empty((len(first), m, w)) for w in widths]
        for pull, rows in self.pulls.items():
            some = np.flatnonzero(rows[first])
            at = first[some]
            loads = q[at], wrench[at], point[at]
            out = self.reader.rest(pull, p, *loads, state[at], payload[at], warm[at], self._x[at])
            x[some], torque[some] = out.x, out.torque
            found = (out.by_parameter, out.by_wrench, out.by_state, out.by_angle)
            for whole, part in zip(slopes, found, strict=True):
                whole[some] = part
        self._x = x[of]
        self._of = of
        rest = Rest(s.q[first], x, torque, *slopes)
        return Rest(rest.q, rest.x, torque[of], *slopes) if count == len(first) else replace(rest, torque=torque[of])

    def inputs(self, places: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """What loads every reading's arm: q (N, n), wrench (N, 6) and its point (N, 3), payload and warmth (N, 1)."""
        s = self.samples
        point = np.where((s.load.at >= 0)[:, None], places[s.load.at], s.load.point)
        return s.q, self._wrench, point, s.payload[:, None], self._warm[:, None]

    def cases(self, given: Floats) -> tuple[Index, Index]:
        """Rows of readings that differ in load or posture, and which of them every reading is."""
        keys = np.column_stack([given, self._pull_number])
        _, first, of = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        return np.asarray(first), np.asarray(of).reshape(-1)

    def _read(self, p: Floats, rest: Rest, places: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        s, count, tables = self.samples, len(self.samples), self.reader.tables
        base, link = np.empty((count, 3)), np.empty((count, 3, 3))
        by_p, by_w, by_state = (np.empty((count, 3, w)) for w in (len(p), 6, rest.by_state.shape[2]))
        for k in np.unique(self.link):
            rows = np.flatnonzero(self.link == k)
            out = self.reader.seen(rest.take(self._of[rows]), int(k), places[s.reflector[rows]])
            base[rows], link[rows] = out.position, out.rotation
            by_w[rows], by_state[rows] = out.by_wrench, out.by_state
            every = np.empty((len(rows), 3, len(p)))
            every[:, :, tables.core] = out.by_parameter
            if len(tables.own):
                every[:, :, tables.own] = out.by_angle[:, :, tables.joint] * tables.slopes(s.q[rows], p)[:, None]
            by_p[rows] = every
        return base, by_p, by_w, by_state, link

    def _add_memory(self, by_p: Floats, by_state: Floats, moved: Mapping[tuple[str, str], Floats]) -> None:
        """What a parameter does to a reading by way of the states that it shifts."""
        n = self.session.robot.n
        remembering = [e.name for e in self.unknowns.effects if e.memory]
        for k, u in enumerate(self.unknowns.free):
            shares = moved.get((u.effect, u.parameter.name))
            if shares is not None:
                column = remembering.index(u.effect) * n + u.index
                by_p[:, :, k] += by_state[:, :, column] * shares[:, u.index, None]

    def _shown(self, p: Floats, seen: Predicted) -> Predicted:
        """What the tracker shows of it: effects that fill ``position_reading``."""
        if self._show is None:
            return seen
        position, by_position, by_p = self._show.run(seen.position, self._time, p)
        turn = np.swapaxes(by_position.reshape(-1, 3, 3), 1, 2)
        own = np.swapaxes(by_p.reshape(len(position), len(p), 3), 1, 2)
        slopes = turn @ seen.by_parameter + own, turn @ seen.by_station, turn @ seen.by_wrench
        return Predicted(position, *slopes, turn @ seen.back, seen.x, seen.torque)

    def shown_slopes(self, position: Floats, p: Floats) -> Floats:
        """(N, 3, P): how instruments alone move what is shown of positions (N, 3)."""
        if self._show is None:
            return np.zeros((len(position), 3, len(p)))
        _, _, by_p = self._show.run(position, self._time, p)
        return np.swapaxes(by_p.reshape(len(position), len(p), 3), 1, 2)

    def _show_kernel(self) -> Kernel | None:
        """(position, time, parameters) -> position shown, its slopes by position and by parameters."""
        effects = [e for e in self.unknowns.effects if e.position_reading]
        if not effects:
            return None
        at, time, p = ca.SX.sym("at", 3), ca.SX.sym("time"), ca.SX.sym("p", len(self.unknowns))
        values, shown = self.unknowns.values(p, self.fixed), at
        for e in effects:
            if e.position_reading:
                shown = e.position_reading(shown, time, values[e.name])
        out = [shown, ca.jacobian(shown, at), ca.jacobian(shown, p)]
        return Kernel(ca.Function("shown", [at, time, p], [ca.densify(ca.vec(v)) for v in out]))

    def _without_load(self) -> Floats:
        """(N, n) N*m at every posture without load, by the values that the session begins with."""
        count, n = len(self.samples), self.session.robot.n
        if not self.reader.statics.n_state:
            return np.zeros((count, n))
        p = self.unknowns.start(self.fixed)
        return self.reader.resting(p, self.samples.q, self.samples.payload[:, None], self._warm[:, None])

    def blocks(
        self, p: Floats, station: Floats, offset: float, columns: slice, width: int, more: Floats | None = None
    ) -> list[Whitened]:
        """Whitened residuals set-up by set-up.

        Args:
            offset: m, how far a reflector of a set-up may be off as a whole: what a reading says of absolute
                positions has this standard deviation on top, displacements keep their own.
            columns: where this session's station stands in the whole vector of ``width`` numbers.
            more: (N, 3, C) slopes by further numbers, whose columns follow.
        """
        seen = self.predict(p, station)
        residual = self.samples.position - seen.position
        out = []
        for rows in self._setups():
            jacobian = np.zeros((3 * len(rows), width))
            jacobian[:, : len(p)] = seen.by_parameter[rows].reshape(3 * len(rows), -1)
            jacobian[:, columns] = seen.by_station[rows].reshape(3 * len(rows), -1)
            if more is not None:
                jacobian = np.hstack([jacobian, more[rows].reshape(3 * len(rows), -1)])
            reduce, covariance = self._fixed_noise(rows)
            covariance = covariance + self._other_noise(rows, seen.by_wrench[rows], offset)
            r = residual[rows].reshape(-1)
            if reduce is not None:
                r, jacobian, covariance = reduce @ r, reduce @ jacobian, reduce @ covariance @ reduce.T
            out.append(whitened(rows, r, jacobian, covariance))
        return out

    def deletion(self, block: Whitened) -> tuple[list[Index], Floats, Floats]:
        """Readings of a block: their rows, the chi-square of leaving each out, and its degrees of freedom."""
        probes = self._probes(block.rows)
        free = np.ones(len(block.rows), dtype=bool)
        for members, _ in probes:
            free[members] = False
        rows = [block.rows[k : k + 1] for k in np.flatnonzero(free)] + [block.rows[m] for m, _ in probes]
        sizes = [3] * int(free.sum()) + [min(6, len(lever)) for _, lever in probes]
        return rows, deletion_statistics(block, sizes), np.array(sizes, dtype=float)

    def _setups(self) -> list[Index]:
        order = np.argsort(self.samples.setup, kind="stable")
        order = order[self.used[order]]
        edges = np.flatnonzero(np.diff(self.samples.setup[order])) + 1
        parts = [part for part in np.split(order, edges) if len(part)]
        return [piece for part in parts for piece in np.array_split(part, -(-len(part) // LARGEST_BLOCK))]

    def _fixed_noise(self, rows: Index) -> tuple[Floats | None, Floats]:
        """What of a set-up's weighting no parameter changes, once: ``_independent`` and the tracker's noise."""
        key = rows.tobytes()
        if key not in self._weighting:
            self._weighting[key] = self._independent(rows), self.tracker_noise(rows)
        return self._weighting[key]

    def noise(self, rows: Index, by_wrench: Floats, offset: float) -> Floats:
        """Covariance (3k, 3k) of some readings: tracker, wrench sensor, and the offset of each reflector."""
        return self.tracker_noise(rows) + self._other_noise(rows, by_wrench, offset)

    def _other_noise(self, rows: Index, by_wrench: Floats, offset: float) -> Floats:
        k = len(rows)
        c = np.zeros((3 * k, 3 * k))
        sensor = self.session.instruments
        if self.session.wrench_frame is not None and (sensor.force or sensor.torque):
            sd = np.array([sensor.force] * 3 + [sensor.torque] * 3)
            d = (by_wrench * sd).reshape(3 * k, 6)
            same = np.repeat(self.session.sensor_reading[rows], 3)
            c += (d @ d.T) * (same[:, None] == same[None, :])
        if offset > 0:
            group = np.repeat(self.samples.reflector[rows], 3)
            axis = np.tile(np.arange(3), k)
            c += offset**2 * ((group[:, None] == group[None, :]) & (axis[:, None] == axis[None, :]))
        return c

    def tracker_noise(self, rows: Index) -> Floats:
        """Covariance (3k, 3k) of the tracker alone; a probe's reflectors share its six numbers."""
        c = np.diag((self.samples.sd[rows] ** 2).reshape(-1))
        for members, lever in self._probes(rows):
            at = (3 * members[:, None] + np.arange(3)).ravel()
            sd = np.concatenate([self.samples.sd[rows[members[0]]], np.full(3, self._angle_sd)])
            c[np.ix_(at, at)] = (lever * sd) @ (lever * sd).T
        return c

    @property
    def _angle_sd(self) -> float:
        return self.session.instruments.tracker_angle or 1e-3

    def _probes(self, rows: Index) -> list[tuple[Index, Floats]]:
        """For every pose reading of a probe: its readings (m,) within ``rows``, and their lever (3m, 6)."""
        s, group = self.samples, self.session.group
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
            skew = np.zeros((len(arm), 3, 3))
            skew[:, 0, 1], skew[:, 0, 2], skew[:, 1, 2] = -arm[:, 2], arm[:, 1], -arm[:, 0]
            lever = np.concatenate([np.tile(np.eye(3), (len(arm), 1, 1)), np.swapaxes(skew, 1, 2) - skew], axis=2)
            out.append((members, lever.reshape(-1, 6)))
        return out

    def _independent(self, rows: Index) -> Floats | None:
        """(m, 3k) that makes six numbers of every pose reading of a probe; None where there is none."""
        probes = self._probes(rows)
        if not probes:
            return None
        out: list[Floats] = []
        free = np.ones(len(rows), dtype=bool)
        for members, lever in probes:
            free[members] = False
            part = np.zeros((min(6, len(lever)), 3 * len(rows)))
            at = (3 * members[:, None] + np.arange(3)).ravel()
            part[:, at] = np.linalg.pinv(lever)[: len(part)]
            out.append(part)
        single = np.zeros((3 * int(free.sum()), 3 * len(rows)))
        at = (3 * np.flatnonzero(free)[:, None] + np.arange(3)).ravel()
        single[np.arange(len(at)), at] = 1.0
        return np.concatenate([single, *out])


def _shown(session: Session) -> Floats:
    """(N, 6) wrench as read; zero where the sensor shows nothing but its noise, which must not choose flanks."""
    wrench, sensor = session.samples.load.wrench, session.instruments
    if not session.has_wrench:
        return wrench
    sd = np.array([sensor.force or 0.0] * 3 + [sensor.torque or 0.0] * 3)
    nothing = np.all(np.abs(wrench) <= SILENT * sd, axis=1)
    return np.where(nothing[:, None], 0.0, wrench)


def _pulls(session: Session) -> tuple[dict[Pull, Bools], Index]:
    """The kinds of load of a session, each with its readings, and the number of the kind of every reading."""
    load = session.samples.load
    keys = np.stack([load.link, load.point_link, load.in_tool.astype(np.int64)], axis=1)
    unique, of = np.unique(keys, axis=0, return_inverse=True)
    of = of.reshape(-1)
    return {Pull(int(a), int(b), bool(c)): of == k for k, (a, b, c) in enumerate(unique)}, of
