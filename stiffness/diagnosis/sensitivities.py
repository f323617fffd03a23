"""Screen: how every number of every effect would move every reading, at a fit that does not have them.

One sweep of the statics with all effects in it, at their neutral values and the posture of the fit, gives the slopes of
the elastic coordinates by all numbers at once; kinematics makes readings of them (sight.py). What the first deflection
itself changes is left out: a hundredth of an effect, and the fit that follows has it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers
from stiffness.identification.readings import Pull
from stiffness.identification.session_fit import Evidence, Predicted
from stiffness.identification.unknowns import Unknown, Unknowns
from stiffness.numerics.kernel import Kernel

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

PIECE = 512  # readings at a time


class Screen:
    """All effects of one session at once.

    Args:
        evidence: the session; its model's effects are among ``effects``.
        effects: of the model and of the catalogue.
        numbers: those that slopes are wanted for.
    """

    def __init__(self, evidence: Evidence, effects: Sequence[Effect], numbers: Sequence[Unknown]) -> None:
        n = evidence.session.robot.n
        every = [
            Unknown(e.name, p, k) for e in effects for p in e.parameters for k in range(p.count(n))
        ]  # shapes too: trials change them
        self.layout = Unknowns(tuple(effects), n, tuple(every))
        self.numbers = tuple(numbers)
        place = {(u.effect, u.parameter.name, u.index): k for k, u in enumerate(every)}
        self._columns = np.array([place[u.effect, u.parameter.name, u.index] for u in numbers], dtype=np.intp)
        tabled = {e.name for e in effects if e.angle}
        self._core = np.flatnonzero([u.effect not in tabled for u in numbers])
        self._tabled = np.flatnonzero([u.effect in tabled for u in numbers])
        self._all = Evidence(evidence.session, self.layout, {e.name: e.neutral(n) for e in effects})
        self._kernels: dict[Pull, tuple[Kernel, Index, Index]] = {}

    def of(self, evidence: Evidence, seen: Predicted, station: Floats, values: Mapping[str, Numbers]) -> Floats:
        """(N, 3, P) slopes of what is read by ``numbers``.

        Args:
            seen: what the fit predicts: its postures are taken.
            station: the session's own numbers.
            values: of all effects; neutral or on trial where the fit does not have them.
        """
        reader = self._all.reader
        x = self._coordinates(evidence, seen)
        state = self._all.histories.state(self.layout.effects, values, seen.torque, self._all.resting)
        places = evidence.station.reflectors(station)
        given: tuple[Floats, ...] = (*evidence.inputs(places), state)
        first, of = evidence.cases(np.concatenate(given, axis=1))
        p = self.layout.start(values)
        error = reader.tables.error(evidence.samples.q, p)
        given = (*given, error)
        slope = np.zeros((len(first), reader.statics.n_x, len(self._core)))
        for pull, rows in evidence.pulls.items():
            some = np.flatnonzero(rows[first])
            kernel, row, column = self._kernel(pull)
            (nonzero,) = kernel.run(*(a[first[some]] for a in given), p[reader.tables.core], x[first[some]])
            slope[some[:, None], row[None], column[None]] = nonzero
        out = np.zeros((len(evidence.samples), 3, len(self.numbers)))
        for piece in _pieces(evidence.link):
            by_x = self._by_coordinate(evidence, x, piece, places)
            out[piece[:, None, None], np.arange(3)[:, None], self._core] = by_x @ slope[of[piece]]
            if len(self._tabled):
                out[piece[:, None, None], np.arange(3)[:, None], self._tabled] = self._by_table(
                    evidence, p, piece, by_x
                )
        return seen.back @ out + self._all.shown_slopes(seen.position, p)[:, :, self._columns]

    def _by_table(self, evidence: Evidence, p: Floats, rows: Index, by_x: Floats) -> Floats:
        """(K, 3, T) slopes by numbers of laws of the angle alone."""
        tables = self._all.reader.tables
        place = np.searchsorted(tables.own, self._columns[self._tabled])
        shares = tables.slopes(evidence.samples.q[rows], p)[:, place]
        return np.asarray(by_x[:, :, tables.joint[place]] * shares[:, None])

    def geometry(self, evidence: Evidence, seen: Predicted, station: Floats) -> Floats:
        """(N, 3, n + 6 (n + 1)) slopes of what is read by every joint angle and by the displacement of every place."""
        x, places = self._coordinates(evidence, seen), evidence.station.reflectors(station)
        out = np.zeros((len(evidence.samples), 3, x.shape[1]))
        for rows in _pieces(evidence.link):
            out[rows] = self._by_coordinate(evidence, x, rows, places)
        return np.asarray(seen.back @ out)

    def _by_coordinate(self, evidence: Evidence, x: Floats, rows: Index, places: Floats) -> Floats:
        k, sight = int(evidence.link[rows[0]]), self._all.reader.sight
        frames = sight.frames(evidence.samples.q[rows], x[rows])
        at = places[evidence.samples.reflector[rows]]
        point = frames.origin[:, k] + np.einsum("nij,nj->ni", frames.rotation[:, k], at)
        return sight.slopes(frames, k, point)

    def _coordinates(self, mine: Evidence, seen: Predicted) -> Floats:
        """(N, n_x) elastic coordinates of the fit, in the order of all effects."""
        n, own, whole = mine.session.robot.n, mine.reader.statics, self._all.reader.statics
        x = np.zeros((len(mine.samples), whole.n_x))
        x[:, :n] = seen.x[:, :n]
        for i, k in enumerate(own.places):
            at = n + 6 * whole.places.index(k)
            x[:, at : at + 6] = seen.x[:, n + 6 * i : n + 6 * i + 6]
        return x

    def _kernel(self, pull: Pull) -> tuple[Kernel, Index, Index]:
        if pull not in self._kernels:
            self._kernels[pull] = self._built(pull)
        return self._kernels[pull]

    def _built(self, pull: Pull) -> tuple[Kernel, Index, Index]:
        reader, s = self._all.reader, self._all.reader.statics
        n = reader.robot.n
        q, w, point = (ca.SX.sym(k, m) for k, m in (("q", n), ("w", 6), ("point", 3)))
        state, payload, warm = ca.SX.sym("state", s.n_state), ca.SX.sym("payload"), ca.SX.sym("warm")
        tables = reader.tables
        error = ca.SX.sym("error", n if tables else 0)
        p, x = ca.SX.sym("p", len(tables.core)), ca.SX.sym("x", s.n_x)
        values = self.layout.values(tables.whole(p), self._all.fixed)
        full = [e.memory.bounds(values[e.name]) for e in s.remembering if e.memory]
        own = state * ca.vertcat(*full) if full else state
        posture = s.posture(q, x)
        load = reader.load(pull, posture, w, point, values)
        new, _ = s.law(posture, q, reader.weights(values, payload), load, own, values, warm, error if tables else None)
        wanted = np.searchsorted(tables.core, self._columns[self._core])
        jacobian = ca.jacobian(new, p)[:, wanted.tolist()]
        row, column = (np.array(v, dtype=np.intp) for v in jacobian.sparsity().get_triplet())
        nonzero = ca.SX(jacobian.nz[:])
        given = [q, w, point, payload, warm, state, error, p, x]
        return Kernel(ca.Function("screen", given, [ca.densify(nonzero)])), row, column


def _pieces(link: Index) -> list[Index]:
    """Readings of one link each, few enough at a time to keep memory small."""
    each = [np.flatnonzero(link == k) for k in np.unique(link)]
    return [part for rows in each for part in np.array_split(rows, -(-len(rows) // PIECE))]
