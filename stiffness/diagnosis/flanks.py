"""Flanks: sessions with approaches on trial, and the two flanks of a joint that their residuals tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stiffness.effects import CATALOGUE
from stiffness.effects.backlash import EFFECT as GAP
from stiffness.identification.fit import Fit
from stiffness.identification.load_history import LoadHistory
from stiffness.identification.problem import Problem, States
from stiffness.identification.unknowns import Unknowns, numbers_of
from stiffness.identification.weighting import Weighting
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/diagnosis/test_told_approaches.py
PROBE = 1e-4  # rad
TURNS = 20  # of signs and gap


def without_approaches(session: Session) -> bool:
    """Whether nothing tells how the joints came to their set-ups."""
    return session.path is None and not np.any(session.samples.approach)


@dataclass(frozen=True, repr=False, eq=False)
class OnTrial:
    """Sessions with some approaches, a model with a gap, and the numbers of the sessions' stations.

    Attributes:
        used: per session (N,). own: per session (S,). unknown: per session, whether approaches are to be told.
    """

    fit: Fit
    sessions: list[Session]
    values: dict[str, dict[str, Floats]]
    used: list[Bools]
    own: list[Floats]
    unknown: list[bool]
    misfit: float

    @classmethod
    def of(cls, fit: Fit, outliers: Sequence[tuple[str, int]]) -> OnTrial:
        wrong = set(outliers)
        n = fit.unknowns.joints
        values = {name: {k: np.array(v) for k, v in own.items()} for name, own in fit.values().items()}
        values.setdefault(GAP.name, {k: v.copy() for k, v in GAP.neutral(n).items()})
        return cls(
            fit=fit,
            sessions=[s.session for s in fit.sessions],
            values=values,
            used=[
                np.array([(s.session.source, int(line)) not in wrong for line in s.samples.line])
                for s in fit.sessions
            ],
            own=[s.own for s in fit.sessions],
            unknown=[without_approaches(s.session) for s in fit.sessions],
            misfit=fit.solution.misfit,
        )

    @property
    def joints(self) -> int:
        return self.fit.unknowns.joints

    def _problem(self, free: Sequence[int] | None) -> Problem:
        """With all numbers of the fit free, and the gaps of the joints ``free``; with None, none."""
        effects = tuple(e for e in CATALOGUE if e.name in self.values)
        layout = Unknowns(effects, self.joints, ())
        if free is not None:
            sites = [s for j, s in enumerate(GAP.sites(self.joints)) if j in free]
            more = [u for s in sites for u in numbers_of(GAP, s, self.joints)]
            own = self.fit.unknowns.free
            layout = replace(layout, free=(*own, *(u for u in more if u not in own)))
        data = [
            replace(old.observations.data, session=s, history=LoadHistory(s)) if unknown else old.observations.data
            for old, s, unknown in zip(self.fit.sessions, self.sessions, self.unknown, strict=True)
        ]
        return Problem.of_sessions(data, [Weighting(s, 0.0) for s in self.sessions], layout, self.values)

    def _states(self, problem: Problem) -> States:
        poses = [s.state.poses for s in self.fit.sessions]
        first = problem.first_states()
        return tuple(replace(s, used=u, poses=p) for s, u, p in zip(first, self.used, poses, strict=True))

    def residuals(self) -> list[Floats]:
        """Whitened, of every set-up, in the order of their numbers, of every session."""
        problem, own = self._problem(None), np.concatenate(self.own)
        states = self._states(problem)
        out: list[Floats] = []
        for s in problem.sessions(own, states):
            parts: dict[int, list[Floats]] = {int(k): [np.empty(0)] for k in np.unique(s.samples.setup)}
            for block in s.blocks():
                parts[int(s.samples.setup[block.rows[0]])].append(block.residual)
            out += [np.concatenate(part) for part in parts.values()]
        return out

    def with_gap(self, joint: int, gap: float, breakaway: float, sign: Ints | int | None = None) -> OnTrial:
        """With one gap, and approaches of its joint: ``sign`` for every set-up."""
        values = {name: {k: v.copy() for k, v in own.items()} for name, own in self.values.items()}
        for name, value in (("gap_rad", gap), ("breakaway_nm", breakaway), ("side", 1.0)):
            values[GAP.name][name][joint] = value
        if sign is None:
            return replace(self, values=values)
        sessions, at = [], 0
        for s, unknown in zip(self.sessions, self.unknown, strict=True):
            _, of = np.unique(s.samples.setup, return_inverse=True)
            count = int(of.max()) + 1
            own = np.full(count, sign) if isinstance(sign, int) else sign[at : at + count]
            at += count
            if unknown:
                approach = s.samples.approach.copy()
                approach[:, joint] = own[of.ravel()]
                s = replace(s, samples=replace(s.samples, approach=approach))
            sessions.append(s)
        return replace(self, sessions=sessions, values=values)

    def with_flanks(self, found: Flanks) -> OnTrial:
        return self.with_gap(found.joint, found.gap, found.breakaway, found.sign)

    def refitted(self, where: Sequence[int]) -> OnTrial:
        """With all numbers fitted again."""
        problem = self._problem(where)
        start = np.concatenate([problem.unknowns.start(self.values), *self.own])
        solution, _ = problem.solved(self._states(problem), start)
        p = len(problem.unknowns)
        own = [solution.vector[at] for at in problem.columns]
        return replace(
            self, values=problem.unknowns.values(solution.vector[:p], self.values), own=own, misfit=solution.misfit
        )

    def signs(self) -> Ints:
        """Approaches of all joints, session after session."""
        return np.concatenate([s.samples.approach for s in self.sessions])


@dataclass(frozen=True, repr=False, eq=False)
class Flanks:
    """Two flanks of a joint: the ``gap`` rad, the ``sign`` of every set-up, chi-square ``before`` (without a gap there)
    and with them."""

    joint: int
    breakaway: float
    gap: float
    sign: Ints
    before: float
    chi2: float

    @classmethod
    def of(
        cls, at: OnTrial, joint: int, breakaway: float, *, sure: float = 0.0, none: Sequence[Floats] = ()
    ) -> Flanks:
        """As the residuals tell, ``none`` without a gap; signs that make less than ``sure`` of chi-square are 0."""
        none = none or at.with_gap(joint, 0.0, breakaway, 0).residuals()
        plus, minus = ((at.with_gap(joint, PROBE, breakaway, s)).residuals() for s in (1, -1))
        up = [(a - b) / PROBE for a, b in zip(none, plus, strict=True)]
        down = [(a - b) / PROBE for a, b in zip(none, minus, strict=True)]
        m = [(a + b) / 2 for a, b in zip(up, down, strict=True)]
        d = [(a - b) / 2 for a, b in zip(up, down, strict=True)]
        begun = {float(at.values[GAP.name]["gap_rad"][joint]), 0.5 * PROBE, PROBE, 2 * PROBE, 4 * PROBE}
        gap, sign = min((_turned(none, m, d, g) for g in begun), key=lambda f: _left(none, m, d, f))
        pull = np.array([4 * gap * float(b @ (r - gap * a)) for r, a, b in zip(none, m, d, strict=True)])
        sign = np.where(np.abs(pull) < max(sure, 1e-9), 0, sign)
        return cls(
            joint=joint,
            breakaway=breakaway,
            gap=gap,
            sign=sign,
            before=square(none),
            chi2=_left(none, m, d, (gap, sign)),
        )


def _turned(r: Sequence[Floats], m: Sequence[Floats], d: Sequence[Floats], gap: float) -> tuple[float, Ints]:
    """A gap of a flank that leads (the sign of the approach has no other meaning), and the signs."""
    sign = np.zeros(len(r), dtype=np.int64)
    for _ in range(TURNS):
        sign = np.array([1 if b @ (x - gap * a) >= 0 else -1 for x, a, b in zip(r, m, d, strict=True)], dtype=np.int64)
        c = [a + s * b for a, b, s in zip(m, d, sign, strict=True)]
        new = max(sum(float(a @ x) for a, x in zip(c, r, strict=True)) / max(square(c), 1e-300), 0.0)
        if abs(new - gap) < 1e-9:
            break
        gap = new
    return gap, sign


def _left(r: Sequence[Floats], m: Sequence[Floats], d: Sequence[Floats], found: tuple[float, Ints]) -> float:
    gap, sign = found
    return square([x - gap * (a + s * b) for x, a, b, s in zip(r, m, d, sign, strict=True)])


def square(parts: Sequence[Floats]) -> float:
    return float(sum(x @ x for x in parts))
