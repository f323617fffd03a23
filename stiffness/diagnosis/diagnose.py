"""Diagnose: find what a model lacks in measured data, add it, and say how much better that is on unseen readings."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, Bench
from stiffness.diagnosis.alternatives import Rival, candidates, rivals
from stiffness.diagnosis.attribution import Share, attribution
from stiffness.diagnosis.coherence import coherent
from stiffness.diagnosis.moved_parameters import changed_numbers
from stiffness.diagnosis.refined_model import refined_model
from stiffness.diagnosis.result import Added, Candidate, Changed, Diagnosis, Line, Verdict
from stiffness.diagnosis.search import Search
from stiffness.effects.effect import part_of
from stiffness.errors import StiffnessError
from stiffness.identification import scores
from stiffness.identification.evaluate import evidence_of, place, shown_effects
from stiffness.identification.fit import Fit
from stiffness.identification.identify import cleaned, one_robot
from stiffness.model.model import ComplianceModel
from stiffness.planning.next_setups import NextSetup, splitting, spread
from stiffness.session.repeats import with_repeats
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Say = Callable[[str], None]

FEWEST = 8  # set-ups; with fewer, leaving some out leaves nothing
HELD = 5  # every fifth set-up takes part in nothing
CLEAR = 1.15  # residual over noise from which structure is clear
NOTICED = 1e-4  # chance of a residual that noise alone would leave
SLIGHT = 0.1  # of what was above the noise: so much may stay when an explanation is right but its law not exact
SLIGHTLY = 1.3  # residual over noise that a law which is not exact may leave
WRONG_SETUPS = 0.02  # of all set-ups that may be wrong as a whole
CRUMB = 0.03  # of what was above the noise: an addition that explains less beside others is none
PARTLY = 0.2  # of what was above the noise: an effect that explains less is not called the explanation


def diagnose(sessions: Sequence[Session], model: ComplianceModel, say: Say = lambda text: None) -> Diagnosis:
    """Compare sessions of one robot with a model.

    Raises:
        StiffnessError: the sessions are not of one robot, or not of the kind the model was made with.
    """
    one_robot(sessions)
    for s in sessions:
        if s.gravity != model.gravity:
            raise StiffnessError(
                f"{s.source}: gravity = {s.gravity!r}, but the model {model.source} was made with {model.gravity!r}: "
                "what its stiffness carries is not the same"
            )
    notes = []
    believed = []
    for s in sessions:
        session, found = with_repeats(s)
        believed.append(session)
        if found.sentence:
            notes.append(f"{s.source}: {found.sentence}")
    return _Case(tuple(believed), model, say, notes).diagnosis()


class _Case:
    """One diagnosis on its way."""

    def __init__(self, sessions: tuple[Session, ...], model: ComplianceModel, say: Say, notes: list[str]) -> None:
        self.sessions, self.model, self.say, self.notes = sessions, model, say, notes
        self.effects = shown_effects(model, sessions[0])
        self.values = {e.name: model.values[e.name] for e in self.effects}
        self.held = [_held(s) for s in sessions]
        self.base_rms: float | None = None
        self.enough = sum(len(np.unique(s.samples.setup)) for s in sessions) >= FEWEST

    def diagnosis(self) -> Diagnosis:
        bench = Bench(self.sessions, self.effects, self.values, [~h for h in self.held])
        self.say("fitting the model's own parameters")
        base = _sound(cleaned(bench.fit([]), None))
        bench.used = [e.used.copy() for e in base.evidence]
        base = bench.fit([], base)
        search = Search(bench, self.say)
        fit, additions, found = base, list[Addition](), list[Rival]()
        ranking: list[Candidate] = []
        points: list[Share] = []
        left = False
        if self.enough:
            self.say("comparing effects")
            ranking, self.base_rms = candidates(search, base)
            fit, additions = search.run(base)
            fit, additions, found = rivals(search, fit, additions, base)
            fit, additions = self._without_crumbs(search, fit, additions, found)
            fit, additions, left, points = self._judged(search, base, fit, additions)
        # beside structure that nobody understands, the model's own numbers bend: no shift of theirs is believed
        changed = changed_numbers(bench, self.model, base, fit, additions) if self.enough and not left else []
        verdict = self._verdict(left, additions, changed, base)
        kept = [r for r in found if any(a.effect is r.addition.effect for a in additions)]
        return self._written(bench, base, fit, additions, kept, changed, verdict, ranking, points)

    def _without_crumbs(
        self, search: Search, fit: Fit, additions: list[Addition], found: Sequence[Rival]
    ) -> tuple[Fit, list[Addition]]:
        """Without additions that only polish what another explains: laws that are not exact to the last digit."""
        crumbs = {r.addition.effect.name for r in found if r.explains < CRUMB}
        kept = [a for a in additions if a.effect.name not in crumbs]
        if not crumbs or not kept:
            return fit, additions
        trial = search.bench.fit(kept, fit)
        if trial.solution.chi2 > SLIGHTLY**2 * trial.solution.freedom:
            return fit, additions
        return trial, search.bench.current(trial, kept)

    def _judged(
        self, search: Search, base: Fit, fit: Fit, additions: list[Addition]
    ) -> tuple[Fit, list[Addition], bool, list[Share]]:
        """Whether structure is left, where it sits, and which additions stand beside it."""
        self.say("looking where the rest sits")
        left, points = self._left(search, base, fit)
        while left and additions:
            doubtful = next((a for a in additions if self._doubtful(search, a, additions, base, fit, points)), None)
            if doubtful is None:
                break
            self.notes.append(
                f"{doubtful.effect.name} in {' '.join(doubtful.where)} would explain a part only, beside clear "
                "structure in the same place: not added"
            )
            additions = [a for a in additions if a is not doubtful]
            fit = search.bench.fit(additions, fit)
            additions = search.bench.current(fit, additions)
            left, points = self._left(search, base, fit)
        if not left:
            points = self._points(search, base)
        return fit, additions, left, points

    def _left(self, search: Search, base: Fit, fit: Fit) -> tuple[bool, list[Share]]:
        """Whether a fit leaves clear structure, and where."""
        misfit = float(np.sqrt(fit.solution.chi2 / max(fit.solution.freedom, 1.0)))
        above, first = _above(fit), _above(base)
        if stats.chi2.sf(fit.solution.chi2, max(fit.solution.freedom, 1.0)) > NOTICED or misfit < CLEAR:
            return False, []
        if fit is not base and misfit < SLIGHTLY and above < SLIGHT * first and first > 0:
            self.notes.append(
                f"what was added leaves {misfit:.2f} times the noise: its law is right, but not to the last digit"
            )
            return False, []
        points = self._points(search, fit)
        if (
            points
            or (fit is not base and above > PARTLY * first)
            or any(coherent(e, fit, k) for k, e in enumerate(fit.evidence))
        ):
            return True, points
        self.notes.append(
            f"the residual is {misfit:.2f} times the noise, but readings of one state do not agree on it and it "
            "follows nothing that was looked at: the instruments scatter more than their data sheet says"
        )
        return False, points

    def _points(self, search: Search, fit: Fit) -> list[Share]:
        seen = [e.predict(fit.parameters, fit.station(k)) for k, e in enumerate(fit.evidence)]
        if stats.chi2.sf(fit.solution.chi2, max(fit.solution.freedom, 1.0)) > NOTICED:
            return []
        return attribution(fit, search.screens(fit.evidence), seen)

    def _doubtful(
        self, search: Search, a: Addition, additions: Sequence[Addition], base: Fit, fit: Fit, points: Sequence[Share]
    ) -> bool:
        """Whether an addition only took the nearest name beside structure that is left."""
        without = search.bench.fit([b for b in additions if b is not a], fit)
        share = (_above(without) - _above(fit)) / max(_above(base), 1e-9)
        if share < PARTLY:
            return True
        places = [p.what for p in points if not p.what.startswith("column:")]
        beside = {part_of(w, search.bench.joints) for w in a.where}
        return share < 1 - PARTLY and (not places or part_of(places[0], search.bench.joints) in beside)

    def _verdict(self, left: bool, additions: Sequence[Addition], changed: Sequence[Changed], base: Fit) -> Verdict:
        if not self.enough:
            count = sum(len(np.unique(s.samples.setup)) for s in self.sessions)
            self.notes.append(f"{count} set-ups: fewer than {FEWEST} cannot tell; measure more postures")
            return "insufficient-data"
        if left:
            return "unexplained"
        if additions:
            return "explained"
        if changed:
            return "parameters-changed"
        return "insufficient-data" if self._mute(base) else "adequate"

    def _mute(self, base: Fit) -> bool:
        """Whether the session could not have shown anything: all that the model predicts drowns in noise."""
        if any(s.has_absolute for s in self.sessions):
            return False
        told = [base.determined()[k] for k, u in enumerate(base.unknowns.free) if u.effect == "joint-stiffness"]
        if any(told):
            return False
        self.notes.append("no joint's stiffness stands out from the noise of these readings: load the arm more")
        return True

    # ---- the lines that are written at the end

    def _written(
        self,
        bench: Bench,
        base: Fit,
        fit: Fit,
        additions: Sequence[Addition],
        found: Sequence[Rival],
        changed: Sequence[Changed],
        verdict: Verdict,
        ranking: Sequence[Candidate],
        points: Sequence[Share],
    ) -> Diagnosis:
        self.say("scoring on readings that took no part")
        moved = bool(additions or changed)
        whole = Bench(self.sessions, self.effects, self.values, [np.ones_like(h) for h in self.held])
        last = whole.fit(additions, fit)
        last = _sound(cleaned(last, None))
        whole.used = [e.used.copy() for e in last.evidence]
        last = whole.fit(additions, last)
        after = bench.sound(fit, additions) if moved else None
        lines = {kind: self._line(kind, base, after, last) for kind in ("displacement", "absolute")}
        allowed = whole.sound(last, additions)
        model = refined_model(self.model, allowed, last, additions) if moved else self.model
        added = tuple(_added(a, allowed, last, bench, found) for a in additions)
        held = tuple(
            tuple(np.unique(s.samples.setup[h]).tolist()) for s, h in zip(self.sessions, self.held, strict=True)
        )
        return Diagnosis(
            verdict,
            added,
            tuple(changed),
            lines,
            tuple(ranking),
            tuple(points),
            tuple(self._next(verdict, fit, found, points)),
            tuple(last.outlier_rows()),
            tuple(self.notes),
            model,
            base,
            fit,
            held,
            self.base_rms,
        )

    def _line(self, kind: str, base: Fit, after: Fit | None, last: Fit) -> Line | None:
        """Scores of the model as it was, refitted, and refined, on set-ups that took no part."""
        score = {"displacement": scores.displacement, "absolute": scores.absolute}[kind]
        every: list[list[scores.Score | None]] = [[], [], []]
        for k, (s, held) in enumerate(zip(self.sessions, self.held, strict=True)):
            sound = last.evidence[k].used
            rows = held if held.any() else np.ones_like(held)
            at_hand = evidence_of(s, self.model)
            at_hand.used = sound & (~held if held.any() else True)
            station = place(at_hand)
            at_hand.used = sound
            before = score(at_hand, at_hand.predict(np.zeros(0), station), rows)
            every[0].append(before)
            for n, fit in ((1, base), (2, after)):
                if fit is None:
                    every[n].append(before)
                    continue
                e, mask = fit.evidence[k], fit.evidence[k].used
                e.used = sound
                every[n].append(score(e, e.predict(fit.parameters, fit.station(k)), rows))
                e.used = mask
        before, refitted, now = (scores.pooled(found) for found in every)
        return None if before is None or refitted is None or now is None else Line(before, refitted, now)

    def _next(self, verdict: Verdict, fit: Fit, found: Sequence[Rival], points: Sequence[Share]) -> list[NextSetup]:
        for rival in found:
            for name, other in rival.fits.items():
                why = f"tells {rival.addition.effect.name} from {name}"
                return splitting(fit, other, why)
        if verdict == "unexplained":
            top = next((p.what for p in points if p.what.startswith("joint-")), None)
            joint = int(top.removeprefix("joint-")) - 1 if top else None
            return spread(
                self.sessions[0], joint, f"covers the range of {top or 'all joints'}, where structure is left"
            )
        if verdict == "insufficient-data":
            return spread(self.sessions[0], None, "more postures, each loaded across the arm")
        return []


def _held(session: Session) -> Bools:
    """(N,) readings of every fifth set-up of every block, in the order of the file."""
    s = session.samples
    out = np.zeros(len(s), dtype=bool)
    for block in np.unique(s.block):
        rows = np.flatnonzero(s.block == block)
        setups = list(dict.fromkeys(s.setup[rows].tolist()))
        if len(setups) >= FEWEST:
            out[rows] = np.isin(s.setup[rows], setups[HELD // 2 :: HELD])
    return out


def _sound(fit: Fit) -> Fit:
    """Rows that were left out come back where they are most of their set-up: that is structure, no wrong row."""
    for e in fit.evidence:
        s, out = e.samples, ~e.used & e.allowed
        setups = np.unique(s.setup[out])
        few = len(setups) <= max(1, WRONG_SETUPS * len(np.unique(s.setup)))
        for setup in setups:
            rows = (s.setup == setup) & e.allowed
            poses = len(np.unique(np.column_stack([s.state[rows], s.repeat[rows]]), axis=0))
            single = poses == 1 and e.session.group[s.reflector[rows]].max() >= 0  # one reading of a probe
            if np.mean(out[rows]) > 1 / 3 and not (single and few):
                e.used[rows] = True
    return fit


def _above(fit: Fit) -> float:
    """Chi-square above what noise leaves."""
    return max(fit.solution.chi2 - fit.solution.freedom, 0.0)


def _added(a: Addition, allowed: Fit, last: Fit, bench: Bench, found: Sequence[Rival]) -> Added:
    values, sd = allowed.values()[a.effect.name], last.deviations()[a.effect.name]
    parameters = {}
    for p in a.effect.parameters:
        if p.extra and not a.extras:
            continue
        if p.site not in {s.kind for s in a.sites}:
            continue
        every = range(p.count(bench.joints))
        at = list(dict.fromkeys(k for s in a.sites if s.kind == p.site for k in every[p.of_site(s.index)]))
        parameters[p.name] = (values[p.name][at], sd[p.name][at], p.unit)
    rival = next((r for r in found if r.addition.effect is a.effect), None)
    explains = rival.explains if rival else 0.0
    return Added(
        a.effect.name,
        a.where,
        parameters,
        explains,
        tuple(rival.fits) if rival else (),
        tuple(s.where for s in a.sites),
    )
