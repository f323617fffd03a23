"""Fit: an identified model, how sure it is, and what the data do not determine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.effects.effect import Effect, Numbers
from stiffness.identification.coherence import hidden_bias
from stiffness.identification.gauge import Gauge
from stiffness.identification.learned_numbers import learned_numbers
from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.identification.prediction import SessionPredictor
from stiffness.identification.problem import Problem, States, loose_sd
from stiffness.identification.session_fit import SessionFit
from stiffness.identification.setup_statistics import SetupStatistics, moved_within_setups
from stiffness.identification.unknowns import Unknowns
from stiffness.model.correlations import Correlations
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import Solution, inverse
from stiffness.session.processes import process_of

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/identification/test_identify_trust.py, tests/effects_report
DOUBTFUL = 0.05  # false-positive rate: of fits that miss nothing, and yet have standard deviations by set-ups
DETERMINED = 0.5  # a stiffness whose standard deviation is a larger share of it is not identified
CLEAR = 1.15  # residual over noise from which structure is clear
UNSEEN = 3.0  # standard deviations of chi-square: so much structure a fit may hold that no test of its residual sees
LOADED = 30.0  # typical sizes of compliance: a joint whose data have a larger standard deviation is not loaded


@dataclass(frozen=True, repr=False, eq=False)
class Fit:
    """A model, and how it came about.

    Attributes:
        problem: what was fitted to what.
        solution: estimate and covariance.
        states: where the evaluation of every observations ended, with the rows that were used.
        notes: what was decided, and why.
        searched_sd: standard deviations of numbers that no derivative leads to, by effect and parameter.
        hidden: (P,) how far effects that the model lacks may have moved the numbers, where a search tells.
    """

    problem: Problem
    solution: Solution
    states: States
    notes: tuple[str, ...] = ()
    searched_sd: Mapping[str, Mapping[str, Floats]] = field(default_factory=dict)
    hidden: Floats | None = None

    def __repr__(self) -> str:
        return f"Fit({', '.join(e.name for e in self.unknowns.effects)}, {self.solution.count} numbers)"

    @property
    def unknowns(self) -> Unknowns:
        """Layout of the parameters."""
        return self.problem.unknowns

    @property
    def fixed(self) -> Mapping[str, Numbers]:
        """Values of what was not free."""
        return self.problem.fixed

    @cached_property
    def sessions(self) -> tuple[SessionFit, ...]:
        """The sessions that were fitted to, as the fit left them."""
        return self.problem.sessions(self.solution.vector, self.states)

    @property
    def parameters(self) -> Floats:
        """(P,) as the solver sees them."""
        return self.solution.vector[: len(self.unknowns)]

    def surprise_of(self, effects: Iterable[str]) -> float:
        """Chi-square of the numbers of some effects against the prior."""
        names = set(effects)
        off = (self.parameters - self.problem.start[: len(self.unknowns)]) / self.problem.parameter_sd
        return float(sum(z**2 for u, z in zip(self.unknowns.free, off, strict=True) if u.effect in names))

    @cached_property
    def sd(self) -> Floats:
        """(P,) standard deviations; where more than noise may be left, widened by the misfit, or by what leaving out
        set-up after set-up does to the numbers."""
        variance = np.diag(self.solution.covariance)[: len(self.unknowns)]
        sd = np.asarray(np.sqrt(variance) * self.solution.misfit)
        doubtful = stats.chi2.sf(self.solution.chi2, max(self.solution.freedom, 1.0)) < DOUBTFUL
        return np.maximum(sd, self.by_setup.sd) if doubtful else sd

    @cached_property
    def by_setup(self) -> SetupStatistics:
        """What the residuals tell set-up by set-up."""
        setups = self.problem.setups(self.solution.vector, self.states)
        return SetupStatistics.of(setups, self.solution.covariance, len(self.unknowns))

    @cached_property
    def gauge(self) -> Gauge:
        """Which directions of the parameters the data determine."""
        return Gauge.of(
            unit=loose_sd(self.unknowns, self.problem.fixed),
            scale=self.unknowns.scale,
            data=self.solution.information,
            sd=self.problem.sd,
            misfit=self.solution.misfit,
        )

    @property
    def lacks(self) -> str:
        """In one line that the residual is more than the noise explains; "" where it is not."""
        many = self.solution.misfit
        return f"this model lacks something: {many:.1f} times the noise is left; run diagnose" if many > CLEAR else ""

    def predicted_without(self, effect: Effect) -> tuple[PredictedReadings, ...]:
        """The readings of every session for the same numbers, one effect left out."""
        keep = [k for k, u in enumerate(self.unknowns.free) if u.effect != effect.name]
        effects = tuple(e for e in self.unknowns.effects if e is not effect)
        layout = Unknowns(effects, self.unknowns.joints, tuple(self.unknowns.free[k] for k in keep))
        fixed = {e.name: self.fixed[e.name] for e in effects}
        out = []
        for s in self.sessions:
            predictor = SessionPredictor.of(s.observations.data, layout, fixed)
            start = replace(predictor.first_state(), poses=s.state.poses)
            out.append(predictor.predict(start, self.parameters[keep], s.own))
        return tuple(out)

    def determined(self) -> npt.NDArray[np.bool_]:
        """(P,) what the data determine: a stiffness to half its value, by loads that bend its joint visibly; any other
        number to half of what was assumed, and not by the choice of one of several solutions alike."""
        return self._known

    @cached_property
    def _known(self) -> npt.NDArray[np.bool_]:
        told = (self.sd < DETERMINED * loose_sd(self.unknowns, self.problem.fixed)) & ~self.gauge.chosen
        some = self.sd < DETERMINED * np.abs(self.parameters)
        return np.where(self.unknowns.inverse, some & (self._loaded() | ~self.unknowns.springs), told)

    def _loaded(self) -> npt.NDArray[np.bool_]:
        """(P,) whether a number shows in the readings.

        Between the states of a set-up errors of the arm's geometry cancel: what differs there counts by its standard
        deviation. From set-up to set-up they do not: there a joint has to bend, over the torques that it has and
        beyond what other numbers imitate, twice as much as the model leaves of single readings.
        """
        size = np.abs(self.parameters)
        loose = max(self.solution.misfit**2 - 1, UNSEEN * np.sqrt(2 / max(self.solution.freedom, 1.0)))
        moves = size * moved_within_setups(self.sessions, self.unknowns.inverse) * DETERMINED > self.solution.misfit
        return np.asarray(moves | (size * self.by_setup.signal * DETERMINED > np.sqrt(loose)))

    def values(self) -> dict[str, dict[str, Floats]]:
        """Values per effect and parameter; a table is zero where no reading was, or where it was not learned."""
        return self.unknowns.values(np.where(self.learned(), self.parameters, 0.0), self.fixed)

    def learned(self) -> npt.NDArray[np.bool_]:
        """(P,) false for numbers of tables that no reading has, or that lie far out of the spread of their table."""
        return learned_numbers(self.unknowns, self.parameters, self._seen, loose_sd(self.unknowns, self.problem.fixed))

    @property
    def _seen(self) -> npt.NDArray[np.bool_]:
        return np.asarray(np.diag(self.solution.information)[: len(self.unknowns)] > 0)

    def allowed_values(self) -> dict[str, dict[str, Floats]]:
        """Values, with those that an effect does not allow moved to the nearest that it does, by how well they are
        known; all other numbers answer to it."""
        out = self.values()
        for e in self.unknowns.effects:
            if not e.nearest or not e.check(out[e.name]):
                continue
            own = [k for k, u in enumerate(self.unknowns.free) if u.effect == e.name]
            if len(own) < sum(p.count(self.unknowns.joints) for p in e.parameters):
                out[e.name] = e.nearest(out[e.name])
                continue
            covariance = self.solution.covariance[: len(self.unknowns), own]
            precision = inverse(covariance[own])
            allowed = e.nearest(out[e.name], precision)
            moved = np.concatenate([allowed[p.name] - out[e.name][p.name] for p in e.parameters])
            low, high = self.unknowns.bounds()
            answer = np.clip(self.parameters + covariance @ precision @ moved, low, high)
            out = self.unknowns.values(np.where(self.learned(), answer, 0.0), self.fixed) | {e.name: allowed}
        return out

    def deviations(self) -> dict[str, dict[str, Floats]]:
        """Of numbers of the model file, by effect and parameter, with what a missing effect may hide; 0 where given."""
        n = self.unknowns.joints
        out = {e.name: {p.name: np.zeros(p.count(n)) for p in e.parameters} for e in self.unknowns.effects}
        for u, value, sd in zip(self.unknowns.free, self.parameters, np.hypot(self.sd, self._hidden), strict=True):
            out[u.effect][u.parameter.name][u.index] = sd / value**2 if u.inverse else sd
        for name, numbers in self.searched_sd.items():
            out[name] = {**out[name], **{k: np.array(v) for k, v in numbers.items()}}
        return out

    @property
    def _hidden(self) -> Floats | float:
        if self.hidden is not None:
            return self.hidden
        return hidden_bias(self.solution, self.sessions)[: len(self.unknowns)] if self.solution.misfit > 1 else 0.0

    def condition_number(self) -> float | None:
        """Of the design: largest over smallest singular value of the directions that the data determine; None where
        they determine none."""
        singular = self.gauge.singular[0]
        return float(singular[-1] / singular[0]) if len(singular) else None

    def observability(self) -> dict[str, float]:
        """Observability indices of the design in the directions that the data determine, numbers scaled to their
        typical size (Nahvi & Hollerbach 1996). o1: geometric mean of the singular values (Borm & Menq); o2: smallest
        over largest (Driels & Pathre); o3: smallest (Nahvi); o4: smallest squared over largest, the noise amplification
        index. Per root of the numbers."""
        counts = {"determined": self.gauge.count, "undetermined": len(self.unknowns) - self.gauge.count}
        if not self.gauge.count:
            return {"o1": 0.0, "o2": 0.0, "o3": 0.0, "o4": 0.0, **counts}
        singular = self.gauge.singular[0] / np.sqrt(self.solution.count)
        low, high = float(singular[0]), float(singular[-1])
        mean = float(np.exp(np.mean(np.log(singular))))
        return {"o1": mean, "o2": low / high, "o3": low, "o4": low**2 / high, **counts}

    def not_identified(self) -> list[str]:
        """What the data do not determine, in the user's words."""
        out: list[str] = []
        unseen: dict[tuple[str, str, int], list[int]] = {}
        visible = loose_sd(self.unknowns, self.problem.fixed, LOADED)
        diagonal = np.diag(self.solution.information)[: len(self.unknowns)] * visible**2
        for u, ok, told in zip(self.unknowns.free, self.determined(), diagonal, strict=True):
            if not ok:
                if u.parameter.each > 1:
                    table = u.parameter.meaning, u.effect, u.index // u.parameter.each + 1
                    unseen.setdefault(table, []).append(u.index)
                    continue
                place = f"joint {u.index + 1}" if u.parameter.size == "joint" else f"number {u.index + 1}"
                why = "no reading loads it" if told < 1 else "not told apart from other numbers, or from noise"
                out.append(f"{u.parameter.meaning} ({u.effect}) of {place}: {why}")
        for (meaning, effect, joint), rows in unseen.items():
            out.append(f"{meaning} ({effect}) of joint {joint}: {len(rows)} numbers, angles that no reading has")
        for k in np.flatnonzero(self._seen & ~self.learned()):
            u = self.unknowns.free[k]
            at = f"joint {u.index // u.parameter.each + 1}, number {u.index % u.parameter.each + 1}"
            out.append(
                f"{u.parameter.meaning} ({u.effect}) of {at}: {self.parameters[k]:.2g} {u.parameter.unit} is far out "
                "of its table: hardly a reading reaches it, or a wrong one"
            )
        return out

    def outlier_rows(self) -> list[tuple[str, int]]:
        """(session, line of samples.csv) of every row that was left out."""
        return [(s.session.source, int(line)) for s in self.sessions for line in s.samples.line[~s.used]]

    def model(self, robot: str, provenance: Mapping[str, object]) -> ComplianceModel:
        """The fit as a model of ``robot`` (name or path, as it shall stand in the model file)."""
        first, cut = self.sessions[0].session, process_of([s.session for s in self.sessions])
        reference = first.reference_temperature
        return ComplianceModel(
            source="",
            robot=robot,
            gravity=first.gravity,
            reference_temperature=20.0 if reference is None else reference,
            base=first.robot.base,
            tip=first.robot.tip,
            values=self.allowed_values(),
            sd=self.deviations(),
            identified=self.identified(),
            tools={e.name: first.tool.name for e in self.unknowns.effects if e.scope == "tool"},
            processes={e.name: cut for e in self.unknowns.effects if e.scope == "process"},
            provenance=dict(provenance),
            correlations=self.correlations(),
        )

    def identified(self) -> dict[str, npt.NDArray[np.bool_]]:
        """(n,) which joints' springs the data determine, of effects where they do not of all."""
        known, out = self.determined(), {}
        for e in self.unknowns.effects:
            flags = np.ones(self.unknowns.joints, dtype=bool)
            for u, ok in zip(self.unknowns.free, known, strict=True):
                if u.effect == e.name and u.parameter.size == "joint" and u.inverse:
                    flags[u.index] &= ok
            if not flags.all():
                out[e.name] = flags
        return out

    def correlations(self) -> Correlations | None:
        """Between the robot's numbers that are determined, as the solver sees them; an inverse turns the sign."""
        # tables are left out: hundreds of numbers, and their neighbours are what correlates; so is what is not known
        known = self.determined()
        own = [k for k, u in enumerate(self.unknowns.free) if u.parameter.each == 1 and known[k]]
        if not own:
            return None
        turn = np.where(self.unknowns.inverse[own], -1.0, 1.0)
        covariance = self.solution.covariance[np.ix_(own, own)] * np.outer(turn, turn)
        return Correlations.of(tuple(str(self.unknowns.free[k]) for k in own), 0.5 * (covariance + covariance.T))
