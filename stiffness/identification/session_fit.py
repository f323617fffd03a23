"""Session fit: one session as a fit left it: the numbers, the readings in use, the prediction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stiffness.identification.observations import SessionObservations
from stiffness.identification.predicted_readings import PredictedReadings, SessionState
from stiffness.numerics.whitened import Whitened
from stiffness.session.samples import Samples
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, repr=False, eq=False)
class SessionFit:
    """One session of a fit.

    Attributes:
        vector: (V,) all numbers of the fit; ``columns``: where those of this session stand in it.
        state: where the fit ended.
    """

    observations: SessionObservations
    vector: Floats
    columns: slice
    state: SessionState

    def __repr__(self) -> str:
        return f"SessionFit({self.session.source!r}, {int(self.used.sum())} readings used)"

    @property
    def session(self) -> Session:
        """What was measured."""
        return self.observations.session

    @property
    def samples(self) -> Samples:
        """Its readings."""
        return self.observations.samples

    @property
    def used(self) -> Bools:
        """(N,) readings that took part."""
        return self.state.used

    @property
    def allowed(self) -> Bools:
        """(N,) readings that may take part."""
        return self.state.allowed

    @property
    def own(self) -> Floats:
        """(S,) numbers of the session's station."""
        return self.vector[self.columns]

    @cached_property
    def reflectors(self) -> Floats:
        """(R, 3) m, every reflector in the frame of its link."""
        return self.observations.data.station.reflectors(self.own)

    @cached_property
    def predicted(self) -> PredictedReadings:
        """The readings that the fit predicts."""
        return self.observations.predict(self.state, self.vector, self.columns)

    def further(self) -> SessionFit:
        """The same, its iteration of statics and joint memory carried on by one prediction."""
        return replace(self, state=self.predicted.state)

    def blocks(self) -> list[Whitened]:
        """Whitened residuals of the readings in use, set-up by set-up."""
        return self.observations.blocks(self.predicted.state, self.vector, self.columns)[0]
