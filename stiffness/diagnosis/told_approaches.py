"""Told approaches: on which flank a joint came to rest, read off the readings where a session has no approach columns.

Without them the state of a gap is not known until a torque chooses it, and a gap that no torque chooses is not seen at
all. Yet a joint stands on one of two flanks in every set-up. With the readings' derivatives by a gap, m where a torque
chooses the flank and d where the approach does (+ or -), the residual of set-up i is

    r_i = g (m_i + s_i d_i) + noise        s_i = +1 or -1, one gap g for all

and g and the s_i follow in turn (a mixture of two with one distance). Random rotations z of a joint lose
(mean |z|)^2 / mean z^2 of their square to the best signs, two thirds of a normal distribution; two flanks lose all. So
the signs are tried in a whole diagnosis and stand where it is left with hardly anything.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.candidates import trials
from stiffness.diagnosis.result import Diagnosis
from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.identification.fit import Fit
from stiffness.identification.load_history import LoadHistory
from stiffness.identification.observations import SessionObservations
from stiffness.identification.problem import Problem, States
from stiffness.identification.unknowns import Unknowns, numbers_of
from stiffness.identification.weighting import Weighting
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/diagnosis/test_told_approaches.py
GAP = BY_NAME["backlash"]
PROBE = 1e-4  # rad
TURNS = 20  # of signs and gap
PART = 0.1  # of what is above the noise: a joint whose two flanks explain less is left
ROUNDS = 3  # of signs and a fit of all numbers
SURE = 9.0  # of chi-square over the misfit: signs that differ by less are not told
RIGHT = 0.1  # of what was above the noise may be left: random rotations leave a third, a wobble a fifth


@dataclass(frozen=True)
class ToldApproaches:
    """``sessions`` with the approaches that their readings tell; ``where``: joints, numbers from 0. told: how many
    approaches, ``of`` how many."""

    sessions: tuple[Session, ...]
    where: tuple[int, ...]
    told: int
    of: int

    def explain(self, before: Diagnosis, after: Diagnosis) -> bool:
        """Whether a diagnosis with them is left with hardly anything of what one without them is."""
        first, last = before.fit.solution, after.fit.solution
        paid = 2 * np.log(2) * self.told
        return bool(last.chi2 + paid - last.freedom < RIGHT * (first.chi2 - first.freedom))

    @property
    def note(self) -> str:
        """For the report."""
        joints = ", ".join(f"joint {j + 1}" for j in self.where)
        return (
            f"no approach columns: the flanks that {joints} came to rest on are read off the readings themselves, "
            f"{self.told} of {self.of} are told. Columns approach1 ... make it sure, and tell the rest"
        )


MISSING = (
    "no approach columns: on which flank a gap came to rest is not known where no torque chooses it; what is left may "
    "be that. Add columns approach1 ... (the sign of the last rotation of each joint before the set-up)"
)


def without_approaches(session: Session) -> bool:
    """Whether nothing tells how the joints came to their set-ups."""
    return session.path is None and not np.any(session.samples.approach)


def with_told_approaches(
    found: Diagnosis, again: Callable[[tuple[Session, ...], str], Diagnosis], say: Callable[[str], None]
) -> Diagnosis:
    """A diagnosis of sessions, or that of the same with the approaches that their readings tell, where it explains what
    the first is left with.

    Args:
        again: sessions, what to note -> the diagnosis of these.
    """
    remembers = any(BY_NAME[a.effect].memory for a in found.added)
    missing = any(without_approaches(s.session) for s in found.fit.sessions)
    if not missing or not (found.verdict == "unexplained" or remembers):
        return found
    say("95 %: reading approaches off the readings")
    told = told_approaches(found.fit, found.outliers)
    if told is not None and told.explain(found, other := again(told.sessions, told.note)):
        return other
    return replace(found, notes=(*found.notes, MISSING)) if remembers else found


def told_approaches(fit: Fit, outliers: Sequence[tuple[str, int]]) -> ToldApproaches | None:
    """What the readings of a fit tell of approaches; None where two flanks of no joint explain a part of its residual.

    Args:
        outliers: (session, line) of readings that take no part.
    """
    now = _Point.of(fit, outliers)
    above = _square(now.residuals()) - fit.solution.freedom * _share(now, fit)
    size = np.max([np.abs(s.predicted.torque).max(axis=0) for s in fit.sessions], axis=0)
    breakaways = np.unique([t.values["breakaway_nm"] for t in trials(GAP, now.joints, size)], axis=0)
    found = {}
    for j in range(now.joints):
        none = now.with_gap(j, 0.0, 0.0, 0).residuals()
        found[j] = min((_Flanks.of(now, j, b[j], none=none) for b in breakaways), key=lambda f: f.chi2)
    where: list[int] = []
    while rest := [j for j in found if j not in where]:
        # what one joint explains is no longer there for the next
        again = {j: found[j] if not where else _Flanks.of(now, j, found[j].breakaway) for j in rest}
        best = min(rest, key=lambda j: again[j].chi2)
        if again[best].before - again[best].chi2 < PART * above:
            break
        where.append(best)
        now = now.with_flanks(again[best])
    if not where:
        return None
    for _ in range(ROUNDS):
        now, before = now.refitted(where), now.signs()
        for j in where:
            now = now.with_flanks(_Flanks.of(now, j, now.values[GAP.name]["breakaway_nm"][j]))
        if np.array_equal(now.signs(), before):
            break
    sure = [_Flanks.of(now, j, now.values[GAP.name]["breakaway_nm"][j], sure=SURE * now.misfit**2) for j in where]
    for flanks in sure:
        now = now.with_flanks(flanks)
    told = int(sum(np.count_nonzero(f.sign) for f in sure))
    return ToldApproaches(tuple(now.sessions), tuple(sorted(where)), told, sum(len(f.sign) for f in sure))


@dataclass(frozen=True, repr=False, eq=False)
class _Point:
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
    def of(cls, fit: Fit, outliers: Sequence[tuple[str, int]]) -> _Point:
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
        _, states = problem.blocks(own, states)  # the arms come to rest
        out: list[Floats] = []
        for o, at, state in zip(problem.observations, problem.columns, states, strict=True):
            assert isinstance(o, SessionObservations)
            parts: dict[int, list[Floats]] = {int(k): [np.empty(0)] for k in np.unique(o.samples.setup)}
            for block in o.blocks(state, own, at)[0]:
                parts[int(o.samples.setup[block.rows[0]])].append(block.residual)
            out += [np.concatenate(part) for part in parts.values()]
        return out

    def with_gap(self, joint: int, gap: float, breakaway: float, sign: Ints | int | None = None) -> _Point:
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

    def with_flanks(self, found: _Flanks) -> _Point:
        return self.with_gap(found.joint, found.gap, found.breakaway, found.sign)

    def refitted(self, where: Sequence[int]) -> _Point:
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
class _Flanks:
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
        cls, at: _Point, joint: int, breakaway: float, *, sure: float = 0.0, none: Sequence[Floats] = ()
    ) -> _Flanks:
        """As the residuals tell, ``none`` without a gap; signs that make less than ``sure`` of chi-square are 0."""
        none = none or at.with_gap(joint, 0.0, breakaway, 0).residuals()
        plus, minus = ((at.with_gap(joint, PROBE, breakaway, s)).residuals() for s in (1, -1))
        up = [(a - b) / PROBE for a, b in zip(none, plus, strict=True)]
        down = [(a - b) / PROBE for a, b in zip(none, minus, strict=True)]
        m = [(a + b) / 2 for a, b in zip(up, down, strict=True)]
        d = [(a - b) / 2 for a, b in zip(up, down, strict=True)]
        begun = {float(at.values[GAP.name]["gap_rad"][joint]), 0.5 * PROBE, PROBE, 2 * PROBE, 4 * PROBE}
        gap, sign = min((_turned(none, m, d, g) for g in begun), key=lambda f: _left(none, m, d, *f))
        pull = np.array([4 * gap * float(b @ (r - gap * a)) for r, a, b in zip(none, m, d, strict=True)])
        sign = np.where(np.abs(pull) < max(sure, 1e-9), 0, sign)
        return cls(joint, breakaway, gap, sign, _square(none), _left(none, m, d, gap, sign))


def _turned(r: Sequence[Floats], m: Sequence[Floats], d: Sequence[Floats], gap: float) -> tuple[float, Ints]:
    """A gap of a flank that leads (the sign of the approach has no other meaning), and the signs."""
    sign = np.zeros(len(r), dtype=np.int64)
    for _ in range(TURNS):
        sign = np.array([1 if b @ (x - gap * a) >= 0 else -1 for x, a, b in zip(r, m, d, strict=True)], dtype=np.int64)
        c = [a + s * b for a, b, s in zip(m, d, sign, strict=True)]
        new = max(sum(float(a @ x) for a, x in zip(c, r, strict=True)) / max(_square(c), 1e-300), 0.0)
        if abs(new - gap) < 1e-9:
            break
        gap = new
    return gap, sign


def _left(r: Sequence[Floats], m: Sequence[Floats], d: Sequence[Floats], gap: float, sign: Ints) -> float:
    return _square([x - gap * (a + s * b) for x, a, b, s in zip(r, m, d, sign, strict=True)])


def _square(parts: Sequence[Floats]) -> float:
    return float(sum(x @ x for x in parts))


def _share(now: _Point, fit: Fit) -> float:
    """Readings that take part over those of the fit, which leaves some out to be scored."""
    return sum(int(u.sum()) for u in now.used) / max(sum(int(s.used.sum()) for s in fit.sessions), 1)
