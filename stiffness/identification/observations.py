"""Observations: what a fit is made to. A session is one kind; each brings its prediction and its weighting.

The object is constant. What changes from one evaluation to the next is its state, which goes in as an argument and
comes out as a result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers
from stiffness.identification.predicted_readings import PredictedReadings, SessionState
from stiffness.identification.prediction import SessionPredictor
from stiffness.identification.reading_slopes import Slopes
from stiffness.identification.session_data import SessionData
from stiffness.identification.station import Station
from stiffness.identification.unknowns import Unknowns
from stiffness.identification.weighting import Weighting
from stiffness.numerics.whitened import Whitened
from stiffness.session.samples import Samples
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
State = TypeVar("State")


class Observations(Protocol[State]):
    """What a fit problem asks of any kind of measured data."""

    @property
    def own_sd(self) -> Floats:
        """(S,) prior standard deviations of the numbers that belong to these data alone; they start at zero."""

    def first_state(self) -> State:
        """Where the first evaluation starts."""

    def blocks(
        self, state: State, vector: Floats, own: slice, more: Sequence[Slopes] = ()
    ) -> tuple[Sequence[Whitened], State]:
        """Whitened residuals in independent blocks, and the state that the next evaluation starts from.

        Args:
            vector: (V,) all numbers of the fit: parameters of the robot first, ``own``: where those of these data are.
            more: derivatives of the readings by further numbers, whose columns follow.
        """

    def spent(self, state: State) -> int:
        """Numbers that free offsets inside the blocks take up."""


@dataclass(frozen=True, repr=False, eq=False)
class SessionObservations:
    """One session, ready to be fitted: its data, their prediction for one layout of free numbers, their weighting, and
    whether its registration is taken as it was declared (``exact``)."""

    data: SessionData
    predictor: SessionPredictor
    weighting: Weighting
    exact: bool = False

    @classmethod
    def of(
        cls, data: SessionData, weighting: Weighting, unknowns: Unknowns, fixed: Mapping[str, Numbers]
    ) -> SessionObservations:
        """A session against a model whose free numbers are ``unknowns``; all others have ``fixed`` values."""
        return cls(data, SessionPredictor.of(data, unknowns, fixed), weighting)

    def __repr__(self) -> str:
        return f"SessionObservations({self.session.source!r}, {len(self.samples)} readings)"

    @property
    def session(self) -> Session:
        """What was measured."""
        return self.data.session

    @property
    def samples(self) -> Samples:
        """Its readings."""
        return self.data.session.samples

    @property
    def own_sd(self) -> Floats:
        """(S,) prior standard deviations of the station's numbers, m and rad."""
        station = self.data.station
        return station.prior_sd(self.exact) if isinstance(station, Station) else station.prior_sd()

    def first_state(self) -> SessionState:
        """Undeflected arms, no load history, all readings in use."""
        return self.predictor.first_state()

    def blocks(
        self, state: SessionState, vector: Floats, own: slice, more: Sequence[Slopes] = ()
    ) -> tuple[list[Whitened], SessionState]:
        """As ``Observations.blocks``; a block is a set-up."""
        seen = self.predict(state, vector, own)
        return self.weighting.blocks(seen, own, len(vector), more), seen.state

    def predict(self, state: SessionState, vector: Floats, own: slice) -> PredictedReadings:
        """Readings for all numbers of a fit (V,)."""
        return self.predictor.predict(state, vector[: len(self.predictor.unknowns)], vector[own])

    def blocks_near(self, state: SessionState, vector: Floats, own: slice) -> list[Whitened]:
        """As ``blocks``, of arms that ended in ``state`` with other joint states."""
        seen = self.predictor.predict_near(state, vector[: len(self.predictor.unknowns)], vector[own])
        return self.weighting.blocks(seen, own, len(vector))

    def spent(self, state: SessionState) -> int:
        """Numbers that free offsets of reflectors take up."""
        return self.weighting.spent(state.used)

    def with_memory_values(self, fixed: Mapping[str, Numbers]) -> SessionObservations:
        """The same with other values of numbers that only the rules of joint memories read."""
        return replace(self, predictor=self.predictor.with_memory_values(fixed))
