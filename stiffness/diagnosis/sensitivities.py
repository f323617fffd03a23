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
from stiffness.identification.arm_loads import LoadKind, pieces_of_links
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


class Sensitivities:
    """All effects of one session at once. Constant: only kernels are kept.

    Args:
        effects: of the model and of the catalogue.
        numbers: those that derivatives are wanted for.
    """

    def __init__(self, data: SessionData, effects: Sequence[Effect], numbers: Sequence[Unknown]) -> None:
        n = data.session.robot.n
        every = [
            Unknown(e.name, p, k) for e in effects for p in e.parameters for k in range(p.count(n))
        ]  # shapes too: trials change them
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

    def of(self, fit: SessionFit, values: Mapping[str, Numbers]) -> ReadingSlopes:
        """Derivatives of what is read by ``numbers``, at the postures of a fit.

        Args:
            values: of all effects; neutral or on trial where the fit does not have them.
        """
        model, data, seen = self._model, self.data, fit.predicted
        x = self._coordinates(fit)
        memory = data.history.state(self.layout.effects, values, seen.torque, self._predictor.resting)
        loads = data.loads(fit.reflectors, memory)
        first, of = data.cases(loads)
        p = self.layout.start(values)
        error = model.tables.error(data.samples.q, p)
        runs, run_of = [], np.zeros(len(first), dtype=np.intp)
        for kind, rows in data.kinds.items():
            some = np.flatnonzero(rows[first])
            at, d = first[some], self._derivatives(kind)
            own = loads.take(at)
            given = (own.q, own.wrench, own.point, own.payload, own.warm, own.state, error[at])
            (nonzero,) = d.kernel.run(*given, p[model.tables.core], x[at], own.axes)
            run_of[some] = np.arange(len(some))
            runs.append((rows, d, nonzero))
        dense = np.zeros((len(data.samples), 3, len(self._core)))
        by_angle = np.zeros((len(data.samples), 3, self.layout.joints))
        for piece in pieces_of_links(data.link):
            by_x = self._by_coordinate(x, piece, fit.reflectors)
            slope = np.zeros((len(piece), model.statics.n_x, len(self._core)))
            for rows, d, nonzero in runs:
                mine = np.flatnonzero(rows[piece])
                slope[mine[:, None], d.row[None], d.column[None]] = nonzero[run_of[of[piece[mine]]]]
            dense[piece] = by_x @ slope
            by_angle[piece] = by_x[:, :, : self.layout.joints]
        tables = self._model.tables
        place = np.searchsorted(tables.own, self._columns[self._tabled])
        shown = self._predictor.shown_slopes(seen.position, p)
        base = ReadingSlopes(
            count=len(self.numbers),
            core=self._core,
            dense=dense,
            own=self._tabled,
            joint=tables.joint[place],
            by_angle=by_angle,
            slope=tables.slopes(data.samples.q[first], p)[:, place],
            of=of,
        ).turned(seen.back)
        return replace(base, dense=base.dense + shown[:, :, np.searchsorted(tables.core, self._columns[self._core])])

    def geometry(self, fit: SessionFit) -> Floats:
        """(N, 3, n + 6 (n + 1)) derivatives of what is read by every joint angle and by the six coordinates of every
        place 0 ... n."""
        x = self._coordinates(fit)
        out = np.zeros((len(self.data.samples), 3, x.shape[1]))
        for rows in pieces_of_links(self.data.link):
            out[rows] = self._by_coordinate(x, rows, fit.reflectors)
        return np.asarray(fit.predicted.back @ out)

    def _by_coordinate(self, x: Floats, rows: Index, places: Floats) -> Floats:
        samples, motion, k = self.data.samples, self._model.motion, int(self.data.link[rows[0]])
        frames = motion.frames(samples.q[rows], x[rows])
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
