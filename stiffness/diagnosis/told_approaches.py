"""Told approaches: on which flank a joint came to rest, read off the readings where a session has no approach columns.

Without them the state of a gap is not known until a torque chooses it, and a gap that no torque chooses is not seen at
all. Yet a joint stands on one of two flanks in every set-up. With the readings' derivatives by a gap, m where a torque
chooses the flank and d where the approach does (+ or -), the residual of set-up i is

    r_i = g (m_i + s_i d_i) + noise        s_i = +1 or -1, one gap g for all

and g and the s_i follow in turn (a mixture of two with one distance). Random rotations z of a joint lose
(mean |z|)^2 / mean z^2 of their square to the best signs, two thirds of a normal distribution; two flanks lose all. So
the signs are tried in a whole diagnosis and stand where it is left with hardly anything.

All signs of a joint the other way round, with a link that rests on the other side, are the same readings: which side a
rotation leaves the link on stays open, and its standard deviation says so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.candidates import trials
from stiffness.diagnosis.flanks import Flanks, OnTrial, square, without_approaches
from stiffness.diagnosis.result import AddedEffect, Diagnosis
from stiffness.diagnosis.searched_numbers import NORMAL
from stiffness.effects import BY_NAME
from stiffness.effects.backlash import EFFECT as GAP
from stiffness.identification.fit import Fit
from stiffness.session.session import Session

# studied in tests/stiffness/diagnosis/test_told_approaches.py
PART = 0.1  # of what is above the noise: a joint whose two flanks explain less is left
ROUNDS = 3  # of signs and a fit of all numbers
SURE = 9.0  # of chi-square over the misfit: signs that differ by less are not told
OPEN = 1 / NORMAL  # a side that is +1 or -1, its interval from one to the other
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
            f"{self.told} of {self.of} are told. They do not tell on which side of its gap a rotation leaves a link: "
            f"{GAP.name}.side is its default, and a path on which the joint reverses may be corrected the wrong way. "
            "Columns approach1 ... tell it, and the rest"
        )

    def with_open_side(self, found: Diagnosis) -> Diagnosis:
        """A diagnosis of these sessions that says that the side of a gap is not told."""
        own = found.model.sd.get(GAP.name)
        if own is None:
            return found
        side = own["side"].copy()
        side[list(self.where)] = OPEN
        model = replace(found.model, sd={**found.model.sd, GAP.name: {**own, "side": side}})
        return replace(found, model=model, added=tuple(_with_side(a, side) for a in found.added))


MISSING = (
    "no approach columns: on which flank a joint came to rest is not known where no torque chooses it; what is left "
    "may be a gap, a softer flank or friction. Add columns approach1 ... (the sign of the last rotation of each joint "
    "before the set-up)"
)


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
        return told.with_open_side(other)
    return replace(found, notes=(*found.notes, MISSING))


def told_approaches(fit: Fit, outliers: Sequence[tuple[str, int]]) -> ToldApproaches | None:
    """What the readings of a fit tell of approaches; None where two flanks of no joint explain a part of its residual.

    Args:
        outliers: (session, line) of readings that take no part.
    """
    now = OnTrial.of(fit, outliers)
    above = square(now.residuals()) - fit.solution.freedom * _share(now, fit)
    size = np.max([np.abs(s.predicted.torque).max(axis=0) for s in fit.sessions], axis=0)
    breakaways = np.unique([t.values["breakaway_nm"] for t in trials(GAP, now.joints, size)], axis=0)
    found = {}
    for j in range(now.joints):
        none = now.with_gap(j, 0.0, 0.0, 0).residuals()
        found[j] = min((Flanks.of(now, j, b[j], none=none) for b in breakaways), key=lambda f: f.chi2)
    where: list[int] = []
    while rest := [j for j in found if j not in where]:
        # what one joint explains is no longer there for the next
        again = {j: found[j] if not where else Flanks.of(now, j, found[j].breakaway) for j in rest}
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
            now = now.with_flanks(Flanks.of(now, j, now.values[GAP.name]["breakaway_nm"][j]))
        if np.array_equal(now.signs(), before):
            break
    sure = [Flanks.of(now, j, now.values[GAP.name]["breakaway_nm"][j], sure=SURE * now.misfit**2) for j in where]
    for flanks in sure:
        now = now.with_flanks(flanks)
    told = int(sum(np.count_nonzero(f.sign) for f in sure))
    return ToldApproaches(tuple(now.sessions), tuple(sorted(where)), told, sum(len(f.sign) for f in sure))


def _with_side(a: AddedEffect, sd: npt.NDArray[np.float64]) -> AddedEffect:
    """An added gap with standard deviations (n,) of its side."""
    if a.effect != GAP.name:
        return a
    values, _, unit = a.parameters["side"]
    own = sd[[int(joint.removeprefix("joint-")) - 1 for (joint,) in a.sites]]
    return replace(a, parameters={**a.parameters, "side": (values, own, unit)})


def _share(now: OnTrial, fit: Fit) -> float:
    """Readings that take part over those of the fit, which leaves some out to be scored."""
    return sum(int(u.sum()) for u in now.used) / max(sum(int(s.used.sum()) for s in fit.sessions), 1)
