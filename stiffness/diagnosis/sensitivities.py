"""Sensitivities: how every number of every effect would move every reading, at a fit that does not have them.

One sweep of the statics with all effects in it, neutral and at the posture of the fit, gives derivatives of the
elastic coordinates by all numbers at once; kinematics makes derivatives of readings of them
(statics/point_motion.py). How the posture itself answers is left out: it changes a derivative by about one percent, and
the fit that follows has it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers
from stiffness.identification.arm_loads import ArmLoads, LoadKind, pieces_of_links
from stiffness.identification.prediction import SessionPredictor
from stiffness.identification.reading_slopes import ReadingSlopes
from stiffness.identification.session_data import SessionData
from stiffness.identification.session_fit import SessionFit
from stiffness.identification.unknowns import Unknown, Unknowns
from stiffness.numerics.kernel import Kernel

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


@dataclass(frozen=True, repr=False, eq=False)
class _Derivatives:
    """Kernel of the derivatives that are not always zero, and the ``row`` and ``column`` of each."""

    kernel: Kernel
    row: Index
    column: Index


@dataclass(frozen=True, repr=False, eq=False)
class _Run:
    """Derivatives under loads of one kind.

    Attributes:
        readings: (K,) those with such a load. place: (M,) where a case stands in ``nonzero`` (m, Z).
        row, column: (Z,) elastic coordinate and number of each derivative.
    """

    readings: npt.NDArray[np.bool_]
    place: Index
    row: Index
    column: Index
    nonzero: Floats


class Sensitivities:
    """All effects of one session at once. Constant: only kernels are kept.

    Args:
        effects: of the model and of the catalogue.
        numbers: those that derivatives are wanted for.
    """

    def __init__(self, data: SessionData, effects: Sequence[Effect], numbers: Sequence[Unknown]) -> None:
        n = data.session.robot.n
        asked, of = {(u.effect, u.parameter.name) for u in numbers}, {u.effect for u in numbers}
        every = [
            Unknown(e.name, p, k)
            for e in effects
            for p in e.parameters
            # shapes too, trials change them; a table that no derivative is wanted of would be a column of zeros each
            if not (e.angle and e.name in of) or (e.name, p.name) in asked
            for k in range(p.count(n))
        ]
        self.data, self.numbers = data, tuple(numbers)
        self.layout = Unknowns(tuple(effects), n, tuple(every))
        place = {(u.effect, u.parameter.name, u.index): k for k, u in enumerate(every)}
        self._columns = np.array([place[u.effect, u.parameter.name, u.index] for u in numbers], dtype=np.intp)
        tabled = {e.name for e in effects if e.angle}
        self._core = np.flatnonzero([u.effect not in tabled for u in numbers])
        self._tabled = np.flatnonzero([u.effect in tabled for u in numbers])
        self._predictor = SessionPredictor.of(data, self.layout, {e.name: e.neutral(n) for e in effects})
        self._model = self._predictor.model
        self._kernels: dict[LoadKind, _Derivatives] = {}

    def __repr__(self) -> str:
        return f"Sensitivities({self.data.session.source!r}, {len(self.numbers)} numbers)"

    def of(
        self,
        fit: SessionFit,
        values: Mapping[str, Numbers],
        rows: Index | None = None,
        wanted: Index | None = None,
    ) -> ReadingSlopes:
        """Derivatives of what is read by ``numbers``, at the postures of a fit.

        Args:
            values: of all effects; neutral or on trial where the fit does not have them.
            rows: (K,) readings; None: all, in their order.
            wanted: (C,) which of the numbers, in ascending order; None: all.
        """
        model, data, seen = self._model, self.data, fit.predicted
        rows = np.arange(len(data.samples)) if rows is None else rows
        wanted = np.arange(len(self.numbers)) if wanted is None else wanted
        x = self._coordinates(fit)[rows]
        memory = data.history.state(self.layout.effects, values, seen.torque, self._predictor.resting)
        loads = data.loads(fit.reflectors, memory).take(rows)
        first, of = data.cases(loads, rows)
        p = self.layout.start(values)
        core, own = (np.flatnonzero(np.isin(some, wanted)) for some in (self._core, self._tabled))
        runs = self._runs(p, x=x, loads=loads, rows=rows, first=first, core=core)
        dense = np.zeros((len(rows), 3, len(core)))
        by_angle = np.zeros((len(rows), 3, self.layout.joints))
        for piece in pieces_of_links(data.link[rows]):
            by_x = self._by_coordinate(x[piece], rows[piece], fit.reflectors)
            slope = np.zeros((len(piece), model.statics.n_x, len(core)))
            for run in runs:
                mine = np.flatnonzero(run.readings[piece])
                slope[mine[:, None], run.row[None], run.column[None]] = run.nonzero[run.place[of[piece[mine]]]]
            dense[piece] = by_x @ slope
            by_angle[piece] = by_x[:, :, : self.layout.joints]
        tables, none = model.tables, np.zeros((len(first), 0))
        place = np.searchsorted(tables.own, self._columns[self._tabled[own]])
        base = ReadingSlopes(
            count=len(wanted),
            core=np.searchsorted(wanted, self._core[core]),
            dense=dense,
            own=np.searchsorted(wanted, self._tabled[own]),
            joint=tables.joint[place],
            by_angle=by_angle,
            slope=tables.slopes(loads.q[first], p)[:, place] if len(own) else none,
            of=of,
        ).turned(seen.back[rows])
        shown = self._predictor.shown_slopes(seen.position[rows], p, rows)
        return replace(
            base, dense=base.dense + shown[:, :, np.searchsorted(tables.core, self._columns[self._core[core]])]
        )

    def _runs(
        self, p: Floats, *, x: Floats, loads: ArmLoads, rows: Index, first: Index, core: Index
    ) -> list[_Run]:
        """Derivatives of the elastic coordinates of the ``first`` readings of each case, kind of load by kind."""
        error, out = self._model.tables.error(loads.q[first], p), []
        column = np.full(len(self._core), -1)
        column[core] = np.arange(len(core))
        for kind, every in self.data.kinds.items():
            some = np.flatnonzero(every[rows[first]])
            if not len(some):
                continue
            at, d = first[some], self._derivatives(kind)
            own = loads.take(at)
            given = (own.q, own.wrench, own.point, own.payload, own.warm, own.state, error[some])
            (nonzero,) = d.kernel.run(*given, p[self._model.tables.core], x[at], own.axes)
            there = column[d.column] >= 0
            place = np.zeros(len(first), dtype=np.intp)
            place[some] = np.arange(len(some))
            out.append(
                _Run(
                    readings=every[rows],
                    place=place,
                    row=d.row[there],
                    column=column[d.column[there]],
                    nonzero=nonzero[:, there],
                )
            )
        return out

    def geometry(self, fit: SessionFit) -> Floats:
        """(N, 3, n + 6 (n + 1)) derivatives of what is read by every joint angle and by the six coordinates of every
        place 0 ... n."""
        x = self._coordinates(fit)
        out = np.zeros((len(self.data.samples), 3, x.shape[1]))
        for rows in pieces_of_links(self.data.link):
            out[rows] = self._by_coordinate(x[rows], rows, fit.reflectors)
        return np.asarray(fit.predicted.back @ out)

    def _by_coordinate(self, x: Floats, rows: Index, places: Floats) -> Floats:
        """(K, 3, n_x) of readings of one link with coordinates ``x`` (K, n_x)."""
        samples, motion, k = self.data.samples, self._model.motion, int(self.data.link[rows[0]])
        frames = motion.frames(samples.q[rows], x)
        at = places[samples.reflector[rows]]
        point = frames.origin[:, k] + np.einsum("nij,nj->ni", frames.rotation[:, k], at)
        return motion.slopes(frames, k, point)

    def _coordinates(self, fit: SessionFit) -> Floats:
        """(N, n_x) elastic coordinates of a fit, in the order of all effects."""
        n, own, whole = self.layout.joints, fit.observations.predictor.model.statics, self._model.statics
        x = np.zeros((len(self.data.samples), whole.n_x))
        x[:, :n] = fit.predicted.x[:, :n]
        for i, k in enumerate(own.places):
            at = n + 6 * whole.places.index(k)
            x[:, at : at + 6] = fit.predicted.x[:, n + 6 * i : n + 6 * i + 6]
        return x

    def _derivatives(self, kind: LoadKind) -> _Derivatives:
        if kind not in self._kernels:
            self._kernels[kind] = self._built(kind)
        return self._kernels[kind]

    def _built(self, kind: LoadKind) -> _Derivatives:
        model, s = self._model, self._model.statics
        n = model.robot.n
        q, w, point = (ca.SX.sym(k, m) for k, m in (("q", n), ("w", 6), ("point", 3)))
        state, payload, warm = ca.SX.sym("state", s.n_state), ca.SX.sym("payload"), ca.SX.sym("warm")
        tables = model.tables
        error = ca.SX.sym("error", n if tables else 0)
        p, x = ca.SX.sym("p", len(tables.core)), ca.SX.sym("x", s.n_x)
        values = self.layout.values(tables.whole(p), self._predictor.fixed)
        full = [e.memory.bounds(values[e.name]) for e in s.remembering if e.memory]
        own = state * ca.vertcat(*full) if full else state
        posture = s.posture(q, x)
        axes = ca.SX.sym("axes", 9 if kind.programmed else 0)
        load = model.acting(kind=kind, posture=posture, w=w, point=point, values=values, path_axes=axes)
        new, _ = s.law(
            posture=posture,
            q=q,
            weights=model.weights(values, payload),
            loads=load,
            state=own,
            values=values,
            temperature=warm,
            angle_error=error if tables else None,
        )
        wanted = np.searchsorted(tables.core, self._columns[self._core])
        jacobian = ca.jacobian(new, p)[:, wanted.tolist()]
        row, column = (np.array(v, dtype=np.intp) for v in jacobian.sparsity().get_triplet())
        nonzero = ca.SX(jacobian.nz[:])
        given = [q, w, point, payload, warm, state, error, p, x, axes]
        return _Derivatives(Kernel(ca.Function("sensitivities", given, [ca.densify(nonzero)])), row, column)
