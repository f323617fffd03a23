"""Fit problem: observations, the layout of the free numbers, and what is known of them beforehand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers
from stiffness.identification.observations import Observations, SessionObservations
from stiffness.identification.reading_slopes import Slopes
from stiffness.identification.session_data import SessionData
from stiffness.identification.session_fit import SessionFit
from stiffness.identification.unknowns import Unknowns
from stiffness.identification.weighting import Weighting
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import EXACT, Ending, Solution, solve
from stiffness.numerics.whitened import Whitened

Floats = npt.NDArray[np.float64]
States = tuple[Any, ...]  # one per observations, each of its own kind

# studied in tests/stiffness/identification/test_fit_problem.py
LOOSE = 3000.0  # typical sizes: a wrist of a light arm yields a hundred times as much as a heavy arm
LOOSE_DIRECT = 5.0  # typical sizes, of numbers that are not the inverse of a stiffness


@dataclass(frozen=True, repr=False, eq=False)
class Problem:
    """A least-squares problem: parameters of the robot (P,), then the own numbers of every observations.

    Attributes:
        unknowns: layout of the parameters.
        fixed: values of what is not free, and where the free ones start.
        observations: what they are fitted to.
        parameter_sd: (P,) prior standard deviations about the start.
    """

    unknowns: Unknowns
    fixed: Mapping[str, Numbers]
    observations: tuple[Observations[Any], ...]
    parameter_sd: Floats

    @classmethod
    def of_sessions(
        cls,
        data: Sequence[SessionData],
        weightings: Sequence[Weighting],
        unknowns: Unknowns,
        fixed: Mapping[str, Numbers],
        prior: ComplianceModel | None = None,
    ) -> Problem:
        """Sessions of one robot; the standard deviations of ``prior`` are prior knowledge, all else is loose."""
        sd = loose_sd(unknowns, fixed)
        observations = tuple(
            SessionObservations.of(d, w, unknowns, fixed) for d, w in zip(data, weightings, strict=True)
        )
        return cls(unknowns, fixed, observations, sd if prior is None else _known_sd(unknowns, prior, fixed, sd))

    def __repr__(self) -> str:
        return f"Problem({self.unknowns!r}, {len(self.observations)} observations)"

    @cached_property
    def columns(self) -> tuple[slice, ...]:
        """Where the own numbers of each observations stand."""
        sizes = [len(o.own_sd) for o in self.observations]
        ends = len(self.unknowns) + np.cumsum(sizes)
        return tuple(slice(int(end) - size, int(end)) for end, size in zip(ends, sizes, strict=True))

    @cached_property
    def start(self) -> Floats:
        """(V,) where a fit begins, and the mean of the prior."""
        first = self.unknowns.start(self.fixed)
        return np.concatenate([first, np.zeros(self.columns[-1].stop - len(first))])

    @cached_property
    def sd(self) -> Floats:
        """(V,) prior standard deviations."""
        return np.concatenate([self.parameter_sd, *(o.own_sd for o in self.observations)])

    def with_memory_values(self, fixed: Mapping[str, Numbers]) -> Problem:
        """The same with other values of numbers that only the rules of joint memories read."""
        observations = tuple(
            o.with_memory_values(fixed) if isinstance(o, SessionObservations) else o for o in self.observations
        )
        return replace(self, fixed=fixed, observations=observations)

    def surprise(self, vector: Floats) -> float:
        """Chi-square of the robot's parameters against the prior."""
        off = (vector - self.start)[: len(self.unknowns)] / self.parameter_sd
        return float(off @ off)

    def first_states(self) -> States:
        """Where the first evaluation starts."""
        return tuple(o.first_state() for o in self.observations)

    def blocks(
        self, vector: Floats, states: States, more: Sequence[Sequence[Slopes]] | None = None
    ) -> tuple[list[Whitened], States]:
        """Whitened residuals of all observations at ``vector`` (V,), and where the next evaluation starts.

        Args:
            more: of each observations, derivatives by further numbers, whose columns follow.
        """
        out: list[Whitened] = []
        after = []
        for k, (o, at) in enumerate(zip(self.observations, self.columns, strict=True)):
            found, state = o.blocks(states[k], vector, at, () if more is None else more[k])
            out += found
            after.append(state)
        return out, tuple(after)

    def solved(
        self,
        states: States,
        start: Floats | None = None,
        *,
        widened: float = 1.0,
        bounded: bool = True,
        held: Floats | None = None,
        ending: Ending = EXACT,
    ) -> tuple[Solution, States]:
        """Least squares.

        Args:
            start: (V,) first vector; None: the mean of the prior.
            widened: factor on the noise: the prior of the robot's parameters weighs so much more.
            bounded: whether parameters stay within what their effects allow.
            held: (K, V) combinations of the numbers that stay at the mean of the prior, in standard deviations.
            ending: what ends the iteration.
        """
        low, high = self.bounds()
        infinite = np.full(len(self.start), np.inf)
        return solve(
            self.blocks,
            self.start if start is None else start,
            states,
            prior=self.start,
            # the station stays free: what it cannot take would end up in the robot
            prior_sd=np.concatenate([self.parameter_sd / widened, self.sd[len(self.unknowns) :]]),
            low=low if bounded else -infinite,
            high=high if bounded else infinite,
            held=held,
            ending=ending,
            spent=sum(o.spent(s) for o, s in zip(self.observations, states, strict=True)),
        )

    def bounds(self) -> tuple[Floats, Floats]:
        """(V,) what the effects allow."""
        low, high = self.unknowns.bounds()
        free = np.full(len(self.start) - len(low), np.inf)
        return np.concatenate([low, -free]), np.concatenate([high, free])

    def sessions(self, vector: Floats, states: States) -> tuple[SessionFit, ...]:
        """The sessions among the observations, with the numbers ``vector`` (V,)."""
        return tuple(
            SessionFit(o, vector, columns, state)
            for o, columns, state in zip(self.observations, self.columns, states, strict=True)
            if isinstance(o, SessionObservations)
        )

    def setups(self, vector: Floats, states: States) -> list[list[Whitened]]:
        """Whitened residuals at ``vector`` (V,), the blocks of every set-up of every session together."""
        out: list[list[Whitened]] = []
        for o, at, state in zip(self.observations, self.columns, states, strict=True):
            own: dict[int, list[Whitened]] = {}
            for k, b in enumerate(o.blocks(state, vector, at)[0]):
                setup = int(o.samples.setup[b.rows[0]]) if isinstance(o, SessionObservations) else k
                own.setdefault(setup, []).append(b)
            out += own.values()
        return out


def loose_sd(layout: Unknowns, fixed: Mapping[str, Numbers], inverse: float = LOOSE) -> Floats:
    """(P,) how far a number may be from its start where nothing else is known: loose, but in the right world. Typical
    sizes are those of a heavy arm: links, base and tool of a light one yield more, as its joints do."""
    loose = np.where(layout.inverse, inverse, LOOSE_DIRECT) * layout.scale
    yields = np.array([u.parameter.yields for u in layout.free], dtype=bool)
    loose = np.where(yields, _softness(layout, fixed) * loose, loose)
    told = [u.parameter.prior_sd for u in layout.free]
    return np.array([own if own is not None else sd for own, sd in zip(told, loose.tolist(), strict=True)])


def _softness(layout: Unknowns, fixed: Mapping[str, Numbers]) -> float:
    """How many times as much the joints of an arm yield as typical ones, 1 at least."""
    known = [(p.scale, fixed[e.name][p.name]) for e in layout.effects if e.is_base for p in e.parameters]
    return max([1.0, *(float(np.median(scale / np.asarray(k))) for scale, k in known)])


def _known_sd(layout: Unknowns, prior: ComplianceModel, fixed: Mapping[str, Numbers], sd: Floats) -> Floats:
    """Standard deviations of a prior model where it has them."""
    out, first = sd.copy(), layout.start(fixed)
    for k, u in enumerate(layout.free):
        given = prior.sd.get(u.effect, {}).get(u.parameter.name)
        if given is not None and given[u.index] > 0:
            out[k] = given[u.index] * first[k] ** 2 if u.inverse else given[u.index]
    return out
