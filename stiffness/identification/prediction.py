"""Prediction: the readings of a session for given values of the free numbers, with their derivatives.

The statics and the memory of the joints are solved by iteration from where the last prediction ended. That is the
``SessionState``: it goes in as an argument and comes out with the result.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers
from stiffness.identification.arm_loads import ArmEquilibria, pieces_of_links
from stiffness.identification.equilibrium_kernel import STEPS
from stiffness.identification.predicted_readings import PredictedReadings, SessionState
from stiffness.identification.reading_slopes import ReadingSlopes
from stiffness.identification.readings import ReadingModel
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import Unknowns
from stiffness.memory.state_columns import state_columns
from stiffness.numerics.kernel import Kernel

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

MEMORY_ROUNDS = 5


@dataclass(frozen=True, repr=False, eq=False)
class SessionPredictor:
    """A session, the layout of the free numbers, and the values of all others.

    Attributes:
        model: equilibria and positions; its kernels hold ``fixed`` values.
        resting: (N, n) N*m at every posture without load, for the values that the fit starts with.
    """

    data: SessionData
    unknowns: Unknowns
    fixed: Mapping[str, Numbers]
    model: ReadingModel
    resting: Floats

    @classmethod
    def of(cls, data: SessionData, unknowns: Unknowns, fixed: Mapping[str, Numbers]) -> SessionPredictor:
        """The predictor of a session for a layout."""
        session = data.session
        model = ReadingModel(
            session.robot,
            unknowns,
            fixed,
            session.tool.tool(),
            gravity=session.gravity_in_base,
            calibrated_out=session.gravity == "calibrated-out",
        )
        resting = np.zeros((len(data.samples), session.robot.n))
        if model.statics.n_state:
            p, s = unknowns.start(fixed), data.samples
            resting = model.unloaded_torque(p, s.q, s.payload[:, None], data.warm)
        return cls(data=data, unknowns=unknowns, fixed=fixed, model=model, resting=resting)

    def __repr__(self) -> str:
        return f"SessionPredictor({self.data.session.source!r}, {self.unknowns!r})"

    def with_memory_values(self, fixed: Mapping[str, Numbers]) -> SessionPredictor:
        """The same with other values of numbers that only the rules of joint memories read."""
        return replace(self, fixed=fixed)

    def first_state(self) -> SessionState:
        """The state before the first prediction: undeflected arms without torque, all readings in use."""
        count = len(self.data.samples)
        every = np.ones(count, dtype=bool)
        return SessionState(
            x=np.zeros((count, self.model.n_x)),
            torque=np.zeros((count, self.data.session.robot.n)),
            poses=None,
            used=every,
            allowed=every,
        )

    def predict(self, state: SessionState, p: Floats, own: Floats) -> PredictedReadings:
        """Readings for parameters ``p`` (P,) and the session's own numbers ``own`` (S,), started from ``state``."""
        values, places = self.unknowns.values(p, self.fixed), self.data.station.reflectors(own)
        x, torque = state.x, state.torque
        memory = self._memory(values, torque)
        for _ in range(MEMORY_ROUNDS if memory.shape[1] else 1):
            arms, of, x, torque = self._equilibria(p, places, memory, x)
            new = self._memory(values, torque)
            if np.allclose(new, memory, atol=1e-6):
                break
            memory = new
        return self._read(replace(state, x=x, torque=torque), p, own, arms=arms, of=of, memory=memory)

    def predict_near(self, state: SessionState, p: Floats, own: Floats) -> PredictedReadings:
        """As ``predict`` of arms that ended in ``state`` with other joint states: one Newton step from there, at the
        torques that they had; gaps are ten-thousandths of a radian, their squares nothing."""
        memory = self._memory(self.unknowns.values(p, self.fixed), state.torque)
        arms, of, x, _ = self._equilibria(p, self.data.station.reflectors(own), memory, state.x, steps=1)
        return self._read(replace(state, x=x), p, own, arms=arms, of=of, memory=memory)

    def _memory(self, values: Mapping[str, Numbers], torque: Floats) -> Floats:
        """(N, k) joint states."""
        return self.data.history.state(self.unknowns.effects, values, torque, self.resting)

    def _read(
        self, state: SessionState, p: Floats, own: Floats, *, arms: ArmEquilibria, of: Index, memory: Floats
    ) -> PredictedReadings:
        """What the tracker reads of arms at rest, one for every reading (N,), with joint states (N, k)."""
        data, places = self.data, self.data.station.reflectors(own)
        base, by_number, by_w, by_state, link = self._positions(p, arms, of, places)
        if memory.shape[1]:
            moved = data.history.slopes(
                effects=self.unknowns.effects,
                values=self.unknowns.values(p, self.fixed),
                torque=state.torque,
                resting=self.resting,
                state=memory,
                only={(u.effect, u.parameter.name) for u in self.unknowns.free},
            )
            by_number = self._with_memory(by_number, by_state, moved)
        poses = data.station.placed(base) if state.poses is None else state.poses
        read, back, by_station = data.station.seen(own, base, poses)
        by_reflector = data.station.reflector_derivative(own)[data.samples.reflector]
        seen = PredictedReadings(
            position=read,
            by_number=by_number.turned(back),
            by_station=by_station + back @ (link @ by_reflector),
            by_wrench=back @ by_w,
            back=back,
            state=replace(state, poses=poses),
        )
        return self._shown(p, seen)

    def _equilibria(
        self, p: Floats, places: Floats, memory: Floats, x: Floats, *, steps: int = STEPS
    ) -> tuple[ArmEquilibria, Index, Floats, Floats]:
        """Arms at rest, one for all readings that share load and posture; which of them every reading is (N,); and
        elastic coordinates and torques of every reading."""
        loads = self.data.loads(places, memory)
        first, of = self.data.cases(loads)
        parts = []
        for kind, rows in self.data.kinds.items():
            some = np.flatnonzero(rows[first])
            at = first[some]
            parts.append((some, self.model.equilibria(kind, p, loads.take(at), x[at], steps=steps)))
        arms = ArmEquilibria.gathered(parts)
        return arms, of, arms.x[of], arms.torque[of]

    def _positions(
        self, p: Floats, arms: ArmEquilibria, of: Index, places: Floats
    ) -> tuple[Floats, ReadingSlopes, Floats, Floats, Floats]:
        """Reflectors (N, 3) in the base, derivatives by parameters, wrench and memory, rotations of their links."""
        s, count, tables = self.data.samples, len(self.data.samples), self.model.tables
        base, link = np.empty((count, 3)), np.empty((count, 3, 3))
        widths = len(tables.core), arms.by_angle.shape[2], 6, arms.by_state.shape[2]
        by_core, by_angle, by_w, by_state = (np.empty((count, 3, w)) for w in widths)
        for rows in pieces_of_links(self.data.link):
            k = int(self.data.link[rows[0]])
            out = self.model.positions(arms.take(of[rows]), k, places[s.reflector[rows]])
            base[rows], link[rows] = out.position, out.rotation
            by_w[rows], by_state[rows] = out.by_wrench, out.by_state
            by_core[rows], by_angle[rows] = out.by_parameter, out.by_angle
        by_number = ReadingSlopes(
            count=len(p),
            core=tables.core,
            dense=by_core,
            own=tables.own,
            joint=tables.joint,
            by_angle=by_angle,
            slope=tables.slopes(arms.q, p),
            of=of,
        )
        return base, by_number, by_w, by_state, link

    def _with_memory(
        self, by_number: ReadingSlopes, by_state: Floats, moved: Mapping[tuple[str, str], Floats]
    ) -> ReadingSlopes:
        """Derivatives by parameters, with what these do to a reading by way of the joint states that they shift."""
        n, out = self.data.session.robot.n, by_number.dense.copy()
        columns = state_columns(self.unknowns.effects, n)
        for k, u in enumerate(self.unknowns.free[i] for i in by_number.core):
            shares = moved.get((u.effect, u.parameter.name))
            if shares is not None:
                own = by_state[:, :, columns[u.effect]][:, :, u.index :: n]  # all states of the joint
                out[:, :, k] += np.einsum("nik,nk->ni", own, shares[:, u.index :: n])
        return replace(by_number, dense=out)

    def _shown(self, p: Floats, seen: PredictedReadings) -> PredictedReadings:
        """What the tracker shows of it: effects that fill ``position_reading``."""
        if self._instruments is None:
            return seen
        position, by_position, by_p = self._instruments.run(seen.position, self.data.time, p)
        turn = np.swapaxes(by_position.reshape(-1, 3, 3), 1, 2)
        turned = seen.by_number.turned(turn)
        own = np.swapaxes(by_p.reshape(len(position), -1, 3), 1, 2)
        return PredictedReadings(
            position=position,
            by_number=replace(turned, dense=turned.dense + own),
            by_station=turn @ seen.by_station,
            by_wrench=turn @ seen.by_wrench,
            back=turn @ seen.back,
            state=seen.state,
        )

    def shown_slopes(self, position: Floats, p: Floats, rows: Index) -> Floats:
        """(K, 3, C): derivatives, by parameters of instruments alone, of what is shown of positions (K, 3), those of
        some ``rows`` (K,); C without the numbers of tables."""
        if self._instruments is None:
            return np.zeros((len(position), 3, len(self.model.tables.core)))
        _, _, by_p = self._instruments.run(position, self.data.time[rows], p)
        return np.swapaxes(by_p.reshape(len(position), -1, 3), 1, 2)

    @cached_property
    def _instruments(self) -> Kernel | None:
        """(position, time, parameters) -> position shown, its derivatives by position and by parameters but tables."""
        path = self.data.session.path
        points = path is None or not path.scalar
        surface = path is not None and path.kind == "surface" and not path.as_said
        at, time, p = ca.SX.sym("at", 3), ca.SX.sym("time"), ca.SX.sym("p", len(self.unknowns))
        values, shown = self.unknowns.values(p, self.fixed), at
        for e in self.unknowns.effects:
            if points and e.position_reading:
                shown = e.position_reading(shown, time, values[e.name])
            elif surface and e.surface_reading:
                shown = ca.vertcat(e.surface_reading(shown[0], values[e.name]), shown[1:])
        if shown is at:
            return None
        by_core = ca.jacobian(shown, p)[:, self.model.tables.core.tolist()]
        out = [shown, ca.jacobian(shown, at), by_core]
        return Kernel(ca.Function("shown", [at, time, p], [ca.densify(ca.vec(v)) for v in out]))
